//! The interface of lookups: a visibility function in every pixel.

use std::ops::Range;

use super::pixel_lists::PixelListsView;
use crate::transmittance::Transmittance;

/// A field of visibility functions, one a pixel: a map in memory, the tiles of a
/// file, a layered map's first run.
///
/// ```
/// use std::convert::Infallible;
///
/// use dsm_core::{Filter, FilterShape, Footprint, Receiver, VisibilityField, filtered_lookup};
///
/// /// Two pixels; the left one is blocked at depth 1.
/// struct Half;
///
/// impl VisibilityField for Half {
///     type Value = f32;
///     type Error = Infallible;
///
///     fn size(&self) -> [u32; 2] {
///         [2, 1]
///     }
///
///     fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<f32, Infallible> {
///         Ok(if pixel == [0, 0] && depth >= 1.0 { 0.0 } else { 1.0 })
///     }
/// }
///
/// let footprint = Footprint::Isotropic(Filter::new(FilterShape::Box, 2.0)?);
/// let receiver = Receiver::new([1.0, 0.5], 3.0);
/// assert_eq!(filtered_lookup(&Half, &receiver, &footprint), Ok(0.5));
/// # Ok::<(), dsm_core::Error>(())
/// ```
pub trait VisibilityField {
    /// Mono or coloured.
    type Value: Transmittance;
    /// The error of reading a pixel; [`std::convert::Infallible`] in memory.
    type Error;
    /// Whether [`Self::evaluate_block`] hands over runs of pixel lists
    /// ([`BlockVisitor::take_run`]), which vectors search. Lookups of other fields
    /// are compiled once, not once an instruction set.
    const HAS_RUNS: bool = false;

    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// V(`depth`) of `pixel`, which lies inside the field.
    ///
    /// # Errors
    ///
    /// If the pixel can't be read.
    fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<Self::Value, Self::Error>;

    /// Asks `visitor` for the depth of each pixel of its block, row by row
    /// from left to right, and hands it the values. A field that keeps
    /// neighbours together overrides this to find them once; the values are
    /// those of [`Self::evaluate`].
    ///
    /// # Errors
    ///
    /// The first error of [`Self::evaluate`]; the visitor was handed what
    /// came before.
    #[inline(always)]
    fn evaluate_block(
        &self,
        visitor: &mut impl BlockVisitor<Self::Value>,
    ) -> Result<(), Self::Error> {
        let [_, rows] = visitor.bounds();
        for row in rows {
            for column in visitor.columns(row) {
                if let Some(depth) = visitor.depth(column) {
                    visitor.take(self.evaluate([column, row], depth)?);
                }
            }
        }
        Ok(())
    }
}

impl<F: VisibilityField> VisibilityField for &F {
    type Value = F::Value;
    type Error = F::Error;
    const HAS_RUNS: bool = F::HAS_RUNS;

    fn size(&self) -> [u32; 2] {
        (**self).size()
    }

    #[inline(always)]
    fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<F::Value, F::Error> {
        (**self).evaluate(pixel, depth)
    }

    #[inline(always)]
    fn evaluate_block(&self, visitor: &mut impl BlockVisitor<F::Value>) -> Result<(), F::Error> {
        (**self).evaluate_block(visitor)
    }
}

/// A query of a block of pixels: gives the depth for each pixel, and receives the
/// values.
pub trait BlockVisitor<T> {
    /// The columns and rows that hold the whole block, all inside the field.
    fn bounds(&self) -> [Range<u32>; 2];

    /// Begins a row of the block: its columns, which lie within the bounds.
    fn columns(&mut self, row: u32) -> Range<u32>;

    /// The depth at which the pixel in `column` of the row that was begun
    /// last is queried; `None` passes it over.
    fn depth(&mut self, column: u32) -> Option<f32>;

    /// The value of the pixel whose depth was queried last.
    fn take(&mut self, value: T);

    /// Asks for the depths of `columns` of the row that was begun last, and
    /// takes what the functions of `pixels`, from the row-major index `first`
    /// on, have there. Tells how many pixels were queried.
    ///
    /// # Panics
    ///
    /// If the run does not lie within `pixels`.
    #[inline(always)]
    fn take_run(&mut self, columns: Range<u32>, pixels: PixelListsView<'_, T>, first: usize) -> u64
    where
        T: Transmittance,
    {
        let mut asked = 0;
        for (column, pixel) in columns.zip(first..) {
            if let Some(depth) = self.depth(column) {
                self.take(pixels.function(pixel).at(depth));
                asked += 1;
            }
        }
        asked
    }
}
