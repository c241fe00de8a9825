//! Fragments in columns, as they are stored.

use dsm_core::detail::Result;
use dsm_core::{Error, Transmittance};

use super::fragment::Fragment;

/// The columns of a [`FragmentMap`](super::map::FragmentMap), as they are stored.
///
/// ```
/// use shadow_maps::detail::{Fragment, FragmentColumns};
///
/// let coverage = Fragment::<f32>::WHOLE;
/// let square = Fragment { w: 0.25, gradient: Some([0.0; 2]), opacity: 1.0_f32, coverage };
/// let strand = Fragment { w: 0.5, gradient: None, opacity: 0.5, coverage: 1 };
/// let mut columns = FragmentColumns::new();
/// columns.push_pixel([])?;
/// columns.push_pixel([square, strand])?;
/// assert_eq!(columns.offsets, [0, 0, 2]);
/// assert_eq!(columns.facing, [0b10]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentColumns<T> {
    /// The index of each pixel's first fragment, row by row, and where the last one's
    /// end: one more than there are pixels.
    pub offsets: Vec<u32>,
    /// [`Fragment::w`].
    pub w: Vec<f32>,
    /// [`Fragment::slope`], to the right and downwards: 0 where there is no plane.
    pub gradients: [Vec<f32>; 2],
    /// Bit i mod 32 of word ⌊i / 32⌋ is set where fragment i has no plane
    /// ([`Fragment::is_facing`]). As many words as that takes; the bits after the
    /// last fragment are 0.
    pub facing: Vec<u32>,
    /// [`Fragment::opacity`].
    pub opacities: Vec<T>,
    /// [`Fragment::coverage`].
    pub coverage: Vec<u64>,
}

impl<T> Default for FragmentColumns<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> FragmentColumns<T> {
    /// The columns of no pixels.
    #[must_use]
    pub fn new() -> Self {
        Self {
            offsets: vec![0],
            w: Vec::new(),
            gradients: [Vec::new(), Vec::new()],
            facing: Vec::new(),
            opacities: Vec::new(),
            coverage: Vec::new(),
        }
    }
}

impl<T: Transmittance> FragmentColumns<T> {
    /// Appends a pixel.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 2³² − 1 fragments.
    pub fn push_pixel(&mut self, fragments: impl IntoIterator<Item = Fragment<T>>) -> Result<()> {
        let Self { offsets, w, gradients, facing, opacities, coverage } = self;
        for fragment in fragments {
            let (word, bit) = (w.len() / 32, w.len() % 32);
            if word == facing.len() {
                facing.push(0);
            }
            facing[word] |= u32::from(fragment.is_facing()) << bit;
            let [along_x, along_y] = fragment.slope();
            w.push(fragment.w);
            gradients[0].push(along_x);
            gradients[1].push(along_y);
            opacities.push(fragment.opacity);
            coverage.push(fragment.coverage);
        }
        let (count, limit) = (w.len() as u64, u64::from(u32::MAX));
        let too_large = |_| Error::TooLarge { what: "fragments", count, limit };
        offsets.push(u32::try_from(count).map_err(too_large)?);
        Ok(())
    }

    /// Checks the columns of `size` pixels against the rules of
    /// [`FragmentMap::new`](super::map::FragmentMap::new). O(fragments).
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] that names the rule which is broken.
    pub fn check(&self, size: [u32; 2]) -> Result<()> {
        let refuse = |pixel, reason| Err(Error::Pixel { pixel, reason });
        let Self { offsets, w, gradients, facing, opacities, coverage } = self;
        let [width, height] = size;
        let pixels = u64::from(width) * u64::from(height);
        if offsets.len() as u64 != pixels + 1 || offsets[0] != 0 {
            return refuse(0, "there must be one list a pixel");
        }
        let lengths = [gradients[0].len(), gradients[1].len(), opacities.len(), coverage.len()];
        if lengths.iter().any(|&length| length != w.len()) || facing.len() != w.len().div_ceil(32) {
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
                let gradient = [gradients[0][at], gradients[1][at]];
                if !w[at].is_finite() || !gradient.iter().all(|number| number.is_finite()) {
                    return refuse(pixel, "a fragment's plane is not finite");
                }
                if self.is_facing(at) && gradient != [0.0; 2] {
                    return refuse(pixel, "a fragment without a plane has a gradient");
                }
                if !in_range(opacities[at]) || coverage[at] == 0 {
                    return refuse(pixel, "a fragment takes nothing away, or too much");
                }
                if at > start && w[at - 1] > w[at] {
                    return refuse(pixel, "its fragments are not sorted");
                }
            }
        }
        let last = offsets.len().saturating_sub(2);
        if offsets[offsets.len() - 1] as usize != w.len() {
            return refuse(last, "fragments of no pixel");
        }
        let bits = w.len() % 32;
        if bits > 0 && facing.last().is_some_and(|word| word >> bits != 0) {
            return refuse(last, "there are flags of no fragment");
        }
        Ok(())
    }

    /// Whether the fragment at `index` has no plane.
    #[inline]
    pub(crate) fn is_facing(&self, index: usize) -> bool {
        self.facing[index / 32] >> (index % 32) & 1 == 1
    }

    /// The fragment at `index`.
    ///
    /// # Panics
    ///
    /// If there is none.
    #[must_use]
    pub fn fragment(&self, index: usize) -> Fragment<T> {
        let gradient = [self.gradients[0][index], self.gradients[1][index]];
        Fragment {
            w: self.w[index],
            gradient: (!self.is_facing(index)).then_some(gradient),
            opacity: self.opacities[index],
            coverage: self.coverage[index],
        }
    }
}
