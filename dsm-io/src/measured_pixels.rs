//! Compression that measures its own error.

use dsm_core::detail::{
    PixelLists, Quantization, Rounded, RoundedCompressor, SumVertex, VisibilityView,
};
use dsm_core::{Compression, PixelListsBuilder, Tolerance, Transmittance, Vertex};

use crate::achieved_error::AchievedError;
use crate::error::{Result, check_tile_bytes};

/// Compresses pixels row by row and measures, on the `f32` values that are
/// stored, what that costs.
#[derive(Debug)]
pub(crate) struct MeasuredPixels<T: Transmittance> {
    pixels: PixelListsBuilder<T>,
    tolerance: Tolerance,
    compression: Compression,
    compressor: RoundedCompressor<T>,
    /// One pixel's vertices.
    vertices: Vec<Vertex<T>>,
    count: u32,
    /// Bytes of the depths and values so far.
    bytes: u64,
    max: f64,
    means: f64,
    depth_error: f32,
}

impl<T: Transmittance> MeasuredPixels<T> {
    /// For width × height pixels, none of which may be off by more than
    /// `tolerance` in the end.
    pub(crate) fn new(
        [width, height]: [u32; 2],
        tolerance: Tolerance,
        compression: Compression,
    ) -> Self {
        Self {
            pixels: PixelListsBuilder::new(width, height),
            tolerance,
            compression,
            compressor: RoundedCompressor::new(None, compression),
            vertices: Vec::new(),
            count: 0,
            bytes: 0,
            max: 0.0,
            means: 0.0,
            depth_error: 0.0,
        }
    }

    /// Rounds what is left of every function to grids, within the tolerance.
    pub(crate) fn rounded_to(self, quantization: Option<Quantization>) -> Self {
        let compressor = RoundedCompressor::new(quantization, self.compression);
        Self { compressor, ..self }
    }

    /// Adds a pixel whose function ends with the last of these vertices and is
    /// off by `inherited` already: the rest of the tolerance is left for its
    /// compression. Returns its error, or [`Error::TileTooLarge`] for a tile that
    /// readers would refuse.
    ///
    /// [`Error::TileTooLarge`]: crate::error::Error::TileTooLarge
    pub(crate) fn push(&mut self, vertices: &[SumVertex<T>], inherited: f64) -> Result<f64> {
        let tolerance = self.tolerance.after(inherited);
        self.vertices.clear();
        let Rounded { difference, moved } =
            self.compressor.compress(tolerance, vertices, &mut self.vertices);
        self.vertices.iter().for_each(|&vertex| self.pixels.push(vertex));
        self.pixels.finish_pixel()?;
        let compressed = self.pixels.last_pixel().unwrap_or(VisibilityView::clear());
        self.bytes += 4 * (compressed.depths().len() + compressed.columns().len()) as u64;
        self.depth_error = self.depth_error.max(moved);
        let error = difference.max() + inherited;
        self.count += 1;
        self.max = self.max.max(error);
        self.means += difference.mean() + inherited;
        check_tile_bytes(self.bytes)?;
        Ok(error)
    }

    /// Adds a pixel that is 1 everywhere.
    pub(crate) fn push_clear(&mut self) -> Result<()> {
        self.count += 1;
        Ok(self.pixels.finish_pixel()?)
    }

    /// The largest error of any pixel so far.
    pub(crate) const fn max(&self) -> f64 {
        self.max
    }

    /// The pixels' mean errors so far, added up.
    pub(crate) const fn means(&self) -> f64 {
        self.means
    }

    /// The largest shift of a depth away from the light so far.
    pub(crate) const fn depth_error(&self) -> f32 {
        self.depth_error
    }

    /// The compressed pixels, and the errors of all of them.
    pub(crate) fn finish(self) -> Result<(PixelLists<T>, AchievedError)> {
        let mean = self.means / f64::from(self.count.max(1));
        Ok((self.pixels.finish()?, AchievedError::enclosing(self.max, mean)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_those_of_the_stored_values() {
        let tolerance = Tolerance::new(0.1).unwrap();
        let mut pixels = MeasuredPixels::<f32>::new([3, 1], tolerance, Compression::default());
        // Two steps that one ramp replaces, and what was spent before.
        let steps = [(1.0, 1.0), (1.0, 0.95), (2.0, 0.95), (2.0, 0.9)];
        let steps = steps.map(|(z, value)| Vertex::new(z, [value]));
        let error = pixels.push(&steps, 0.03).unwrap();
        assert!((0.03..=0.1).contains(&error) && error > 0.031, "{error}");
        pixels.push_clear().unwrap();
        pixels.push(&[], 0.0).unwrap();
        assert_eq!(pixels.max(), error);
        let means = pixels.means();
        let (lists, achieved) = pixels.finish().unwrap();
        assert!(lists.view().vertex_count() < 4);
        assert_eq!(achieved, AchievedError::enclosing(error, means / 3.0));
    }
}
