//! Every kind of map in a file, and every method that reads it.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::Result;
use dsm_core::{
    AreaLight, BakeSettings, Baker, Filter, FilterShape, Footprint, LightVisibility, MapInfo,
    PixelSampling, Pyramid, ShadedPoint, ShadowLookup, Tolerance,
};
use dsm_io::{BakeOptions, Block, CachedShadow, Limits, TileCache, bake};
use dsm_scene::{Scene, SceneRasterizer, SceneReference, TracedScene, ViewRaster};
use dsm_testkit::{Agreement, Trial};
use glam::DVec3;
use mtsm::{
    DepthMap, DepthMapSettings, FilteredLayers, FragmentBuilder, FragmentTracer, LayeredReader,
    LightFrame, MultilayerBaker, MultilayerSettings, MultilayerTracer, PercentageCloserFilter,
    PercentageCloserShadow, SoftPercentageCloser, TraceSettings, TracedMap, bake_fragments,
    bake_layers, bake_mtsm,
};

use crate::scene::{misty, solid};

/// Width and height of maps.
pub(crate) const SIZE: u32 = 48;

/// Shadow rays and taps of a point.
const RAYS: u32 = 16;

/// How shadows are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    Reference,
    /// Lookups in a deep map.
    Deep,
    /// Taps in a plain map.
    Plain,
    /// Fragments traced, one by one.
    Fragments,
    /// Fragments traced, far ones by their optical depth.
    FarTable,
    /// Layers traced.
    Layers,
    /// Layers filtered over the light's outline.
    LayersFiltered,
    /// Runs of layers traced.
    Mtsm,
    /// Runs of layers filtered over the light's outline.
    MtsmFiltered,
    /// The first runs looked up like a deep map.
    MtsmLookup,
}

impl Method {
    pub(crate) const ALL: [Self; 10] = [
        Self::Reference,
        Self::Deep,
        Self::Plain,
        Self::Fragments,
        Self::FarTable,
        Self::Layers,
        Self::LayersFiltered,
        Self::Mtsm,
        Self::MtsmFiltered,
        Self::MtsmLookup,
    ];

    /// What it is tried on: with media where its map holds them.
    pub(crate) fn scene(self) -> Scene {
        match self {
            Self::Fragments | Self::FarTable | Self::Layers | Self::LayersFiltered => solid(),
            _ => misty(),
        }
    }

    /// How closely answers agree. Optical depths of media are within 6 · 10⁻⁶ of the
    /// truth in each cell of voxels, cut in more or fewer pieces as rounding has it.
    pub(crate) fn agreement(self) -> Agreement {
        match self {
            Self::Mtsm | Self::MtsmFiltered | Self::MtsmLookup | Self::Deep => {
                Agreement::default().with_tolerance(1.0 / f64::from(1 << 16))
            }
            _ => Agreement::default(),
        }
    }

    /// Makes it of a placed scene, from a file where there is a map that files hold.
    pub(crate) fn make(self, scene: &Scene, trial: &Trial) -> Result<Shadow> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("map.dsm");
        let maps = Maps { scene, tile_size: trial.tile_size, path: &path };
        match self {
            Self::Reference => {
                let traced = TracedScene::new(scene)?;
                Ok(Shadow::new(move |points, light, values| {
                    let reference = SceneReference::<f32>::new(&traced).with_rays(RAYS);
                    Ok(reference.visibilities(points, light, values)?)
                }))
            }
            Self::Deep => maps.deep(),
            Self::Plain => maps.plain(),
            Self::Fragments => maps.fragments(None),
            Self::FarTable => maps.fragments(Some(1.125)),
            Self::Layers => Ok(traced(maps.layers()?.multilayer_depth_map::<f32>()?)),
            Self::LayersFiltered => Ok(filtered(maps.layers()?.multilayer_depth_map::<f32>()?)),
            Self::Mtsm => Ok(traced(maps.mtsm()?.multilayer_map::<f32>()?)),
            Self::MtsmFiltered => Ok(filtered(maps.mtsm()?.multilayer_map::<f32>()?)),
            Self::MtsmLookup => {
                let map = maps.mtsm()?.multilayer_map::<f32>()?.deep_map()?;
                let lookup = lookup(map.info())?;
                Ok(Shadow::new(move |points, _, values| {
                    lookup.lights(&Pyramid::new(vec![&map])?, points, values)?;
                    Ok(())
                }))
            }
        }
    }
}

type Ask = dyn Fn(&[ShadedPoint], &AreaLight, &mut Vec<f32>) -> Result<()> + Sync + Send;

/// A method that owns what it reads.
pub(crate) struct Shadow(Box<Ask>);

impl Shadow {
    fn new(
        ask: impl Fn(&[ShadedPoint], &AreaLight, &mut Vec<f32>) -> Result<()> + Sync + Send + 'static,
    ) -> Self {
        Self(Box::new(ask))
    }
}

impl LightVisibility for Shadow {
    type Value = f32;
    type Error = anyhow::Error;

    fn visibility(&self, _: DVec3, _: &AreaLight, _: u64) -> Result<f32> {
        anyhow::bail!("points come in rows")
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<f32>,
    ) -> Result<()> {
        (self.0)(points, light, values)
    }
}

fn traced<M: TracedMap<Value = f32> + Send + 'static>(map: M) -> Shadow {
    let settings = TraceSettings { rays: RAYS, ..TraceSettings::default() };
    Shadow::new(move |points, light, values| {
        let tracer = MultilayerTracer::new(&map, settings)?;
        Ok(tracer.visibilities(points, light, values)?)
    })
}

fn filtered<M: TracedMap<Value = f32> + Send + 'static>(map: M) -> Shadow {
    Shadow::new(move |points, light, values| {
        let filter = SoftPercentageCloser::new(&map, FilteredLayers::All)?;
        let filter = filter.with_taps(RAYS)?.with_pixel_bias();
        Ok(filter.visibilities(points, light, values)?)
    })
}

/// Under a tent, so that answers do not jump between pixels.
fn lookup(info: &MapInfo) -> Result<ShadowLookup> {
    let tent = Footprint::Isotropic(Filter::new(FilterShape::Tent, 3.0)?);
    Ok(ShadowLookup::new(info, [SIZE; 2])?.with_footprint(tent))
}

/// The maps of a scene.
struct Maps<'a> {
    scene: &'a Scene,
    tile_size: u32,
    path: &'a Path,
}

impl Maps<'_> {
    fn deep(&self) -> Result<Shadow> {
        let raster = self.scene.light.raster([SIZE; 2])?;
        let mut settings = BakeSettings::new([SIZE; 2])?;
        settings.sampling = PixelSampling::new(4, 1)?;
        settings.tolerance = Some(Tolerance::new(0.0)?);
        settings.tile_size = self.tile_size;
        settings.camera = Some(raster.shadow_camera());
        let baker = Baker::new(SceneRasterizer::<f32>::new(self.scene, raster)?, settings)?;
        let watch = |_| ControlFlow::Continue(());
        bake(&baker, self.path, &BakeOptions::default(), |_| (), watch)?;
        let map = TileCache::new(1 << 24).open::<f32>(self.path, &Limits::default())?;
        let lookup = lookup(&map.reader().metadata().info)?;
        let shadow = CachedShadow::new(map, lookup)?;
        Ok(Shadow::new(
            move |points, light, values| Ok(shadow.visibilities(points, light, values)?),
        ))
    }

    fn plain(&self) -> Result<Shadow> {
        let raster = self.scene.light.raster([SIZE; 2])?;
        let mut settings = DepthMapSettings::new([SIZE; 2], 4)?;
        settings.camera = Some(raster.shadow_camera());
        let map = DepthMap::sample(&SceneRasterizer::<f32>::new(self.scene, raster)?, &settings)?;
        let info = MapInfo { camera: settings.camera, ..MapInfo::default() };
        let lookup = lookup(&info)?;
        Ok(Shadow::new(move |points, light, values| {
            let filter = PercentageCloserFilter::new(&map, RAYS)?.with_width(2.0)?;
            let shadow = PercentageCloserShadow::new(filter, lookup);
            Ok(shadow.visibilities(points, light, values)?)
        }))
    }

    /// What the light sees from behind its centre, and how far behind.
    fn pushed(&self) -> Result<(ViewRaster, f32)> {
        let raster = self.scene.light.raster([SIZE; 2])?;
        let extent = self.scene.light.area()?.extent();
        let back = LightFrame::push_back(extent, raster.half_size().to_array()) as f32;
        Ok((raster.moved_back(back.into()), back))
    }

    fn fragments(&self, far: Option<f32>) -> Result<Shadow> {
        let (raster, back) = self.pushed()?;
        let source = SceneRasterizer::<f32>::new(self.scene, raster)?;
        let builder = FragmentBuilder::new(raster.shadow_camera(), [SIZE; 2], back.into())?;
        let tiles = (self.tile_size, Block::Zstd);
        bake_fragments(&builder, &source, self.path, tiles, |_| ())?;
        let map = self.open()?.fragment_map::<f32>()?;
        Ok(Shadow::new(move |points, light, values| {
            let tracer = FragmentTracer::new(&map)?.with_rays(RAYS);
            let tracer = match far {
                Some(cells) => tracer.with_far_table(cells),
                None => tracer,
            };
            Ok(tracer.visibilities(points, light, values)?)
        }))
    }

    fn baker(&self) -> Result<MultilayerBaker<f32, SceneRasterizer<f32>>> {
        let (raster, back) = self.pushed()?;
        let mut settings = MultilayerSettings::new([SIZE; 2])?;
        settings.bake.camera = Some(raster.shadow_camera());
        settings.bake.tile_size = self.tile_size;
        settings.bake.tolerance = Some(Tolerance::new(0.0)?);
        settings.light_depth = back;
        Ok(MultilayerBaker::new(SceneRasterizer::new(self.scene, raster)?, settings)?)
    }

    fn layers(&self) -> Result<LayeredReader> {
        let watch = |_| ControlFlow::Continue(());
        bake_layers(&self.baker()?, self.path, Block::Zstd, |_| (), watch)?;
        self.open()
    }

    fn mtsm(&self) -> Result<LayeredReader> {
        let watch = |_| ControlFlow::Continue(());
        bake_mtsm(&self.baker()?, self.path, Block::Plain, |_| (), watch)?;
        self.open()
    }

    fn open(&self) -> Result<LayeredReader> {
        Ok(LayeredReader::open(self.path, &Limits::default())?)
    }
}
