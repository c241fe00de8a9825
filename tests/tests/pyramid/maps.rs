//! Maps to build pyramids of.

use std::path::Path;

use dsm_core::detail::PixelLists;
use dsm_core::{MapInfo, PixelListsBuilder, Progress, Tolerance, Transmittance, Vertex};
use dsm_io::detail::{MapWriter, TileId};
use dsm_io::{
    AchievedError, Limits, MapReader, Metadata, Packing, PyramidOptions, WriteOptions, mip,
};

/// Numbers that are the same in every run.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    /// The next one, below `end`.
    pub(crate) fn below(&mut self, end: u32) -> u32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(end)) as u32
    }

    fn fraction(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }
}

/// What is in a map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Content {
    pub(crate) seed: u64,
    /// Whether depths are half integers, of which many tie.
    pub(crate) on_grid: bool,
    /// Of sixteen pixels so many are empty.
    pub(crate) empty: u32,
}

/// A pixel's vertices: steps, ramps, and opaque ends.
fn pixel<T: Transmittance>(content: Content, numbers: &mut Numbers) -> Vec<Vertex<T>> {
    if numbers.below(16) < content.empty {
        return Vec::new();
    }
    let grey = numbers.below(2) == 0;
    let mut z = numbers.below(8) as f32 * 0.5;
    let mut value = T::CLEAR;
    let mut vertices = vec![Vertex::new(z, value)];
    for _ in 0..1 + numbers.below(6) {
        // First to a further depth, flat or falling, then perhaps down.
        for is_step in [false, true] {
            if !is_step {
                let far = if content.on_grid {
                    0.5 * (1 + numbers.below(6)) as f32
                } else {
                    0.01 + 3.0 * numbers.fraction()
                };
                z += far;
            }
            let left = match numbers.below(6) {
                0 if is_step => 0.0,
                1 => 0.5,
                2 => numbers.fraction(),
                3 => 0.5 + 0.5 * numbers.fraction(),
                _ if is_step => continue,
                _ => 1.0,
            };
            let mut tint =
                [0; 3].map(|_| if grey { left } else { left * (1.0 - 0.3 * numbers.fraction()) });
            if left == 1.0 {
                tint = [1.0; 3];
            }
            value = T::from_channels(|channel| value.channel(channel) * tint[channel]);
            vertices.push(Vertex::new(z, value));
        }
    }
    vertices
}

/// Makes a map of its own kind everywhere.
pub(crate) fn pixels<T: Transmittance>(
    [width, height]: [u32; 2],
    content: Content,
) -> PixelLists<T> {
    let mut numbers = Numbers(content.seed);
    let mut lists = PixelListsBuilder::new(width, height);
    for _ in 0..width * height {
        pixel::<T>(content, &mut numbers).into_iter().for_each(|vertex| lists.push(vertex));
        lists.finish_pixel().unwrap();
    }
    lists.finish().unwrap()
}

/// How a map is written, and with which pyramid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) size: [u32; 2],
    pub(crate) tile: u32,
    pub(crate) epsilon: f32,
    pub(crate) packing: Packing,
    pub(crate) options: PyramidOptions,
}

impl Shape {
    pub(crate) fn new(size: [u32; 2], tile: u32, epsilon: f32) -> Self {
        Self { size, tile, epsilon, packing: Packing::Plain, options: PyramidOptions::default() }
    }

    pub(crate) fn metadata(&self, channels: usize) -> Metadata {
        let tolerance = Tolerance::new(self.epsilon).unwrap();
        let info = MapInfo::new().with_tolerance(tolerance);
        Metadata::new(self.size[0], self.size[1], channels as u8, info)
    }

    pub(crate) fn write_options(&self) -> WriteOptions {
        WriteOptions::default().with_tile_size(self.tile).with_packing(self.packing)
    }
}

/// Writes level 0.
pub(crate) fn write<T: Transmittance>(path: &Path, shape: &Shape, pixels: &PixelLists<T>) {
    let mut writer =
        MapWriter::create(path, shape.metadata(T::CHANNELS), shape.write_options()).unwrap();
    let level = writer.levels()[0];
    let [columns, rows] = level.tiles();
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        let rect = level.tile_rect(x, y).unwrap();
        let mut tile = PixelListsBuilder::new(rect.width, rect.height);
        for row in rect.y..rect.y + rect.height {
            for column in rect.x..rect.x + rect.width {
                let function = pixels.view().pixel(column, row);
                function.vertices().for_each(|vertex| tile.push(vertex));
                tile.finish_pixel().unwrap();
            }
        }
        // An error that level 0 states does not count for the others.
        let error = AchievedError { max: shape.epsilon, mean: 0.5 * shape.epsilon };
        let tile = tile.finish().unwrap();
        writer.write_tile(TileId::new(0, x, y), tile.view(), error).unwrap();
    }
    writer.finish().unwrap();
}

pub(crate) fn open(path: &Path) -> MapReader {
    MapReader::open(path, &Limits::default()).unwrap()
}

/// Writes a map with its pyramid, and opens it.
pub(crate) fn with_pyramid<T: Transmittance>(
    folder: &Path,
    shape: &Shape,
    pixels: &PixelLists<T>,
) -> MapReader {
    let (flat, path) = (folder.join("flat.dsm"), folder.join("pyramid.dsm"));
    write(&flat, shape, pixels);
    mip(&open(&flat), &path, &shape.options, Progress::ignore).unwrap();
    open(&path)
}
