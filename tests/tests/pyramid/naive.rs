//! Plain averages in `f64`, by other code than the library's.

use dsm_core::Transmittance;
use dsm_core::detail::VisibilityView;
use dsm_io::MapReader;
use dsm_io::detail::TileId;

/// What rounding adds to sums of numbers in [0, 1], here and there.
pub(crate) const ROUNDING: f64 = 1e-11;

/// A function as its depths and values, one list a channel.
#[derive(Clone, Debug)]
pub(crate) struct Plain {
    pub(crate) z: Vec<f32>,
    pub(crate) values: Vec<Vec<f64>>,
}

impl Plain {
    pub(crate) fn of<T: Transmittance>(function: VisibilityView<'_, T>) -> Self {
        let vertices = function.vertices();
        let values = (0..T::CHANNELS).map(|channel| {
            vertices_of(function).map(|vertex| f64::from(vertex.value.channel(channel))).collect()
        });
        Self { z: vertices.map(|vertex| vertex.z).collect(), values: values.collect() }
    }

    /// V just before `z` and at `z`, by walking all vertices.
    fn sides(&self, z: f32, channel: usize) -> [f64; 2] {
        let values = &self.values[channel];
        let mut sides = [1.0; 2];
        for (index, &far) in self.z.iter().enumerate() {
            if far < z {
                sides = [values[index]; 2];
            } else if far == z {
                // The first one here ends what was before.
                if index == 0 || self.z[index - 1] < z {
                    sides[0] = values[index];
                }
                sides[1] = values[index];
            } else {
                if index > 0 && self.z[index - 1] < z {
                    let (near, from, to) = (self.z[index - 1], values[index - 1], values[index]);
                    let share =
                        (f64::from(z) - f64::from(near)) / (f64::from(far) - f64::from(near));
                    sides = [from + share * (to - from); 2];
                }
                break;
            }
        }
        sides
    }
}

fn vertices_of<T: Transmittance>(
    function: VisibilityView<'_, T>,
) -> impl Iterator<Item = dsm_core::Vertex<T>> {
    function.vertices()
}

/// The largest difference between `function` and the mean of `parts`, at both
/// sides of every vertex of any of them.
fn difference(function: &Plain, parts: &[&Plain]) -> f64 {
    let mut depths: Vec<f32> = parts.iter().flat_map(|part| &part.z).copied().collect();
    depths.extend(&function.z);
    depths.sort_by(f32::total_cmp);
    depths.dedup();
    let mut worst = 0.0_f64;
    for &z in &depths {
        for channel in 0..function.values.len() {
            let mut sums = [0.0; 2];
            for part in parts {
                let sides = part.sides(z, channel);
                sums = [sums[0] + sides[0], sums[1] + sides[1]];
            }
            let found = function.sides(z, channel);
            for side in 0..2 {
                worst = worst.max((found[side] - sums[side] / parts.len() as f64).abs());
            }
        }
    }
    worst
}

/// Holds every tile of every level from `first` on to the error it states, and
/// every level to its tolerance, against the plain average of `exact`, row by
/// row the functions of level 0. Where `is_measured`, the errors of pixels
/// within a tile must be those that are found. Returns the errors of the
/// levels.
pub(crate) fn check_levels<T: Transmittance>(
    reader: &MapReader,
    exact: &[Plain],
    first: u32,
    what: &str,
    is_measured: bool,
) -> Vec<f64> {
    let [width, height] = [reader.levels()[0].width, reader.levels()[0].height];
    let mut errors = Vec::new();
    for (index, level) in (0..).zip(reader.levels()).skip(first as usize) {
        let side = 1_usize << index;
        assert_eq!(level.width as usize, (width as usize).div_ceil(side), "{what}");
        assert_eq!(level.height as usize, (height as usize).div_ceil(side), "{what}");
        let mut worst_of_level = 0.0_f64;
        let [columns, rows] = level.tiles();
        for (row, column) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
            let id = TileId::new(index, column, row);
            let (tile, rect) = (reader.tile::<T>(id).unwrap(), reader.tile_rect(id).unwrap());
            let entry = *reader.directory(index).unwrap().get(column, row).unwrap();
            let mut worst = 0.0_f64;
            for (y, x) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (y, x))) {
                let reach = |pixel: u32, end: u32| {
                    let first = pixel as usize * side;
                    first..(first + side).min(end as usize)
                };
                let (across, down) = (reach(rect.x + x, width), reach(rect.y + y, height));
                let pixels = down.flat_map(|y| across.clone().map(move |x| (x, y)));
                let parts: Vec<_> = pixels.map(|(x, y)| &exact[y * width as usize + x]).collect();
                worst = worst.max(difference(&Plain::of(tile.view().pixel(x, y)), &parts));
            }
            let (stated, tolerance) = (f64::from(entry.error.max), f64::from(level.tolerance));
            assert!(worst <= stated + ROUNDING, "{what}: {id} is off by {worst}, not {stated}");
            assert!(stated <= tolerance, "{what}: {id} states {stated}, more than {tolerance}");
            assert!(entry.error.mean <= entry.error.max, "{what}: {id}");
            // The rounding of the last value alone may not count in the mean.
            assert!(worst <= 1e-7 || entry.error.mean > 0.0, "{what}: {id} has no mean error");
            if is_measured && level.tile_width.is_multiple_of(1 << index.min(31)) {
                let rounded = stated * (1.0 - 1e-6) - ROUNDING;
                assert!(worst >= rounded, "{what}: {id} is off by {worst}, not by {stated}");
            }
            worst_of_level = worst_of_level.max(worst);
        }
        errors.push(worst_of_level);
    }
    errors
}

/// Level 0 as it is stored.
pub(crate) fn stored<T: Transmittance>(reader: &MapReader) -> Vec<Plain> {
    let map = reader.read_map::<T>(0).unwrap();
    map.pixels().view().functions().map(Plain::of).collect()
}
