//! Lists of fragments, one a texel.

use dsm_core::detail::Result;
use dsm_core::{Error, Transmittance};

/// The fragments of a rectangle of texels: each a w = 1 / depth and an opacity, the
/// nearest to the light first.
///
/// Memory: 8 bytes a fragment (16 in colour) and 4 a texel.
///
/// ```
/// use shadow_maps::detail::FragmentLists;
///
/// let mut lists = FragmentLists::new([2, 1]);
/// lists.push(0.5, 1.0_f32);
/// lists.push(0.25, 0.5);
/// lists.finish_texel()?;
/// lists.finish_texel()?;
/// lists.check()?;
/// assert_eq!(lists.list(0).w, [0.5, 0.25]);
/// assert!(lists.list(1).w.is_empty());
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentLists<T> {
    size: [u32; 2],
    /// Where each finished texel's fragments start, and the end.
    starts: Vec<u32>,
    w: Vec<f32>,
    opacities: Vec<T>,
}

/// The fragments of one texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentList<'a, T> {
    /// 1 / depth, never rising.
    pub w: &'a [f32],
    /// What each takes of the light.
    pub opacities: &'a [T],
}

/// What lists of a kind of map are called in messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ListWords {
    /// That a value is out of range.
    pub(crate) range: &'static str,
    /// That a value is 0 in all channels.
    pub(crate) nothing: &'static str,
}

impl ListWords {
    /// Of fragments with opacities.
    pub(crate) const FRAGMENTS: Self =
        Self { range: "opacities must lie in [0, 1]", nothing: "a fragment takes nothing away" };
}

impl<T> FragmentList<'_, T> {
    /// No fragments.
    pub const EMPTY: Self = Self { w: &[], opacities: &[] };
}

impl<T: Transmittance> FragmentLists<T> {
    /// Texels to be filled one by one, row by row.
    #[must_use]
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, starts: vec![0], w: Vec::new(), opacities: Vec::new() }
    }

    /// The fragments in these columns; `starts` has one entry a texel and one for the
    /// end.
    ///
    /// # Errors
    ///
    /// As [`Self::check`].
    pub fn of_columns(
        size: [u32; 2],
        starts: Vec<u32>,
        w: Vec<f32>,
        opacities: Vec<T>,
    ) -> Result<Self> {
        Self::of_named_columns(size, (starts, w, opacities), &ListWords::FRAGMENTS)
    }

    /// The same, of values that are called otherwise.
    pub(crate) fn of_named_columns(
        size: [u32; 2],
        (starts, w, opacities): (Vec<u32>, Vec<f32>, Vec<T>),
        words: &ListWords,
    ) -> Result<Self> {
        let lists = Self { size, starts, w, opacities };
        lists.check_as(words)?;
        Ok(lists)
    }

    /// Texels without fragments.
    #[must_use]
    pub fn empty(size: [u32; 2]) -> Self {
        let texels = size[0] as usize * size[1] as usize;
        Self { size, starts: vec![0; texels + 1], w: Vec::new(), opacities: Vec::new() }
    }

    /// Appends a fragment to the texel that is not finished.
    #[inline]
    pub fn push(&mut self, w: f32, opacity: T) {
        self.w.push(w);
        self.opacities.push(opacity);
    }

    /// Ends the texel and begins the next.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 2³² − 1 fragments.
    #[inline]
    pub fn finish_texel(&mut self) -> Result<()> {
        let (count, limit) = (self.w.len() as u64, u64::from(u32::MAX));
        let too_large = |_| Error::TooLarge { what: "fragments", count, limit };
        self.starts.push(u32::try_from(count).map_err(too_large)?);
        Ok(())
    }

    /// Appends all texels of `other`, which follow those that are here.
    ///
    /// # Errors
    ///
    /// As [`Self::finish_texel`].
    pub fn append(&mut self, other: &Self) -> Result<()> {
        let (before, limit) = (self.w.len() as u64, u64::from(u32::MAX));
        let count = before + other.w.len() as u64;
        if count > limit {
            return Err(Error::TooLarge { what: "fragments", count, limit });
        }
        // Checked above.
        self.starts.extend(other.starts.iter().skip(1).map(|start| before as u32 + start));
        self.w.extend_from_slice(&other.w);
        self.opacities.extend_from_slice(&other.opacities);
        Ok(())
    }

    /// Checks all rules: a list a texel, w positive, finite and never rising within
    /// one, opacities in [0, 1] and not 0 in every channel. O(fragments).
    ///
    /// # Errors
    ///
    /// [`Error::Pixel`] that names the texel and the rule which is broken.
    pub fn check(&self) -> Result<()> {
        self.check_as(&ListWords::FRAGMENTS)
    }

    fn check_as(&self, words: &ListWords) -> Result<()> {
        let refuse = |pixel, reason| Err(Error::Pixel { pixel, reason });
        let texels = self.texels();
        let covers = self.starts.len() == texels + 1
            && self.starts[0] == 0
            && self.starts.is_sorted()
            && self.starts[texels] as usize == self.w.len()
            && self.w.len() == self.opacities.len();
        if !covers {
            return refuse(texels, "the pixel table does not cover the fragments");
        }
        for texel in 0..texels {
            let FragmentList { w, opacities } = self.list(texel);
            let mut before = f32::MAX;
            for &w in w {
                if !(w > 0.0 && w <= before) {
                    let reason = "1 / depth must be finite, above 0 and not rise within a list";
                    return refuse(texel, reason);
                }
                before = w;
            }
            for &opacity in opacities {
                let mut channels = (0..T::CHANNELS).map(|channel| opacity.channel(channel));
                if !channels.all(|value| (0.0..=1.0).contains(&value)) {
                    return refuse(texel, words.range);
                }
                if opacity == T::splat(0.0) {
                    return refuse(texel, words.nothing);
                }
            }
        }
        Ok(())
    }

    /// Width and height in texels.
    #[must_use]
    #[inline]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of texels.
    #[must_use]
    pub const fn texels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Number of fragments.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.w.len()
    }

    /// True without any fragment.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.w.is_empty()
    }

    /// Where each texel's fragments start, and the end.
    #[must_use]
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// 1 / depth of all fragments.
    #[must_use]
    pub fn w(&self) -> &[f32] {
        &self.w
    }

    /// The opacities of all fragments.
    #[must_use]
    pub fn opacities(&self) -> &[T] {
        &self.opacities
    }

    /// The list of the texel with row-major index `texel`.
    ///
    /// # Panics
    ///
    /// If there is none.
    #[must_use]
    #[inline]
    pub fn list(&self, texel: usize) -> FragmentList<'_, T> {
        let range = self.starts[texel] as usize..self.starts[texel + 1] as usize;
        FragmentList { w: &self.w[range.clone()], opacities: &self.opacities[range] }
    }

    /// The list of texel (`x`, `y`); none outside.
    #[must_use]
    #[inline]
    pub fn at(&self, x: i64, y: i64) -> FragmentList<'_, T> {
        let [width, height] = self.size.map(i64::from);
        if (0..width).contains(&x) && (0..height).contains(&y) {
            self.list((y * width + x) as usize)
        } else {
            FragmentList::EMPTY
        }
    }

    /// The lists of the texels from (`x`, `y`) on, `size` of them.
    ///
    /// # Errors
    ///
    /// As [`Self::finish_texel`].
    pub(crate) fn part(&self, x: u32, y: u32, size: [u32; 2]) -> Result<Self> {
        let mut part = Self::new(size);
        for row in y..y + size[1] {
            for column in x..x + size[0] {
                let list = self.at(column.into(), row.into());
                part.w.extend_from_slice(list.w);
                part.opacities.extend_from_slice(list.opacities);
                part.finish_texel()?;
            }
        }
        Ok(part)
    }

    /// The least and the greatest depth; `None` without fragments.
    #[must_use]
    pub fn depth_range(&self) -> Option<[f32; 2]> {
        let ends = self
            .w
            .iter()
            .fold([f32::INFINITY, 0.0], |[low, high]: [f32; 2], &w| [low.min(w), high.max(w)]);
        let depth = |w: f32| w.recip().min(f32::MAX);
        (!self.is_empty()).then(|| [depth(ends[1]), depth(ends[0])])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_sound_columns_are_lists() {
        let starts = || vec![0, 2, 2, 3];
        let (w, opacities) = (vec![0.5, 0.25, 0.125], vec![0.5_f32, 1.0, 0.25]);
        let make = |starts, w, opacities| FragmentLists::of_columns([3, 1], starts, w, opacities);
        let lists = make(starts(), w.clone(), opacities.clone()).unwrap();
        assert_eq!(lists.at(2, 0).w, [0.125]);
        assert_eq!((lists.at(3, 0).w, lists.at(0, -1).w), (&[][..], &[][..]));
        assert_eq!(lists.depth_range(), Some([2.0, 8.0]));
        for starts in [vec![0, 2, 2], vec![1, 2, 2, 3], vec![0, 2, 1, 3], vec![0, 2, 2, 2]] {
            assert!(make(starts, w.clone(), opacities.clone()).is_err());
        }
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 0.3] {
            assert!(make(starts(), vec![0.25, bad, 0.125], opacities.clone()).is_err(), "{bad}");
        }
        for bad in [0.0, -0.5, 1.5, f32::NAN] {
            assert!(make(starts(), w.clone(), vec![0.5, bad, 1.0]).is_err(), "{bad}");
        }
    }
}
