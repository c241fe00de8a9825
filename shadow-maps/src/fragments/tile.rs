//! Tiles of maps of fragments.

use dsm_core::Transmittance;
use dsm_io::detail::MapTile;

use super::columns::FragmentColumns;
use super::fragment::Fragment;
use super::media::columns::MediaColumns;

/// The fragments of a tile, and the media beside them.
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentTile<T> {
    size: [u32; 2],
    columns: FragmentColumns<T>,
    /// None in a map without.
    media: Option<MediaColumns<T>>,
}

impl<T: Transmittance> FragmentTile<T> {
    /// A tile of `size` pixels, whose lists are in `columns`, of a map without media.
    ///
    /// # Errors
    ///
    /// As [`FragmentColumns::check`].
    pub fn new(size: [u32; 2], columns: FragmentColumns<T>) -> dsm_core::detail::Result<Self> {
        columns.check(size)?;
        Ok(Self { size, columns, media: None })
    }

    /// The same of a map with media: these.
    ///
    /// # Errors
    ///
    /// As [`MediaColumns::check`].
    pub fn with_media(self, media: MediaColumns<T>) -> dsm_core::detail::Result<Self> {
        media.check(self.size)?;
        Ok(Self { media: Some(media), ..self })
    }

    /// The media, pixel by pixel; None in a map without.
    #[must_use]
    pub const fn media(&self) -> Option<&MediaColumns<T>> {
        self.media.as_ref()
    }

    /// All fragments, pixel by pixel.
    #[must_use]
    pub const fn columns(&self) -> &FragmentColumns<T> {
        &self.columns
    }

    /// The fragments of the pixel with row-major index `pixel`, the farthest first.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    pub fn fragments(&self, pixel: usize) -> impl DoubleEndedIterator<Item = Fragment<T>> {
        let columns = &self.columns;
        let range = columns.offsets[pixel] as usize..columns.offsets[pixel + 1] as usize;
        range.map(|index| columns.fragment(index))
    }

    /// Fragments and borders of media.
    pub(super) fn count(&self) -> u64 {
        let borders = self.media.as_ref().map_or(0, |media| media.depths.len());
        (self.columns.w.len() + borders) as u64
    }

    /// Least and greatest depth of all that is covered, and of media, without room: what
    /// the depths that a file states have to hold.
    pub(super) fn covered(&self) -> [f64; 2] {
        let most = f64::from(f32::MAX);
        let depth = |w: f64| if w > 0.0 { w.recip().min(most) } else { most };
        let fragments = (0..self.columns.w.len()).map(|index| self.columns.fragment(index));
        let depths = fragments.map(|fragment| fragment.covered().map(depth));
        let depths = depths.map(|[far, near]| [near, far]);
        let media = self.media.as_ref().and_then(MediaColumns::range);
        let all = depths.chain(media.map(|range| range.map(f64::from)));
        all.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or([0.0; 2])
    }

    /// Least and greatest depth of all that is covered, and of media, with room for rays
    /// that meet fragments a little beside them.
    pub(super) fn range(&self) -> [f32; 2] {
        let fragments = (0..self.columns.w.len()).map(|index| self.columns.fragment(index));
        let depths = fragments.map(|fragment| {
            let [low, high] = fragment.range();
            let depth = |w: f32| if w > 0.0 { w.recip().min(f32::MAX) } else { f32::MAX };
            [depth(high), depth(low)]
        });
        let range = depths.chain(self.media.as_ref().and_then(MediaColumns::range));
        let range = range.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        range.unwrap_or([0.0; 2])
    }
}

impl<T: Transmittance> MapTile for FragmentTile<T> {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn bytes(&self) -> u64 {
        let columns = &self.columns;
        let words = columns.offsets.len() + columns.facing.len();
        let each = 3 + T::CHANNELS + 2;
        let media = self
            .media
            .as_ref()
            .map_or(0, |media| media.offsets.len() + (1 + T::CHANNELS) * media.depths.len());
        4 * (words + each * columns.w.len() + media) as u64
    }
}
