//! Small layered maps.

use std::ops::ControlFlow;

use dsm_core::{
    Error, HitSource, RayHits, RaySource, SamplePoint, ShadowCamera, SurfaceHit, TileHits,
    TileSamples, Transmittance, VolumeSample,
};
use dsm_io::detail::{Container, ErasedMap, KindReader, Kinds, MapKind, Memory};
use dsm_io::{Limits, Packing, WriteOptions};
use glam::{DMat4, DVec3, DVec4};
use mtsm::detail::{Layers, Mtsm, bake_layers, bake_mtsm};
use mtsm::{MultilayerBaker, MultilayerSettings};
use shadow_maps::detail::{
    Attenuation, AttenuationBuilder, FragmentBuilder, FragmentMap, Fragments, ListBuilder,
    PrefilterSettings, Prefiltered, PrefilteredMap, Views, ViewsBuilder, bake_fragments,
    bake_prefiltered, write_attenuation,
};

/// A source that says whether it has media.
struct Told<S> {
    source: S,
    has_media: bool,
}

impl<T: Transmittance, S: HitSource<T>> HitSource<T> for Told<S> {
    type Error = S::Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), S::Error> {
        self.source.hits(samples, hits)
    }

    fn has_media(&self) -> bool {
        self.has_media
    }
}

pub(crate) type Ray<T> = fn(SamplePoint, &mut RayHits<T>) -> Result<(), Error>;

/// Sheets and smoke that depend on the pixel; some pixels, and the last tile of
/// the first row, are empty.
fn ray<T: Transmittance>(point: SamplePoint, ray: &mut RayHits<T>) -> Result<(), Error> {
    let (x, y) = (point.x.floor() as u32, point.y.floor() as u32);
    if (x * 3 + y).is_multiple_of(4) || (x >= 4 && y < 4) {
        return Ok(());
    }
    for sheet in 0..=(x + y) % 5 {
        let shade = [0.5, 1.0, 0.25, 0.75][((x ^ sheet) % 4) as usize];
        let is_grey = y.is_multiple_of(2);
        let opacity = T::from_channels(|channel| {
            if is_grey || shade == 1.0 { shade } else { shade / (channel + 1) as f32 }
        });
        ray.push_surface(SurfaceHit { depth: 2.0 + sheet as f32 / 2.0, opacity })?;
    }
    if x == 2 {
        ray.push_slab(3.0, 5.0, T::splat(0.75))?;
    }
    Ok(())
}

/// The sheets alone: fragments are surfaces.
fn sheets<T: Transmittance>(point: SamplePoint, hits: &mut RayHits<T>) -> Result<(), Error> {
    let mut all = RayHits::default();
    ray(point, &mut all)?;
    all.surfaces().iter().try_for_each(|&surface| hits.push_surface(surface))
}

/// The sheets in fog of which pixels have more or less, or nothing.
fn fog<T: Transmittance>(point: SamplePoint, hits: &mut RayHits<T>) -> Result<(), Error> {
    sheets(point, hits)?;
    let (x, y) = (point.x.floor() as u32, point.y.floor() as u32);
    let dense = (x + 2 * y) % 5;
    if x < 4 && dense > 0 {
        let samples = [0.0, 1.0, 0.25, 0.0].into_iter().zip([1.0, 2.0, 2.5, 4.0]);
        let samples = samples.map(|(share, depth)| {
            let is_grey = x == 1;
            let tint = |channel| if is_grey { 1.0 } else { 1.0 / (channel + 1) as f32 };
            let extinction = T::from_channels(|channel| share * dense as f32 * tint(channel));
            VolumeSample { depth, extinction }
        });
        hits.push_volume(&samples.collect::<Vec<_>>(), point.distance_per_depth)?;
    }
    Ok(())
}

pub(crate) fn settings() -> MultilayerSettings {
    let mut settings = MultilayerSettings::new([6, 5]).unwrap();
    settings.bake.tile_size = 4;
    settings.light_depth = 0.25;
    settings
}

pub(crate) fn baker<T: Transmittance>() -> MultilayerBaker<T, RaySource<Ray<T>>> {
    let source: RaySource<Ray<T>> = RaySource(ray::<T>);
    MultilayerBaker::new(source, settings()).unwrap()
}

/// The sheets, without smoke.
pub(crate) fn source() -> RaySource<Ray<f32>> {
    RaySource(sheets::<f32>)
}

/// At the origin, looking down −z, 90 degrees wide.
fn camera() -> ShadowCamera {
    let to_ndc = DMat4::from_cols(
        DVec4::new(0.5, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5, 0.0, 0.0),
        DVec4::new(-0.5, -0.5, -1.0, -1.0),
        DVec4::ZERO,
    );
    ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) }
}

pub(crate) fn fragments() -> FragmentBuilder {
    let builder = FragmentBuilder::new(camera(), [6, 5], 0.25).unwrap();
    builder.with_coverage(2).unwrap().with_layers(32).unwrap()
}

/// The fragments of the same sheets.
pub(crate) fn fragment_map<T: Transmittance>() -> FragmentMap<T> {
    let source: RaySource<Ray<T>> = RaySource(sheets::<T>);
    fragments().build(&source).unwrap()
}

/// The same sheets in fog.
pub(crate) fn foggy_map<T: Transmittance>() -> FragmentMap<T> {
    let source: RaySource<Ray<T>> = RaySource(fog::<T>);
    fragments().build(&source).unwrap()
}

/// MIP levels and a stack of the same sheets.
pub(crate) fn lists() -> (ListBuilder, PrefilterSettings) {
    let builder = ListBuilder::new(camera(), [6, 5], 0.25).unwrap();
    (builder.with_layers(32).unwrap(), PrefilterSettings::default().with_stack_size(Some(3)))
}

/// The camera, moved to the right.
fn beside(x: f64) -> ShadowCamera {
    let mut eye = camera();
    let moved = DMat4::from_translation(DVec3::X * -x);
    eye.world_to_camera = Some(moved);
    eye.world_to_ndc = eye.world_to_ndc.map(|to_ndc| to_ndc * moved);
    eye
}

/// Views of the same sheets, which have one channel.
pub(crate) fn views() -> ViewsBuilder {
    let mut builder = ViewsBuilder::new(camera(), [6, 5]).unwrap();
    for x in [-0.25, 0.5] {
        let source: RaySource<Ray<f32>> = RaySource(sheets::<f32>);
        let eye = (DVec3::X * x, &beside(x));
        let added = builder.add_view(&source, eye, || ControlFlow::Continue(())).unwrap();
        assert!(added.is_continue());
    }
    builder
}

/// What two points of a light see of the same sheets.
pub(crate) fn attenuation<T: Transmittance>() -> AttenuationBuilder<T> {
    let mut builder = AttenuationBuilder::new(camera(), [6, 5]).unwrap();
    for x in [-0.25, 0.5] {
        let source: RaySource<Ray<T>> = RaySource(sheets::<T>);
        let eye = beside(x);
        let added = builder.add_view(&source, eye, || ControlFlow::Continue(())).unwrap();
        assert!(added.is_continue());
    }
    builder
}

/// The same map in memory.
pub(crate) fn list_map<T: Transmittance>() -> PrefilteredMap<T> {
    let (builder, settings) = lists();
    let source: RaySource<Ray<T>> = RaySource(sheets::<T>);
    let collected = builder.collect(&source, |_| ControlFlow::Continue(())).unwrap().unwrap();
    let (lists, _) = builder.sort(collected).unwrap();
    PrefilteredMap::new(*builder.frame(), lists, &settings, 0.0).unwrap()
}

/// The file of a map.
pub(crate) fn file<T: Transmittance>(kind: &str, packing: Packing) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let baker = baker::<T>();
    let watch = |_| ControlFlow::Continue(());
    let bytes = match kind {
        Mtsm::NAME => bake_mtsm(&baker, &path, packing, |_| {}, watch).unwrap().bytes,
        Layers::NAME => bake_layers(&baker, &path, packing, |_| {}, watch).unwrap().bytes,
        Prefiltered::NAME => {
            let source: RaySource<Ray<T>> = RaySource(sheets::<T>);
            let options = WriteOptions::default().with_tile_size(4).with_packing(packing);
            let (builder, settings) = lists();
            bake_prefiltered::<T, _>(&builder, &settings, &source, &path, options, |_| {}, watch)
                .unwrap()
                .bytes
        }
        Attenuation::NAME => {
            let builder = attenuation::<T>();
            let options = WriteOptions::default().with_tile_size(4).with_packing(packing);
            write_attenuation(&builder, &path, options, |_| {}).unwrap().bytes
        }
        Views::NAME => {
            let options = WriteOptions::default().with_tile_size(4).with_packing(packing);
            views().write(&path, options, |_| {}).unwrap().bytes
        }
        _ => {
            let ray = if kind == FOGGY { fog::<T> } else { sheets::<T> };
            let source = Told { source: RaySource(ray as Ray<T>), has_media: kind == FOGGY };
            let options = WriteOptions::default().with_tile_size(4).with_packing(packing);
            bake_fragments::<T, _>(&fragments(), &source, (&path, None), options, |_| {}, watch)
                .unwrap()
                .0
                .bytes
        }
    };
    let file = std::fs::read(&path).unwrap();
    assert_eq!(file.len() as u64, bytes);
    file
}

/// Fragments with media beside them.
pub(crate) const FOGGY: &str = "foggy";

/// All kinds of layered maps.
pub(crate) const KINDS: [&str; 7] = [
    Mtsm::NAME,
    Layers::NAME,
    Fragments::NAME,
    FOGGY,
    Prefiltered::NAME,
    Attenuation::NAME,
    Views::NAME,
];

pub(crate) fn open(bytes: Vec<u8>) -> dsm_io::detail::Result<Box<dyn ErasedMap>> {
    let limits = Limits::default();
    let kinds =
        Kinds::default().with::<Mtsm>().with::<Layers>().with::<Fragments>().with::<Prefiltered>();
    let kinds = kinds.with::<Attenuation>().with::<Views>();
    kinds.read(Container::from_source(Memory::from(bytes), &limits)?, &limits)
}

/// Opens a file of a kind that is known.
pub(crate) fn read<K: MapKind>(bytes: Vec<u8>) -> dsm_io::detail::Result<KindReader<K>> {
    KindReader::from_bytes(bytes, &Limits::default())
}
