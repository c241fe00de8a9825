//! Lists of four texels as one (Selgrad et al. 2014, §4.2, figure 3).

use dsm_core::Transmittance;
use serde::{Deserialize, Serialize};

use super::accumulate::Accumulate;
use super::epsilon::Reach;
use super::lists::{FragmentList, FragmentLists};

/// The depth of fragments that became one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum MergedDepth {
    /// The mean of their depths: the paper's.
    Mean,
    /// The mean of their 1 / depth, each as much as it takes of the light.
    #[default]
    Weighted,
}

/// How lists become one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Merge {
    pub(super) accumulate: Accumulate,
    pub(super) depth: MergedDepth,
    pub(super) reach: Reach,
}

/// Fragments that become one.
struct Group<S> {
    /// Of each list, its opacities accumulated.
    opacities: [S; 4],
    depth_sum: f64,
    weight: f64,
    last: f32,
}

impl Merge {
    /// Appends the list of a texel that is as large as the texels of all four lists: what
    /// lies within ε of the nearest fragment that is left becomes one with it, again and
    /// again. Opacities of one list are accumulated, and the mean of the four lists is
    /// taken, as they do not overlap. O(fragments).
    pub(super) fn append<T: Transmittance>(
        &self,
        lists: [FragmentList<'_, T>; 4],
        merged: &mut FragmentLists<T>,
    ) {
        let mut at = [0_usize; 4];
        // The nearest fragment that is left of each list; of none what is no w.
        let mut heads = lists.map(|list| list.w.first().copied().unwrap_or(-1.0));
        loop {
            let first = nearest(&heads);
            let start = heads[first];
            if start < 0.0 {
                break;
            }
            let end = self.reach.end(start);
            let zero = T::BLOCKED.to_sum();
            let mut group =
                Group { opacities: [zero; 4], depth_sum: 0.0, weight: 0.0, last: start };
            let mut list = first;
            loop {
                let w = heads[list];
                if w < 0.0 || f64::from(w) < end {
                    break;
                }
                self.add(&mut group, list, w, lists[list].opacities[at[list]]);
                at[list] += 1;
                heads[list] = lists[list].w.get(at[list]).copied().unwrap_or(-1.0);
                list = nearest(&heads);
            }
            let (w, opacity) = self.finish::<T>(start, &group);
            if opacity != T::splat(0.0) {
                merged.push(w, opacity);
            }
        }
    }

    #[inline]
    fn add<T: Transmittance>(&self, group: &mut Group<T::Sum>, list: usize, w: f32, opacity: T) {
        let opacity = opacity.to_sum();
        let so_far = group.opacities[list].as_mut().iter_mut();
        for (so_far, &one) in so_far.zip(opacity.as_ref()) {
            *so_far = self.accumulate.with(*so_far, one);
        }
        let (weight, depth) = match self.depth {
            MergedDepth::Mean => (1.0, f64::from(w).recip()),
            MergedDepth::Weighted => (opacity.as_ref().iter().sum(), f64::from(w)),
        };
        group.weight += weight;
        group.depth_sum += weight * depth;
        group.last = w;
    }

    #[inline]
    fn finish<T: Transmittance>(&self, start: f32, group: &Group<T::Sum>) -> (f32, T) {
        let depth = group.depth_sum / group.weight;
        let w = match self.depth {
            MergedDepth::Mean => depth.recip(),
            MergedDepth::Weighted => depth,
        };
        let mean = T::sum_from_channels(|channel| {
            let of_lists = group.opacities.iter().map(|sum| sum.as_ref()[channel]);
            (of_lists.sum::<f64>() / 4.0).min(1.0)
        });
        ((w as f32).clamp(group.last, start), T::from_sum(mean))
    }
}

/// The list whose next fragment is the nearest to the light.
#[inline]
fn nearest(heads: &[f32; 4]) -> usize {
    let first = if heads[1] > heads[0] { 1 } else { 0 };
    let second = if heads[3] > heads[2] { 3 } else { 2 };
    if heads[second] > heads[first] { second } else { first }
}
