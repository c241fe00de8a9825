//! Pyramids of functions that are not stored yet, as a baker has them.

use std::ops::Range;

use dsm_core::detail::{PixelLists, SumVertex};
use dsm_core::{Progress, Rgb, Transmittance, Vertex};
use dsm_io::Error;
use dsm_io::detail::{
    Level, MapWriter, PixelFunctions, PyramidSource, Result, SourceTile, TileId, build_pyramid,
};

use crate::maps::{Content, Shape, open, pixels};
use crate::naive::{Plain, check_levels};

/// Functions in `f64` that state to be off by [`ERROR`].
struct Uncompressed<T: Transmittance> {
    level: Level,
    functions: Vec<Vec<SumVertex<T>>>,
}

/// What chords may have cost.
const ERROR: f64 = 2e-5;

struct Functions<'a, T: Transmittance>(Vec<&'a [SumVertex<T>]>);

impl<T: Transmittance> PixelFunctions<T> for Functions<'_, T> {
    type Function<'a>
        = &'a [SumVertex<T>]
    where
        Self: 'a;

    fn function(&self, pixel: usize) -> &[SumVertex<T>] {
        self.0[pixel]
    }

    fn error(&self, pixel: usize) -> f64 {
        if self.0[pixel].is_empty() { 0.0 } else { ERROR }
    }
}

impl<T: Transmittance> PyramidSource<T> for Uncompressed<T> {
    type Functions<'a> = Functions<'a, T>;

    fn tile(&self, id: TileId) -> Result<SourceTile<Functions<'_, T>>> {
        let rect = self.level.tile_rect(id.x, id.y).ok_or(Error::NoSuchTile(id))?;
        let row = |y: u32| {
            let first = (y * self.level.width + rect.x) as usize;
            &self.functions[first..first + rect.width as usize]
        };
        let rows: Range<u32> = rect.y..rect.y + rect.height;
        let functions = Functions(rows.flat_map(row).map(Vec::as_slice).collect());
        Ok(SourceTile { functions: Some(functions), stored: None })
    }
}

/// The pixels with values that `f32` does not have.
fn in_f64<T: Transmittance>(pixels: &PixelLists<T>) -> Vec<Vec<SumVertex<T>>> {
    let third = |vertex: Vertex<T>| {
        let value = T::sum_from_channels(|channel| {
            f64::from(vertex.value.channel(channel)) / 3.0 + 2.0 / 3.0
        });
        Vertex::new(vertex.z, value)
    };
    pixels.view().functions().map(|function| function.vertices().map(third).collect()).collect()
}

fn check<T: Transmittance>(shape: &Shape, content: Content) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let functions = in_f64(&pixels::<T>(shape.size, content));
    let mut writer =
        MapWriter::create(&path, shape.metadata(T::CHANNELS), shape.write_options()).unwrap();
    let level = writer.levels()[0];
    let source = Uncompressed::<T> { level, functions };
    let mut told = Vec::new();
    build_pyramid(&source, &mut writer, &shape.options, |tile| {
        told.push((tile.done, tile.total));
        Progress::ignore(tile)
    })
    .unwrap();
    writer.finish().unwrap();
    assert_eq!(told.last(), Some(&(level.tile_count(), level.tile_count())));
    assert!(told.is_sorted());

    let reader = open(&path);
    assert!(reader.verify().is_empty(), "{:?}", reader.verify());
    for (index, level) in (0..).zip(reader.levels()) {
        for (id, entry) in reader.directory(index).unwrap().iter() {
            let (error, tolerance) = (f64::from(entry.error.max), f64::from(level.tolerance));
            // What the source states to be off by counts in every level.
            assert!(entry.is_empty() || error >= 0.3 * ERROR, "{id}: {error}");
            assert!(error <= tolerance + 1e-9, "{id}: {error} of {tolerance}");
        }
    }
    let plain = source.functions.iter().map(|function| Plain {
        z: function.iter().map(|vertex| vertex.z).collect(),
        values: (0..T::CHANNELS)
            .map(|channel| function.iter().map(|vertex| vertex.value.as_ref()[channel]).collect())
            .collect(),
    });
    check_levels::<T>(&reader, &plain.collect::<Vec<_>>(), 0, "uncompressed", false);
}

#[test]
fn functions_that_are_not_stored_yet_are_the_reference_of_all_levels() {
    for (size, tile) in [([37, 22], 8), ([37, 22], 64), ([12, 30], 3)] {
        let content = Content { seed: 77, on_grid: true, empty: 3 };
        check::<f32>(&Shape::new(size, tile, 0.02), content);
        check::<Rgb>(&Shape::new(size, tile, 0.05), content);
    }
}
