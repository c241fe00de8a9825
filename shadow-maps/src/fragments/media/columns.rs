//! Media of all pixels in columns, as they are stored.

use std::ops::Range;

use dsm_core::detail::Result;
use dsm_core::{Error, Transmittance};

/// The media of the pixels of a map: borders of slabs, front to back, and how much optical
/// depth each slab has.
///
/// Between two borders of a pixel the extinction is constant. A slab's *thickness* is its
/// optical depth along a ray that goes one unit far for each unit of depth: that of the
/// pixel's own ray, divided by its stretch
/// ([`distance_per_depth`](dsm_core::SamplePoint::distance_per_depth)).
///
/// ```
/// use shadow_maps::detail::MediaColumns;
///
/// let mut media = MediaColumns::<f32>::new();
/// media.push_pixel([])?;
/// // Of extinction 0.25 from depth 2 to 4, nothing up to 5, and 1 up to 6.
/// media.push_pixel([(2.0, 0.0), (4.0, 0.5), (5.0, 0.0), (6.0, 1.0)])?;
/// assert_eq!(media.offsets, [0, 0, 4]);
/// assert_eq!(media.range(), Some([2.0, 6.0]));
/// assert!(media.check([2, 1]).is_ok());
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MediaColumns<T> {
    /// The index of each pixel's first border, row by row, and where the last one's end: one
    /// more than there are pixels.
    pub offsets: Vec<u32>,
    /// The depth of each border.
    pub depths: Vec<f32>,
    /// The thickness of the slab before each border: 0 before the first of a pixel.
    pub thickness: Vec<T>,
}

impl<T> Default for MediaColumns<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> MediaColumns<T> {
    /// The columns of no pixels.
    #[must_use]
    pub fn new() -> Self {
        Self::clear(0)
    }

    /// The columns of so many pixels without a medium.
    #[must_use]
    pub fn clear(pixels: usize) -> Self {
        Self { offsets: vec![0; pixels + 1], depths: Vec::new(), thickness: Vec::new() }
    }

    /// True if no pixel has a medium.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.depths.is_empty()
    }

    /// Least and greatest depth of all borders; None if there are none.
    #[must_use]
    pub fn range(&self) -> Option<[f32; 2]> {
        let depths = self.depths.iter().map(|&depth| [depth; 2]);
        depths.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    fn list(&self, pixel: usize) -> Range<usize> {
        self.offsets[pixel] as usize..self.offsets[pixel + 1] as usize
    }
}

impl<T: Transmittance> MediaColumns<T> {
    /// Appends a pixel: the depth of each border, and the thickness before it.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 2³² − 1 borders.
    pub fn push_pixel(&mut self, borders: impl IntoIterator<Item = (f32, T)>) -> Result<()> {
        for (depth, thickness) in borders {
            self.depths.push(depth);
            self.thickness.push(thickness);
        }
        let (count, limit) = (self.depths.len() as u64, u64::from(u32::MAX));
        let too_large = |_| Error::TooLarge { what: "borders of media", count, limit };
        self.offsets.push(u32::try_from(count).map_err(too_large)?);
        Ok(())
    }

    /// The borders of the pixel with row-major index `pixel`, front to back, each with the
    /// thickness before it.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    pub fn pixel(&self, pixel: usize) -> impl ExactSizeIterator<Item = (f32, T)> + '_ {
        self.list(pixel).map(|at| (self.depths[at], self.thickness[at]))
    }

    /// Checks the columns of `size` pixels. O(borders).
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] that names the rule which is broken: lists in order, of no border or
    /// of two and more; depths finite, not negative and rising; thickness finite and not
    /// negative, 0 before the first border and more than that in some channel before the
    /// last.
    pub fn check(&self, size: [u32; 2]) -> Result<()> {
        let refuse = |pixel, reason| Err(Error::Pixel { pixel, reason });
        let Self { offsets, depths, thickness } = self;
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        if offsets.len() as u64 != pixels + 1 || offsets[0] != 0 {
            return refuse(0, "there must be one list of media a pixel");
        }
        if thickness.len() != depths.len() {
            return refuse(0, "the columns' lengths differ");
        }
        let none = T::splat(0.0);
        for (pixel, ends) in offsets.windows(2).enumerate() {
            let (start, end) = (ends[0] as usize, ends[1] as usize);
            if start > end || end > depths.len() {
                return refuse(pixel, "its media end before they begin, or beyond the columns");
            }
            let list = start..end;
            if list.clone().any(|at| !(0.0..f32::INFINITY).contains(&depths[at])) {
                return refuse(pixel, "the depth of a border must be finite and at least 0");
            }
            if !depths[list.clone()].is_sorted_by(|a, b| a < b) {
                return refuse(pixel, "borders of media must rise");
            }
            let is_sound = |value: T| {
                let mut channels = (0..T::CHANNELS).map(|channel| value.channel(channel));
                channels.all(|value| (0.0..f32::INFINITY).contains(&value))
            };
            if !thickness[list.clone()].iter().all(|&value| is_sound(value)) {
                return refuse(pixel, "the thickness of media must be finite and at least 0");
            }
            if let [first, .., last] = thickness[list.clone()] {
                if first != none || last == none {
                    return refuse(pixel, "media begin at the first border and end at the last");
                }
            } else if !list.is_empty() {
                return refuse(pixel, "a medium has two borders");
            }
        }
        if offsets[offsets.len() - 1] as usize != depths.len() {
            return refuse(offsets.len().saturating_sub(2), "borders of no pixel");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> MediaColumns<f32> {
        MediaColumns {
            offsets: vec![0, 2, 2, 5],
            depths: vec![1.0, 2.0, 0.0, 1.0, 3.0],
            thickness: vec![0.0, 0.5, 0.0, 0.0, 7.0],
        }
    }

    #[test]
    fn only_sound_columns_are_taken() {
        assert!(columns().check([3, 1]).is_ok());
        assert!(MediaColumns::<f32>::clear(6).check([2, 3]).is_ok());
        let pixel: Vec<_> = columns().pixel(2).collect();
        assert_eq!(pixel, [(0.0, 0.0), (1.0, 0.0), (3.0, 7.0)]);
        let wrong: [fn(&mut MediaColumns<f32>); 15] = [
            |media| media.offsets[1] = 3,
            |media| media.offsets[1] = 1,
            |media| media.offsets[0] = 1,
            |media| media.offsets[3] = 4,
            |media| media.offsets[3] = 6,
            |media| media.offsets.truncate(3),
            |media| media.thickness.truncate(4),
            |media| media.depths[0] = -1.0,
            |media| media.depths[1] = f32::INFINITY,
            |media| media.depths[1] = f32::NAN,
            |media| media.depths[1] = 1.0,
            |media| media.thickness[0] = 0.25,
            |media| media.thickness[1] = 0.0,
            |media| media.thickness[3] = -0.5,
            |media| media.thickness[4] = f32::INFINITY,
        ];
        for (index, break_it) in wrong.into_iter().enumerate() {
            let mut columns = columns();
            break_it(&mut columns);
            assert!(columns.check([3, 1]).is_err(), "{index}");
        }
    }
}
