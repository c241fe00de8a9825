//! Maps cut into parts that are baked apart.

use super::settings::Bake;
use crate::error::{Error, Result};

/// Columns and rows of tiles: first and behind the last, twice.
type Tiles = [[u32; 2]; 2];

impl Bake {
    /// The map cut into `count` crops of whole tiles, about as large as each other and as square
    /// as that allows, row by row of their corners: each is a crop of [`Self::crop`], and all
    /// together are the map. A function of the resolution, the size of tiles and `count` alone.
    /// O(count).
    ///
    /// ```
    /// use deepshadow::Bake;
    ///
    /// let settings = Bake::new([256, 128])?;
    /// assert_eq!(settings.parts(2)?, [[0, 0, 128, 128], [128, 0, 256, 128]]);
    /// assert!(settings.parts(9).is_err(), "it has 8 tiles");
    /// # Ok::<(), deepshadow::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Unsupported`] for no parts, or more than there are tiles.
    pub fn parts(&self, count: u32) -> Result<Vec<[u32; 4]>> {
        let tiles = self.resolution.map(|side| side.div_ceil(self.tile_size.max(1)));
        let all = u64::from(tiles[0]) * u64::from(tiles[1]);
        if count == 0 || u64::from(count) > all {
            let [width, height] = self.resolution;
            return Err(Error::Unsupported(format!(
                "a map of {width} × {height} pixels has {all} tiles, which make 1 to {all} parts, \
                 not {count}"
            )));
        }
        let mut parts = Vec::with_capacity(count as usize);
        cut([[0, tiles[0]], [0, tiles[1]]], count, &mut parts);
        parts.sort_by_key(|&[columns, rows]| (rows[0], columns[0]));
        let edge =
            |tile: u32, axis: usize| tile.saturating_mul(self.tile_size).min(self.resolution[axis]);
        let pixels = |[columns, rows]: Tiles| {
            [edge(columns[0], 0), edge(rows[0], 1), edge(columns[1], 0), edge(rows[1], 1)]
        };
        Ok(parts.into_iter().map(pixels).collect())
    }
}

/// Cuts tiles into `count` parts, across the longer side first.
fn cut(tiles: Tiles, count: u32, parts: &mut Vec<Tiles>) {
    if count <= 1 {
        return parts.push(tiles);
    }
    let [width, height] = tiles.map(|[first, end]| end - first);
    let axis = usize::from(height > width);
    let (long, short) = (width.max(height), width.min(height));
    // Both sides have a tile at least for each of their parts.
    let share = u64::from(long) * u64::from(count / 2);
    let middle = ((share + u64::from(count) / 2) / u64::from(count)).clamp(1, u64::from(long) - 1);
    let before = middle * u64::from(short);
    let behind = u64::from(long) * u64::from(short) - before;
    let least = u64::from(count).saturating_sub(behind).max(1);
    let first = u64::from(count / 2).clamp(least, before.min(u64::from(count) - 1));
    let (mut left, mut right) = (tiles, tiles);
    // Both fit: they are less than the sides and the count.
    left[axis][1] = tiles[axis][0] + middle as u32;
    right[axis][0] = left[axis][1];
    cut(left, first as u32, parts);
    cut(right, count - first as u32, parts);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_whole_tiles_that_cover_the_map_once() {
        for (size, tile) in [([130, 70], 16), ([64, 64], 64), ([7, 1], 1), ([33, 97], 10)] {
            let mut settings = Bake::new(size).unwrap();
            settings.tile_size = tile;
            let tiles = size.map(|side: u32| side.div_ceil(tile));
            for count in 1..=tiles[0] * tiles[1] {
                let parts = settings.parts(count).unwrap();
                assert_eq!(parts.len(), count as usize);
                let mut covered = vec![0; (size[0] * size[1]) as usize];
                for &[left, top, right, bottom] in &parts {
                    assert!(left % tile == 0 && top % tile == 0 && left < right && top < bottom);
                    assert!(right % tile == 0 || right == size[0]);
                    assert!(bottom % tile == 0 || bottom == size[1]);
                    for (y, x) in (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x))) {
                        covered[(y * size[0] + x) as usize] += 1;
                    }
                }
                assert!(covered.iter().all(|&times| times == 1), "{size:?} {tile} {count}");
            }
            assert!(settings.parts(0).is_err() && settings.parts(tiles[0] * tiles[1] + 1).is_err());
        }
    }

    #[test]
    fn sixteen_parts_of_a_square_are_squares() {
        let parts = Bake::new([2048, 2048]).unwrap().parts(16).unwrap();
        assert!(parts.iter().all(|part| part[2] - part[0] == 512 && part[3] - part[1] == 512));
        assert_eq!(parts[1], [512, 0, 1024, 512]);
    }
}
