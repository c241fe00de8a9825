//! Pixels of a level that are compressed together.

use dsm_core::detail::{PixelLists, Polyline, SumVertex, VisibilitySweep};
use dsm_core::{Compression, Tolerance, Transmittance};

use crate::error::Result;
use crate::measured_pixels::MeasuredPixels;

/// A rectangle of compressed pixels of some level, and their errors.
#[derive(Debug)]
pub(super) struct Fragment<T> {
    /// Column and row of its first pixel in the level.
    pub(super) origin: [u32; 2],
    pub(super) pixels: PixelLists<T>,
    /// The largest error of any pixel.
    pub(super) max: f64,
    /// The pixels' mean errors, added up.
    pub(super) means: f64,
}

impl<T: Transmittance> Fragment<T> {
    /// Whether there is nothing to tell of it.
    pub(super) fn is_clear(&self) -> bool {
        self.pixels.view().vertex_count() == 0 && self.max == 0.0
    }
}

/// Compresses the pixels of a fragment row by row.
#[derive(Debug)]
pub(super) struct FragmentBuilder<T: Transmittance> {
    origin: [u32; 2],
    pixels: MeasuredPixels<T>,
}

impl<T: Transmittance> FragmentBuilder<T> {
    pub(super) fn new(
        origin: [u32; 2],
        size: [u32; 2],
        tolerance: Tolerance,
        compression: Compression,
    ) -> Self {
        Self { origin, pixels: MeasuredPixels::new(size, tolerance, compression) }
    }

    /// As [`MeasuredPixels::push`].
    pub(super) fn push(&mut self, vertices: &[SumVertex<T>], inherited: f64) -> Result<f64> {
        self.pixels.push(vertices, inherited)
    }

    /// Adds a pixel that is 1 everywhere.
    pub(super) fn push_clear(&mut self) -> Result<()> {
        self.pixels.push_clear()
    }

    pub(super) fn finish(self) -> Result<Fragment<T>> {
        let (max, means) = (self.pixels.max(), self.pixels.means());
        let (pixels, _) = self.pixels.finish()?;
        Ok(Fragment { origin: self.origin, pixels, max, means })
    }
}

/// Copies of a node's pixels of one level, for coarser levels to average.
#[derive(Debug)]
pub(super) struct Copies<T> {
    /// The node's column and row among those of its height.
    pub(super) node: [u32; 2],
    pub(super) pixels: PixelLists<T>,
    /// What each pixel may be off, row by row.
    pub(super) errors: Vec<f64>,
}

/// Compresses the copies of a node's pixels, if there are to be any.
#[derive(Debug)]
pub(super) struct CopiesBuilder<T: Transmittance>(Option<(FragmentBuilder<T>, Vec<f64>)>);

impl<T: Transmittance> CopiesBuilder<T> {
    pub(super) fn new(
        size: [u32; 2],
        tolerance: Option<Tolerance>,
        compression: Compression,
    ) -> Self {
        // Where the copies stand is the node's to say.
        let pixels = |tolerance| FragmentBuilder::new([0, 0], size, tolerance, compression);
        Self(tolerance.map(|tolerance| (pixels(tolerance), Vec::new())))
    }

    pub(super) fn push(&mut self, vertices: &[SumVertex<T>], inherited: f64) -> Result<()> {
        if let Some((pixels, errors)) = &mut self.0 {
            errors.push(pixels.push(vertices, inherited)?);
        }
        Ok(())
    }

    pub(super) fn push_clear(&mut self) -> Result<()> {
        if let Some((pixels, errors)) = &mut self.0 {
            pixels.push_clear()?;
            errors.push(0.0);
        }
        Ok(())
    }

    /// The copies, unless there is nothing to tell of them.
    pub(super) fn finish(self, node: [u32; 2]) -> Result<Option<Copies<T>>> {
        let Some((pixels, errors)) = self.0 else { return Ok(None) };
        let fragment = pixels.finish()?;
        Ok((!fragment.is_clear()).then_some(Copies { node, errors, pixels: fragment.pixels }))
    }
}

/// Averages functions and keeps the memory for it.
#[derive(Debug)]
pub(super) struct Averager<T: Transmittance> {
    sweep: VisibilitySweep<T>,
    vertices: Vec<SumVertex<T>>,
}

impl<T: Transmittance> Default for Averager<T> {
    fn default() -> Self {
        Self { sweep: VisibilitySweep::default(), vertices: Vec::new() }
    }
}

impl<T: Transmittance> Averager<T> {
    /// The exact average; none if all functions are 1 everywhere.
    pub(super) fn average<F: Polyline<Sum = T::Sum>>(
        &mut self,
        functions: &[(f64, F)],
    ) -> Option<&[SumVertex<T>]> {
        if functions.iter().all(|(_, function)| function.vertex_count() == 0) {
            return None;
        }
        self.vertices.clear();
        self.sweep.average(functions).run(|vertex| self.vertices.push(vertex));
        Some(&self.vertices)
    }
}
