//! The runs of layers of many pixels, in columns.

use std::ops::Range;

use dsm_core::detail::{PixelLists, Result};
use dsm_core::{Error, PixelListsBuilder, Transmittance, Vertex};

use crate::layer::{Layer, LayerRun};

/// The layers of a rectangle of pixels, of a map or of a tile: pixel by pixel
/// and row by row runs, run by run layers.
///
/// ```
/// use mtsm::detail::{Layer, LayeredPixelsBuilder};
///
/// let mut pixels = LayeredPixelsBuilder::new(1, 1);
/// let sheet = |depth, visibility, count| Layer { depth, visibility, count };
/// // Something opaque at depth 2, and a sheet of glass behind it.
/// pixels.push_run([sheet(2.0, 1.0, 0), sheet(2.0, 0.0, 1)])?;
/// pixels.push_run([sheet(3.0, 1.0, 0), sheet(3.0, 0.5_f32, 1)])?;
/// pixels.finish_pixel()?;
/// let pixels = pixels.finish()?;
/// assert_eq!(pixels.runs(0).len(), 2);
/// assert_eq!(pixels.first_run(0).unwrap().function().at(2.5), 0.0);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredPixels<T> {
    width: u32,
    height: u32,
    /// Where each pixel's runs start, and the end.
    run_starts: Vec<u32>,
    /// The runs' functions, in one row.
    functions: PixelLists<T>,
    /// One a layer.
    counts: Vec<u32>,
}

impl<T: Transmittance> LayeredPixels<T> {
    /// The layers in these columns. `run_starts` has one entry a pixel and one
    /// for the end; `functions` are all runs in one row; `counts` has one entry
    /// a layer.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] naming the first pixel whose columns don't fit together
    /// or whose runs break a rule: each has layers, the first of which counts
    /// no samples; none starts before the one in front of it has ended, at
    /// exactly 0. O(layers).
    pub fn new(
        (width, height): (u32, u32),
        run_starts: Vec<u32>,
        functions: PixelLists<T>,
        counts: Vec<u32>,
    ) -> Result<Self> {
        let pixels = Self { width, height, run_starts, functions, counts };
        pixels.check()?;
        Ok(pixels)
    }

    fn check(&self) -> Result<()> {
        let refuse = |pixel, reason| Err(Error::Pixel { pixel, reason });
        let pixels = self.pixel_count();
        let runs = self.functions.view().pixel_count();
        let covers = self.run_starts.len() == pixels + 1
            && self.run_starts[0] == 0
            && self.run_starts.is_sorted()
            && self.run_starts[pixels] as usize == runs;
        if !covers || self.functions.view().height() != 1 {
            return refuse(pixels, "the run table does not cover the runs");
        }
        if self.counts.len() != self.functions.view().vertex_count() {
            return refuse(pixels, "there is not one count a layer");
        }
        for pixel in 0..pixels {
            let mut before: Option<LayerRun<'_, T>> = None;
            for run in self.runs(pixel) {
                let Some(&depth) = run.function().depths().first() else {
                    return refuse(pixel, "a run has layers");
                };
                if run.counts()[0] != 0 {
                    return refuse(pixel, "the first layer of a run counts no samples");
                }
                if let Some(before) = before {
                    if !before.is_opaque() {
                        return refuse(pixel, "a run that another follows ends at 0");
                    }
                    if before.function().depths().last().is_some_and(|&end| end > depth) {
                        return refuse(pixel, "runs must go front to back");
                    }
                }
                before = Some(run);
            }
        }
        Ok(())
    }

    /// Width in pixels.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Number of pixels.
    #[must_use]
    pub const fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Number of runs of all pixels.
    #[must_use]
    pub fn run_count(&self) -> usize {
        self.functions.view().pixel_count()
    }

    /// Number of layers of all pixels.
    #[must_use]
    pub const fn layer_count(&self) -> usize {
        self.counts.len()
    }

    /// The samples that all layers count.
    #[must_use]
    pub fn sample_count(&self) -> u64 {
        self.counts.iter().map(|&count| u64::from(count)).sum()
    }

    fn run_range(&self, pixel: usize) -> Range<usize> {
        self.run_starts[pixel] as usize..self.run_starts[pixel + 1] as usize
    }

    fn run(&self, run: usize) -> LayerRun<'_, T> {
        let functions = self.functions.view();
        let layers = functions.starts()[run] as usize..functions.starts()[run + 1] as usize;
        LayerRun::new(functions.function(run), &self.counts[layers])
    }

    /// The runs of the pixel with row-major index `pixel`, front to back.
    ///
    /// # Panics
    ///
    /// If `pixel` is not below [`Self::pixel_count`].
    pub fn runs(
        &self,
        pixel: usize,
    ) -> impl DoubleEndedIterator<Item = LayerRun<'_, T>> + ExactSizeIterator {
        self.run_range(pixel).map(|run| self.run(run))
    }

    /// The first run of a pixel: its visibility function as a deep map's. None:
    /// nothing is in the way.
    ///
    /// # Panics
    ///
    /// If `pixel` is not below [`Self::pixel_count`].
    #[must_use]
    pub fn first_run(&self, pixel: usize) -> Option<LayerRun<'_, T>> {
        self.run_range(pixel).next().map(|run| self.run(run))
    }

    /// At how many of a pixel's layers its light falls.
    ///
    /// # Panics
    ///
    /// If `pixel` is not below [`Self::pixel_count`].
    #[must_use]
    pub fn falling_layers(&self, pixel: usize) -> usize {
        let falls = |run: LayerRun<'_, T>| {
            let value = |layer| run.function().value(layer);
            (1..run.len()).filter(|&layer| value(layer) != value(layer - 1)).count()
        };
        self.runs(pixel).map(falls).sum()
    }

    /// The smallest and the largest depth of a pixel's layers.
    ///
    /// # Panics
    ///
    /// If `pixel` is not below [`Self::pixel_count`].
    #[must_use]
    pub fn depth_range(&self, pixel: usize) -> Option<[f32; 2]> {
        let functions = self.functions.view();
        let runs = self.run_range(pixel);
        let [start, end] = [runs.start, runs.end].map(|run| functions.starts()[run] as usize);
        match &functions.depths()[start..end] {
            [first, .., last] | [first @ last] => Some([*first, *last]),
            [] => None,
        }
    }

    /// The index of each pixel's first run, and the end.
    #[must_use]
    pub fn run_starts(&self) -> &[u32] {
        &self.run_starts
    }

    /// The functions of all runs, in one row.
    #[must_use]
    pub const fn functions(&self) -> &PixelLists<T> {
        &self.functions
    }

    /// The counts of all layers.
    #[must_use]
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }
}

/// Builds [`LayeredPixels`] pixel by pixel, row by row.
#[derive(Debug)]
pub struct LayeredPixelsBuilder<T> {
    width: u32,
    height: u32,
    run_starts: Vec<u32>,
    runs: u32,
    functions: PixelListsBuilder<T>,
    counts: Vec<u32>,
}

impl<T: Transmittance> LayeredPixelsBuilder<T> {
    /// A builder for `width` × `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let functions = PixelListsBuilder::new(0, 0);
        Self { width, height, run_starts: vec![0], runs: 0, functions, counts: Vec::new() }
    }

    /// Adds a run to the current pixel, front to back.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] if its layers are no visibility function,
    /// [`Error::TooLarge`] past 2³² − 1 values. Nothing can be finished then.
    pub fn push_run(&mut self, layers: impl IntoIterator<Item = Layer<T>>) -> Result<()> {
        for Layer { depth, visibility, count } in layers {
            self.functions.push(Vertex::new(depth, visibility));
            self.counts.push(count);
        }
        self.runs += 1;
        let pixel = self.run_starts.len() - 1;
        self.functions.finish_pixel().map_err(|error| match error {
            Error::Pixel { reason, .. } => Error::Pixel { pixel, reason },
            other => other,
        })
    }

    /// Adds the next pixel, a copy of one of `pixels`.
    ///
    /// # Errors
    ///
    /// As [`Self::push_run`] and [`Self::finish_pixel`].
    pub(crate) fn copy_pixel(&mut self, pixels: &LayeredPixels<T>, pixel: usize) -> Result<()> {
        for run in pixels.runs(pixel) {
            self.push_run(run.layers())?;
        }
        self.finish_pixel()
    }

    /// Ends the current pixel and begins the next.
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] if there are more pixels than announced.
    pub fn finish_pixel(&mut self) -> Result<()> {
        let (pixel, reason) = (self.run_starts.len() - 1, "there is no such pixel");
        if pixel >= self.width as usize * self.height as usize {
            return Err(Error::Pixel { pixel, reason });
        }
        self.run_starts.push(self.runs);
        Ok(())
    }

    /// The finished pixels.
    ///
    /// # Errors
    ///
    /// As [`LayeredPixels::new`].
    pub fn finish(self) -> Result<LayeredPixels<T>> {
        let functions = self.functions.finish_row()?;
        LayeredPixels::new((self.width, self.height), self.run_starts, functions, self.counts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Run = &'static [(f32, f32, u32)];

    fn pixels(pixels: &[&[Run]]) -> Result<LayeredPixels<f32>> {
        let mut builder = LayeredPixelsBuilder::new(pixels.len() as u32, 1);
        for runs in pixels {
            for run in *runs {
                let layer = |&(depth, visibility, count)| Layer { depth, visibility, count };
                builder.push_run(run.iter().map(layer))?;
            }
            builder.finish_pixel()?;
        }
        builder.finish()
    }

    const OPAQUE: Run = &[(2.0, 1.0, 0), (2.0, 0.0, 1)];
    const BEHIND: Run = &[(2.0, 1.0, 0), (4.0, 0.5, 7)];

    #[test]
    fn runs_come_back_pixel_by_pixel() {
        let pixels = pixels(&[&[], &[OPAQUE, BEHIND], &[BEHIND]]).unwrap();
        assert_eq!([pixels.run_count(), pixels.layer_count()], [3, 6]);
        assert_eq!(pixels.sample_count(), 15);
        assert!(pixels.first_run(0).is_none() && pixels.depth_range(0).is_none());
        assert_eq!(pixels.depth_range(1), Some([2.0, 4.0]));
        let runs: Vec<Vec<_>> = pixels.runs(1).map(|run| run.layers().collect()).collect();
        assert_eq!(runs[1][1], Layer { depth: 4.0, visibility: 0.5, count: 7 });
        assert_eq!(pixels.first_run(1).unwrap().function().at(9.0), 0.0);
        assert_eq!(pixels.first_run(2).unwrap().function().at(9.0), 0.5);
        assert!(pixels.runs(1).next().unwrap().is_opaque());
    }

    #[test]
    fn runs_that_break_a_rule_are_refused() {
        let deeper: Run = &[(1.0, 1.0, 0), (3.0, 0.5, 1)];
        let counted: Run = &[(5.0, 1.0, 1), (5.0, 0.5, 1)];
        let rising: Run = &[(1.0, 1.0, 0), (2.0, 0.5, 1), (3.0, 0.75, 1)];
        for runs in [&[OPAQUE, deeper][..], &[BEHIND, BEHIND], &[counted], &[&[]], &[rising]] {
            assert!(matches!(pixels(&[&[], runs]), Err(Error::Pixel { pixel: 1, .. })), "{runs:?}");
        }
        let good = pixels(&[&[OPAQUE, BEHIND]]).unwrap();
        let columns = |starts: &[u32], counts: &[u32]| {
            LayeredPixels::new((1, 1), starts.to_vec(), good.functions.clone(), counts.to_vec())
        };
        assert!(columns(&[0, 2], &[0, 1, 0, 7]).is_ok());
        for (starts, counts) in
            [(&[0, 1][..], &[0, 1, 0, 7][..]), (&[0], &[0, 1, 0, 7]), (&[0, 2], &[0, 1, 0])]
        {
            assert!(columns(starts, counts).is_err(), "{starts:?} {counts:?}");
        }
    }

    #[test]
    fn as_many_pixels_as_announced_are_taken() {
        let mut builder = LayeredPixelsBuilder::<f32>::new(1, 1);
        builder.finish_pixel().unwrap();
        assert!(builder.finish_pixel().is_err());
        assert!(LayeredPixelsBuilder::<f32>::new(2, 1).finish().is_err());
    }
}
