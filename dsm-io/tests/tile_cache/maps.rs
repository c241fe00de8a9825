//! The maps that are looked up, and how lookups are compared.

use std::cell::Cell;
use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;

use dsm_core::detail::BlockVisitor;
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Transmittance,
    Vertex, VisibilityField, filtered_lookup,
};
use dsm_io::{AchievedError, Limits, MapReader, Metadata, Packing, WriteOptions, write_map};

pub(crate) const SIZE: [u32; 2] = [150, 100];
pub(crate) const TILE: u32 = 9;
pub(crate) const THREADS: u64 = 8;

/// A stream of numbers in [0, 1).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

/// Steps and ramps of 0 to 4 falls a pixel; the tiles of one corner are
/// empty.
pub(crate) fn map<T: Transmittance>(seed: u64) -> DeepMap<T> {
    let mut random = Random(seed);
    let mut pixels = PixelListsBuilder::new(SIZE[0], SIZE[1]);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let falls = if x < 3 * TILE && y < 2 * TILE { 0 } else { (random.next() * 5.0) as u32 };
            let (mut z, mut value) = (random.next(), T::CLEAR);
            for _ in 0..falls {
                pixels.push(Vertex::new(z, value));
                z += if random.next() < 0.5 { 0.0 } else { random.next() };
                value = T::from_channels(|channel| value.channel(channel) * random.next());
                pixels.push(Vertex::new(z, value));
                z += 0.1;
            }
            pixels.finish_pixel().unwrap();
        }
    }
    DeepMap::new(MapInfo::default(), pixels.finish().unwrap())
}

pub(crate) fn write<T: Transmittance>(path: &Path, map: &DeepMap<T>, packing: Packing) {
    let metadata = Metadata::new(SIZE[0], SIZE[1], T::CHANNELS as u8, *map.info());
    let options = WriteOptions::default().with_tile_size(TILE).with_packing(packing);
    write_map(path, metadata, map, AchievedError::NONE, options).unwrap();
}

/// A map, and a reader of it.
pub(crate) fn written<T: Transmittance>(seed: u64, packing: Packing) -> (DeepMap<T>, MapReader) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let map = map(seed);
    write(&path, &map, packing);
    (map, MapReader::open_in_memory(&path, &Limits::default()).unwrap())
}

pub(crate) fn tiles_with_pixels(reader: &MapReader) -> u64 {
    let entries = reader.directory(0).unwrap().iter();
    entries.filter(|(_, entry)| !entry.is_empty()).count() as u64
}

/// A field that counts what it is asked.
pub(crate) struct Counted<'a, F>(pub(crate) &'a F, pub(crate) Cell<u64>);

impl<F: VisibilityField> VisibilityField for Counted<'_, F> {
    type Value = F::Value;
    type Error = F::Error;

    fn size(&self) -> [u32; 2] {
        self.0.size()
    }

    fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<F::Value, F::Error> {
        self.1.set(self.1.get() + 1);
        self.0.evaluate(pixel, depth)
    }

    fn evaluate_block(&self, visitor: &mut impl BlockVisitor<F::Value>) -> Result<(), F::Error> {
        self.0.evaluate_block(&mut CountedBlock(visitor, &self.1))
    }
}

/// A visitor that counts what it asks.
pub(crate) struct CountedBlock<'a, V>(&'a mut V, &'a Cell<u64>);

impl<T, V: BlockVisitor<T>> BlockVisitor<T> for CountedBlock<'_, V> {
    fn bounds(&self) -> [Range<u32>; 2] {
        self.0.bounds()
    }

    fn columns(&mut self, row: u32) -> Range<u32> {
        self.0.columns(row)
    }

    fn depth(&mut self, column: u32) -> Option<f32> {
        let depth = self.0.depth(column);
        self.1.set(self.1.get() + u64::from(depth.is_some()));
        depth
    }

    fn take(&mut self, value: T) {
        self.0.take(value);
    }
}

pub(crate) fn bits<T: Transmittance>(value: T) -> Vec<u32> {
    (0..T::CHANNELS).map(|channel| value.channel(channel).to_bits()).collect()
}

/// Compares `lookups` filtered lookups that wander, and at times jump; tells
/// how many pixels they asked for.
pub(crate) fn compare<T: Transmittance, F: VisibilityField<Value = T>>(
    map: &DeepMap<T>,
    field: &F,
    seed: u64,
    lookups: u32,
) -> u64
where
    F::Error: Debug,
{
    let field = Counted(field, Cell::new(0));
    let filter = |shape, width| Footprint::Isotropic(Filter::new(shape, width).unwrap());
    let slanted =
        Footprint::Elliptical { shape: FilterShape::Gaussian, axes: [[9.0, 6.0], [-1.0, 1.5]] };
    let (narrow, tent) = (filter(FilterShape::Box, 3.0), filter(FilterShape::Tent, 4.0));
    let footprints = [Footprint::Point, narrow, Footprint::Point, narrow, slanted, tent];
    let mut random = Random(seed);
    let size = SIZE.map(|size| size as f32);
    let mut at = [0.0; 2];
    for lookup in 0..lookups {
        if lookup % 100 == 0 {
            at = size.map(|size| random.next() * size);
        }
        at =
            [0, 1].map(|axis| (at[axis] + 4.0 * random.next() - 2.0).clamp(0.0, size[axis] - 0.01));
        let receiver = Receiver::new(at, 4.0 * random.next());
        let footprint = footprints[lookup as usize % 6];
        let Ok(expected) = filtered_lookup(map, &receiver, &footprint);
        let found = filtered_lookup(&field, &receiver, &footprint).unwrap();
        assert_eq!(bits(found), bits(expected), "{receiver:?}");
    }
    field.1.get()
}
