//! Fragments of all pixels of a map.

use std::ops::Range;

use dsm_core::{Error, Result, Transmittance};

use crate::{Fragment, LightFrame, MinMaxPyramid};

/// The columns of a [`FragmentMap`], as they are stored.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FragmentColumns<T> {
    /// Where each pixel's fragments begin, row by row, and where the last one's
    /// end: one more than there are pixels.
    pub offsets: Vec<u32>,
    /// [`Fragment::w`].
    pub w: Vec<f32>,
    /// [`Fragment::gradient`], to the right and downwards.
    pub gradients: [Vec<f32>; 2],
    /// [`Fragment::opacity`].
    pub opacities: Vec<T>,
    /// [`Fragment::coverage`].
    pub coverage: Vec<u64>,
}

impl<T: Transmittance> FragmentColumns<T> {
    /// Holds the columns of `size` pixels to the rules of [`FragmentMap::new`].
    pub(crate) fn check(&self, size: [u32; 2]) -> Result<()> {
        let refuse = |pixel, reason| Err(Error::Pixel { pixel, reason });
        let FragmentColumns { offsets, w, gradients, opacities, coverage } = self;
        let [width, height] = size;
        let pixels = u64::from(width) * u64::from(height);
        if offsets.len() as u64 != pixels + 1 || offsets[0] != 0 {
            return refuse(0, "there must be one list a pixel");
        }
        let lengths = [gradients[0].len(), gradients[1].len(), opacities.len(), coverage.len()];
        if lengths.iter().any(|&length| length != w.len()) {
            return refuse(0, "the columns' lengths differ");
        }
        let in_range = |opacity: T| {
            let mut channels = (0..T::CHANNELS).map(|channel| opacity.channel(channel));
            channels.all(|value| (0.0..=1.0).contains(&value)) && opacity != T::splat(0.0)
        };
        for (pixel, ends) in offsets.windows(2).enumerate() {
            let (start, end) = (ends[0] as usize, ends[1] as usize);
            if start > end || end > w.len() {
                return refuse(pixel, "its list ends before it begins, or beyond the columns");
            }
            for at in start..end {
                let numbers = [w[at], gradients[0][at], gradients[1][at]];
                if !numbers.iter().all(|number| number.is_finite()) {
                    return refuse(pixel, "a fragment's plane is not finite");
                }
                if !in_range(opacities[at]) || coverage[at] == 0 {
                    return refuse(pixel, "a fragment takes nothing away, or too much");
                }
                if at > start && w[at - 1] > w[at] {
                    return refuse(pixel, "its fragments are not sorted");
                }
            }
        }
        if offsets[offsets.len() - 1] as usize != w.len() {
            return refuse(offsets.len().saturating_sub(2), "fragments of no pixel");
        }
        Ok(())
    }

    /// The fragment at `index`.
    pub(crate) fn fragment(&self, index: usize) -> Fragment<T> {
        Fragment {
            w: self.w[index],
            gradient: [self.gradients[0][index], self.gradients[1][index]],
            opacity: self.opacities[index],
            coverage: self.coverage[index],
        }
    }
}

/// A multilayer map whose layers are [`Fragment`]s, sorted by w in each pixel:
/// the farthest first.
///
/// Memory: 24 bytes a fragment (32 in colour) and 4 a pixel.
///
/// ```
/// use dsm_core::ShadowCamera;
/// use glam::{DMat4, DVec4};
/// use mtsm::{Fragment, FragmentColumns, FragmentMap, LightFrame};
///
/// # let to_ndc = DMat4::from_cols(
/// #     DVec4::new(0.5, 0.0, 0.0, 0.0),
/// #     DVec4::new(0.0, -0.5, 0.0, 0.0),
/// #     DVec4::new(-0.5, -0.5, -1.0, -1.0),
/// #     DVec4::ZERO,
/// # );
/// # let camera =
/// #     ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
/// let frame = LightFrame::new(&camera, [2, 1], 0.0)?;
/// // A square at depth 4 that fills the second pixel.
/// let columns = FragmentColumns {
///     offsets: vec![0, 0, 1],
///     w: vec![0.25],
///     gradients: [vec![0.0], vec![0.0]],
///     opacities: vec![1.0_f32],
///     coverage: vec![Fragment::<f32>::WHOLE],
/// };
/// let map = FragmentMap::new(frame, columns)?;
/// assert_eq!(map.pixel(1, 0).next().map(|fragment| fragment.w), Some(0.25));
/// assert!(map.pyramid()?.node(0, 0, 0).is_none());
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentMap<T> {
    frame: LightFrame,
    columns: FragmentColumns<T>,
}

impl<T: Transmittance> FragmentMap<T> {
    /// A map of these fragments. O(fragments).
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] if the columns do not fit together or a fragment is
    /// none: a number is not finite, an opacity is outside (0, 1], nothing is
    /// covered, or w descends.
    pub fn new(frame: LightFrame, columns: FragmentColumns<T>) -> Result<Self> {
        columns.check(frame.size())?;
        Ok(Self { frame, columns })
    }

    /// The frame that rasters and depths are measured in.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.frame.size()
    }

    /// All fragments.
    #[must_use]
    pub const fn columns(&self) -> &FragmentColumns<T> {
        &self.columns
    }

    /// The columns of the map, which ends.
    #[must_use]
    pub fn into_columns(self) -> FragmentColumns<T> {
        self.columns
    }

    /// Number of fragments.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.columns.w.len()
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.columns.w.is_empty()
    }

    /// The fragment at `index` of the columns.
    ///
    /// # Panics
    ///
    /// If there is none.
    #[must_use]
    pub fn fragment(&self, index: usize) -> Fragment<T> {
        self.columns.fragment(index)
    }

    /// Where the fragments of pixel (`x`, `y`) are in the columns; nowhere
    /// outside the map.
    #[must_use]
    pub fn pixel_range(&self, x: u32, y: u32) -> Range<usize> {
        let [width, height] = self.size();
        if x >= width || y >= height {
            return 0..0;
        }
        let pixel = y as usize * width as usize + x as usize;
        self.columns.offsets[pixel] as usize..self.columns.offsets[pixel + 1] as usize
    }

    /// The fragments of pixel (`x`, `y`), the farthest first.
    pub fn pixel(&self, x: u32, y: u32) -> impl ExactSizeIterator<Item = Fragment<T>> + '_ {
        self.pixel_range(x, y).map(|index| self.fragment(index))
    }

    /// The least and the greatest w of each part of the map. O(pixels +
    /// fragments).
    ///
    /// # Errors
    ///
    /// As [`MinMaxPyramid::new`].
    pub fn pyramid(&self) -> Result<MinMaxPyramid> {
        MinMaxPyramid::new(self.size(), |x, y| {
            let ranges = self.pixel(x, y).map(|fragment| fragment.range());
            ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fragments::oracle::frame;

    fn columns() -> FragmentColumns<f32> {
        FragmentColumns {
            offsets: vec![0, 2, 2, 3, 3],
            w: vec![0.25, 0.5, 0.125],
            gradients: [vec![0.0; 3], vec![0.0; 3]],
            opacities: vec![0.5; 3],
            coverage: vec![1; 3],
        }
    }

    #[test]
    fn only_sound_columns_make_a_map() {
        let map = FragmentMap::new(frame([2, 2], 0.0), columns()).unwrap();
        assert_eq!(map.pixel(0, 0).len(), 2);
        assert_eq!(map.pixel(0, 1).next().unwrap().w, 0.125);
        assert_eq!(map.pixel(2, 0).len(), 0);
        let wrong: [fn(&mut FragmentColumns<f32>); 10] = [
            |columns| columns.offsets[1] = 3,
            |columns| columns.offsets[4] = 2,
            |columns| columns.offsets[3] = 9,
            |columns| columns.offsets.truncate(4),
            |columns| columns.coverage.truncate(2),
            |columns| columns.w[0] = f32::NAN,
            |columns| columns.w.swap(0, 1),
            |columns| columns.gradients[1][2] = f32::INFINITY,
            |columns| columns.opacities[1] = 0.0,
            |columns| columns.coverage[2] = 0,
        ];
        for (index, break_it) in wrong.into_iter().enumerate() {
            let mut columns = columns();
            break_it(&mut columns);
            assert!(FragmentMap::new(frame([2, 2], 0.0), columns).is_err(), "{index}");
        }
    }
}
