//! Small maps to ask things of.

use std::path::{Path, PathBuf};

use dsm_core::detail::PixelWindow;
use dsm_core::{
    DeepMap, Filter, FilterShape, MapInfo, PixelListsBuilder, Rgb, ShadowCamera, Tolerance,
    Transmittance, Vertex,
};
use dsm_io::detail::{Level, MapWriter, TileId};
use dsm_io::{AchievedError, Attribute, Metadata, Packing, WriteOptions, write_map};
use glam::{DMat4, DVec4};
use tempfile::TempDir;

/// A folder that goes away with the test.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    pub(crate) fn map<T: Transmittance>(&self, name: &str, map: &DeepMap<T>) -> PathBuf {
        let path = self.path(name);
        write(&path, map);
        path
    }
}

/// Width and height of the maps.
pub(crate) const SIZE: [u32; 2] = [7, 5];

/// A pixel of its own kind everywhere: pixel (x, y) is clear if x = y; else
/// it has a step at depth 1 + x and a ramp from there to depth 10 + y.
/// `tint` colours a share of blocked light.
pub(crate) fn map<T: Transmittance>(info: MapInfo, tint: impl Fn(f32) -> T) -> DeepMap<T> {
    let mut pixels = PixelListsBuilder::new(SIZE[0], SIZE[1]);
    for (y, x) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (y, x))) {
        if x != y {
            let step = 1.0 + x as f32;
            pixels.push(Vertex::new(step, T::CLEAR));
            pixels.push(Vertex::new(step, tint(0.3)));
            pixels.push(Vertex::new(10.0 + y as f32, tint(0.9)));
        }
        pixels.finish_pixel().unwrap();
    }
    DeepMap::new(info, pixels.finish().unwrap())
}

pub(crate) fn mono(info: MapInfo) -> DeepMap<f32> {
    map(info, |blocked| 1.0 - blocked)
}

pub(crate) fn rgb(info: MapInfo) -> DeepMap<Rgb> {
    map(info, |blocked| Rgb::new(1.0 - blocked, 1.0 - 0.5 * blocked, 1.0 - 0.1 * blocked))
}

/// A map's info with everything known. The camera stands at the origin and
/// looks down −z; NDC covers [−2, 2] × [−1, 1] at any depth, and 20 × 10
/// pixels, of which the map holds those from (3, 2).
pub(crate) fn full_info() -> MapInfo {
    let world_to_ndc = DMat4::from_rows(
        DVec4::new(0.25, 0.0, 0.0, 0.5),
        DVec4::new(0.0, -0.5, 0.0, 0.5),
        DVec4::Z,
        DVec4::W,
    );
    let camera =
        ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(world_to_ndc) };
    MapInfo::new()
        .with_camera(camera)
        .with_tolerance(Tolerance::new(0.02).unwrap())
        .with_samples(16)
        .with_filter(Filter::new(FilterShape::Tent, 2.0).unwrap())
        .with_data_window(PixelWindow { min: [3, 2], max: [9, 6] })
        .with_display_window(PixelWindow { min: [0, 0], max: [19, 9] })
}

/// Where in the world the raster position and depth of a map with
/// [`full_info`] lie.
pub(crate) fn world([x, y, depth]: [f64; 3]) -> [f64; 3] {
    [((x + 3.0) / 20.0 - 0.5) * 4.0, (0.5 - (y + 2.0) / 10.0) * 2.0, -depth]
}

fn write<T: Transmittance>(path: &Path, map: &DeepMap<T>) {
    let mut metadata = Metadata::new(SIZE[0], SIZE[1], T::CHANNELS as u8, *map.info());
    metadata.attributes.insert("owner".to_owned(), Attribute::string("lighting"));
    let options = WriteOptions::default().with_tile_size(4).with_packing(Packing::Zstd);
    let error = AchievedError { max: map.info().tolerance.epsilon() / 2.0, mean: 0.0 };
    write_map(path, metadata, map, error, options).unwrap();
}

/// A map's pyramid: the first pixel of each square, down to 1 × 1.
pub(crate) fn levels<T: Transmittance>(map: &DeepMap<T>) -> Vec<DeepMap<T>> {
    let mut levels = vec![map.clone()];
    for k in 1..4 {
        let [width, height] = SIZE.map(|side| side.div_ceil(1 << k));
        let mut pixels = PixelListsBuilder::new(width, height);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            map.pixel(x << k, y << k).vertices().for_each(|vertex| pixels.push(vertex));
            pixels.finish_pixel().unwrap();
        }
        levels.push(DeepMap::new(*map.info(), pixels.finish().unwrap()));
    }
    levels
}

/// Writes a pyramid, each level in one tile.
pub(crate) fn write_levels<T: Transmittance>(path: &Path, levels: &[DeepMap<T>]) {
    let metadata = Metadata::new(SIZE[0], SIZE[1], T::CHANNELS as u8, *levels[0].info());
    let options = WriteOptions::default().with_tile_size(8);
    let mut writer = MapWriter::create(path, metadata, options).unwrap();
    for (level, number) in levels.iter().zip(0..) {
        let pixels = level.pixels().view();
        if number > 0 {
            let level = Level::new(pixels.width(), pixels.height(), 8, 0.1);
            writer.add_level(Level { number, ..level }).unwrap();
        }
        writer.write_tile(TileId::new(number, 0, 0), pixels, AchievedError::NONE).unwrap();
    }
    writer.finish().unwrap();
}
