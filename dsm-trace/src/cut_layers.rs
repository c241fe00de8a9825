//! What a bound of layers a pixel changed, added up over a map or a part of one.

use serde::{Deserialize, Serialize};

/// A sum's units a pixel of light: sums of parts are exact, so that they come to the whole's.
const UNITS: f64 = (1_u64 << 31) as f64;

/// What a bound of layers a pixel changed, as headers keep it: the layers behind the nearest
/// were left out, or are one with the last of those.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutLayers {
    /// Pixels with more layers.
    pub pixels: u64,
    /// The most light that any pixel lets through too much, in \[0, 1\].
    pub max: f32,
    /// The same in the mean over all pixels.
    pub mean: f32,
    /// Of a part of a map: the same of all its pixels added up, in units of 2⁻³¹, from which
    /// the whole map's mean is found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sum: Option<u64>,
}

impl CutLayers {
    /// What its numbers cannot be, if they are that.
    #[must_use]
    pub fn broken_rule(&self) -> Option<&'static str> {
        let is_part = |light: f32| (0.0..=1.0).contains(&light);
        let are_parts = is_part(self.max) && is_part(self.mean);
        (!are_parts).then_some("the light that is lost or gained must lie in [0, 1]")
    }
}

/// The sum of what is cut, tile by tile in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutSum {
    pixels: u64,
    max: f32,
    sum: u64,
}

impl CutSum {
    /// Adds a tile with `pixels` that have more layers, the most light that one of them lets
    /// through too much, and the sum over all of them.
    pub fn add_tile(&mut self, pixels: u64, most: f64, sum: f64) {
        self.pixels += pixels;
        self.max = self.max.max(most as f32);
        self.sum = self.sum.saturating_add((sum * UNITS).round() as u64);
    }

    /// What the header says of a map of so many pixels, or of a part of one: None if nothing
    /// was cut.
    #[must_use]
    pub fn of_map(&self, pixels: u64, is_part: bool) -> Option<CutLayers> {
        let Self { pixels: cut, max, sum } = *self;
        let mean = ((sum as f64 / UNITS / pixels.max(1) as f64) as f32).min(max);
        (cut > 0).then_some(CutLayers { pixels: cut, max, mean, sum: is_part.then_some(sum) })
    }

    /// What the header says of a map of `pixels` pixels with these parts.
    ///
    /// # Errors
    ///
    /// That a part does not know its sum.
    pub fn join(
        parts: impl IntoIterator<Item = Option<CutLayers>>,
        pixels: u64,
    ) -> Result<Option<CutLayers>, &'static str> {
        let mut all = Self::default();
        for part in parts.into_iter().flatten() {
            let sum = part.sum.ok_or("sums of what was cut")?;
            all.pixels = all.pixels.saturating_add(part.pixels);
            all.max = all.max.max(part.max);
            all.sum = all.sum.saturating_add(sum);
        }
        Ok(all.of_map(pixels, false))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_come_to_the_whole_in_any_order() {
        let tiles = [(3, 0.25, 0.3), (1, 0.5, 0.5), (0, 0.0, 0.0), (9, 0.125, 0.7)];
        let add = |tiles: &[(u64, f64, f64)]| {
            let mut sum = CutSum::default();
            tiles.iter().for_each(|&(pixels, most, all)| sum.add_tile(pixels, most, all));
            sum
        };
        let whole = add(&tiles).of_map(100, false);
        assert_eq!(whole.map(|cut| (cut.pixels, cut.max, cut.mean)), Some((13, 0.5, 0.015)));
        for cut in 0..=tiles.len() {
            let (first, second) = tiles.split_at(cut);
            let parts = [second, first].map(|tiles| add(tiles).of_map(50, true));
            assert_eq!(CutSum::join(parts, 100), Ok(whole));
        }
        assert!(CutSum::join([whole], 100).is_err());
        assert_eq!(CutSum::join([None], 100), Ok(None));
    }
}
