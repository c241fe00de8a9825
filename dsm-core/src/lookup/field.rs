//! What a lookup asks: anything that has a visibility function in every pixel.

use std::ops::Range;

use crate::Transmittance;

/// Something that has a visibility function in every pixel: a map in memory,
/// the tiles of a file, a layered map's first run.
pub trait VisibilityField {
    /// Mono or coloured.
    type Value: Transmittance;
    /// Why a pixel can't be had; [`std::convert::Infallible`] in memory.
    type Error;

    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// V(`depth`) of `pixel`, which lies inside the field.
    ///
    /// # Errors
    ///
    /// If the pixel can't be read.
    fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<Self::Value, Self::Error>;

    /// Asks `visitor` for the depth of each pixel of `columns` in `row`, all
    /// inside the field, from left to right, and hands it the values. A field
    /// that keeps neighbours together overrides this to find them once; the
    /// values are those of [`Self::evaluate`].
    ///
    /// # Errors
    ///
    /// The first error of [`Self::evaluate`]; the visitor was handed what
    /// came before.
    #[inline(always)]
    fn evaluate_row(
        &self,
        row: u32,
        columns: Range<u32>,
        visitor: &mut impl RowVisitor<Self::Value>,
    ) -> Result<(), Self::Error> {
        for column in columns {
            if let Some(depth) = visitor.depth(column) {
                visitor.take(self.evaluate([column, row], depth)?);
            }
        }
        Ok(())
    }
}

impl<F: VisibilityField> VisibilityField for &F {
    type Value = F::Value;
    type Error = F::Error;

    fn size(&self) -> [u32; 2] {
        (**self).size()
    }

    #[inline(always)]
    fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<F::Value, F::Error> {
        (**self).evaluate(pixel, depth)
    }

    #[inline(always)]
    fn evaluate_row(
        &self,
        row: u32,
        columns: Range<u32>,
        visitor: &mut impl RowVisitor<F::Value>,
    ) -> Result<(), F::Error> {
        (**self).evaluate_row(row, columns, visitor)
    }
}

/// Says at which depths the pixels of a row are asked, and gets their values.
pub trait RowVisitor<T> {
    /// The depth at which the pixel in `column` is asked; `None` passes it
    /// over.
    fn depth(&mut self, column: u32) -> Option<f32>;

    /// The value of the pixel whose depth was asked for last.
    fn take(&mut self, value: T);
}
