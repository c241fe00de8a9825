//! Fragments of all pixels of a map.

use std::ops::Range;

use dsm_core::Transmittance;
use dsm_core::detail::Result;
use dsm_trace::MinMaxPyramid;
use dsm_trace::detail::LightFrame;

use super::columns::FragmentColumns;
use super::fragment::Fragment;
use super::media::columns::MediaColumns;

/// A multilayer map whose layers are [`Fragment`]s, sorted by w in each pixel:
/// the farthest first; with media beside them, as slabs of constant extinction
/// ([`MediaColumns`]).
///
/// Memory: 24 bytes a fragment (32 in colour) and 4 a pixel; of media 8 bytes a border (16
/// in colour) and 4 a pixel.
///
/// ```
/// use dsm_core::ShadowCamera;
/// use dsm_trace::detail::LightFrame;
/// use glam::{DMat4, DVec4};
/// use shadow_maps::detail::{Fragment, FragmentColumns, FragmentMap};
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
/// let coverage = Fragment::<f32>::WHOLE;
/// let square = Fragment { w: 0.25, gradient: Some([0.0; 2]), opacity: 1.0_f32, coverage };
/// let mut columns = FragmentColumns::new();
/// columns.push_pixel([])?;
/// columns.push_pixel([square])?;
/// let map = FragmentMap::new(frame, columns)?;
/// assert_eq!(map.pixel(1, 0).next().map(|fragment| fragment.w), Some(0.25));
/// assert!(map.pyramid()?.node(0, 0, 0).is_none());
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentMap<T> {
    frame: LightFrame,
    columns: FragmentColumns<T>,
    /// None: no pixel has any.
    media: Option<MediaColumns<T>>,
}

impl<T: Transmittance> FragmentMap<T> {
    /// A map of these fragments. O(fragments).
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`](dsm_core::Error::Pixel) if the columns do not fit
    /// together or a fragment is none: a number is not finite, an opacity is
    /// outside (0, 1], nothing is covered, or w descends.
    pub fn new(frame: LightFrame, columns: FragmentColumns<T>) -> Result<Self> {
        columns.check(frame.size())?;
        Ok(Self { frame, columns, media: None })
    }

    /// The same with these media. O(borders).
    ///
    /// # Errors
    ///
    /// As [`MediaColumns::check`].
    pub fn with_media(self, media: MediaColumns<T>) -> Result<Self> {
        media.check(self.size())?;
        Ok(Self { media: (!media.is_empty()).then_some(media), ..self })
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

    /// The media of all pixels; None if there are none.
    #[must_use]
    pub const fn media(&self) -> Option<&MediaColumns<T>> {
        self.media.as_ref()
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

    /// True if there are no fragments.
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

    /// The indices of the fragments of pixel (`x`, `y`) in the columns; none
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

    /// The minimum and maximum w of each part of the map. O(pixels +
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
    use super::super::oracle::frame;
    use super::*;

    fn columns() -> FragmentColumns<f32> {
        FragmentColumns {
            offsets: vec![0, 2, 2, 3, 3],
            w: vec![0.25, 0.5, 0.125],
            gradients: [vec![0.0; 3], vec![0.0; 3]],
            facing: vec![0b10],
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
        let facing: Vec<_> = map.pixel(0, 0).map(|fragment| fragment.is_facing()).collect();
        assert_eq!(facing, [false, true]);
        let wrong: [fn(&mut FragmentColumns<f32>); 13] = [
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
            |columns| columns.gradients[0][1] = 0.25,
            |columns| columns.facing[0] = 0b1010,
            |columns| columns.facing.clear(),
        ];
        for (index, break_it) in wrong.into_iter().enumerate() {
            let mut columns = columns();
            break_it(&mut columns);
            assert!(FragmentMap::new(frame([2, 2], 0.0), columns).is_err(), "{index}");
        }
    }
}
