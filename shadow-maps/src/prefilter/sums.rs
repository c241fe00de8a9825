//! Sums over the beginnings of lists, in place of walks through them.

use dsm_core::Transmittance;

use super::lists::FragmentLists;

/// What an opacity counts for at most, so that optical depths are finite: all but
/// 10⁻⁴ of the light.
const MOST: f64 = 1.0 - 1e-4;

/// The optical depth of an opacity.
#[inline]
pub(super) fn optical_depth(opacity: f64) -> f64 {
    -(-opacity.min(MOST)).ln_1p()
}

/// For each list, and each number of its nearest fragments from 0 to all, the sum of
/// their optical depths τ and that of τ (w − w₀), w₀ being the list's last w.
///
/// A weight that is linear in w between two places sums to differences of these: no
/// fragment is visited.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ListSums<T> {
    sums: Vec<[T; 2]>,
}

/// The sums of one list.
#[derive(Clone, Copy, Debug)]
pub struct ListView<'a, T> {
    pub(super) w: &'a [f32],
    pub(super) opacities: &'a [T],
    /// One more than there are fragments.
    sums: &'a [[T; 2]],
}

impl<T: Transmittance> ListSums<T> {
    /// O(fragments).
    pub(super) fn new(lists: &FragmentLists<T>) -> Self {
        let mut sums = Vec::with_capacity(lists.len() + lists.texels());
        for texel in 0..lists.texels() {
            let list = lists.list(texel);
            let origin = list.w.last().map_or(0.0, |&w| f64::from(w));
            let mut depth = T::BLOCKED.to_sum();
            let mut moment = depth;
            sums.push([T::BLOCKED; 2]);
            for (&w, opacity) in list.w.iter().zip(list.opacities) {
                let above = f64::from(w) - origin;
                let opacity = opacity.to_sum();
                for channel in 0..T::CHANNELS {
                    let own = optical_depth(opacity.as_ref()[channel]);
                    depth.as_mut()[channel] += own;
                    moment.as_mut()[channel] += own * above;
                }
                sums.push([T::from_sum(depth), T::from_sum(moment)]);
            }
        }
        Self { sums }
    }

    /// The list of a texel.
    #[inline]
    pub(super) fn view<'a>(&'a self, lists: &'a FragmentLists<T>, texel: usize) -> ListView<'a, T> {
        let list = lists.list(texel);
        let start = lists.starts()[texel] as usize + texel;
        let sums = &self.sums[start..=start + list.w.len()];
        ListView { w: list.w, opacities: list.opacities, sums }
    }

    /// Bytes of memory.
    pub(super) const fn bytes(&self) -> u64 {
        size_of_val(self.sums.as_slice()) as u64
    }
}

impl<'a, T: Transmittance> ListView<'a, T> {
    /// No fragments; `zero` is the sum of none.
    #[inline]
    pub(super) const fn empty(zero: &'a [[T; 2]; 1]) -> Self {
        Self { w: &[], opacities: &[], sums: zero }
    }

    /// Number of fragments with a larger w: they come first.
    #[inline]
    pub(super) fn count_above(&self, w: f32) -> usize {
        // Short lists are compared faster than they are searched.
        if self.w.len() <= 48 {
            self.w.iter().map(|&own| usize::from(own > w)).sum()
        } else {
            self.w.partition_point(|&own| own > w)
        }
    }

    /// Of the fragments above `w` the sum of the optical depths, and that of τ (own − w).
    #[inline]
    pub(super) fn above(&self, w: f32) -> [T; 2] {
        let [depth, moment] = self.sums[self.count_above(w)];
        let over = w - self.w.last().copied().unwrap_or(w);
        let ramp = |channel: usize| moment.channel(channel) - over * depth.channel(channel);
        [depth, T::from_channels(ramp)]
    }
}
