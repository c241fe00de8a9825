//! Merging and lookups as naively as can be, in `f64`.

use dsm_core::Transmittance;

use super::accumulate::Accumulate;
use super::level_plan::LevelGeometry;
use super::lists::{FragmentList, FragmentLists};
use super::lookup::{LightCone, nearest_of};
use super::merge::MergedDepth;
use super::sums::optical_depth;

/// Figure 3 of the paper over all fragments at once: each a w, its list, an opacity.
pub(super) fn merged<T: Transmittance>(
    lists: [FragmentList<'_, T>; 4],
    reaches: impl Fn(f64, f64) -> bool,
    accumulate: Accumulate,
    depth: MergedDepth,
) -> Vec<(f64, T::Sum)> {
    let mut left: Vec<(f64, usize, T::Sum)> = Vec::new();
    for (index, list) in lists.iter().enumerate() {
        let fragments = list.w.iter().zip(list.opacities);
        left.extend(fragments.map(|(&w, opacity)| (f64::from(w), index, opacity.to_sum())));
    }
    left.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut merged = Vec::new();
    while let Some(&(nearest, ..)) = left.first() {
        let (group, rest): (Vec<_>, Vec<_>) =
            left.iter().partition(|&&(w, ..)| reaches(nearest, w));
        left = rest;
        let weight = |opacity: &T::Sum| -> f64 { opacity.as_ref().iter().sum() };
        let w = match depth {
            MergedDepth::Mean => {
                group.len() as f64 / group.iter().map(|(w, ..)| w.recip()).sum::<f64>()
            }
            MergedDepth::Weighted => {
                let all: f64 = group.iter().map(|(.., opacity)| weight(opacity)).sum();
                group.iter().map(|(w, _, opacity)| w * weight(opacity)).sum::<f64>() / all
            }
        };
        let opacity = T::sum_from_channels(|channel| {
            let of_list = |list: usize| {
                let own = group.iter().filter(|(_, index, _)| *index == list);
                let own: Vec<f64> = own.map(|(.., opacity)| opacity.as_ref()[channel]).collect();
                match accumulate {
                    Accumulate::Add => own.iter().sum::<f64>(),
                    Accumulate::Multiply => 1.0 - own.iter().map(|a| 1.0 - a).product::<f64>(),
                    Accumulate::Max => own.into_iter().fold(0.0, f64::max),
                }
            };
            ((0..4).map(of_list).sum::<f64>() / 4.0).min(1.0)
        });
        merged.push((w, opacity));
    }
    merged
}

/// What counts of a fragment at a filter of `size`, of level `level`.
fn weight(size: f64, sizes: &[f64], level: usize) -> f64 {
    let last = sizes.len() - 1;
    if size <= sizes[0] || size >= sizes[last] {
        let nearest = if size <= sizes[0] { 0 } else { last };
        return if level == nearest { 1.0 } else { 0.0 };
    }
    let finer = (0..last).find(|&level| size < sizes[level + 1]).unwrap();
    let share = (size - sizes[finer]) / (sizes[finer + 1] - sizes[finer]);
    match level {
        _ if level == finer => 1.0 - share,
        _ if level == finer + 1 => share,
        _ => 0.0,
    }
}

/// The visibility of a light that is no point: every fragment of every texel of every
/// level is looked at.
pub(super) fn visibility<T: Transmittance>(
    levels: &[(FragmentLists<T>, LevelGeometry)],
    cone: &LightCone,
    accumulate: Accumulate,
) -> T::Sum {
    let sizes: Vec<f64> = levels.iter().map(|(_, level)| level.filter_size()).collect();
    T::sum_from_channels(|channel| {
        let (mut product, mut sum) = (1.0, 0.0);
        let mut between = vec![0.0_f64; levels.len() + 1];
        for (index, (lists, level)) in levels.iter().enumerate() {
            let nearest = lists.depth_range().map_or(0.0, |[depth, _]| nearest_of(depth));
            let along = (cone.w + sizes[index] / cone.rate).min(nearest.max(cone.w)) - cone.w;
            let place = [0, 1].map(|axis| cone.place[axis] + cone.slope[axis] * along);
            let (mut mean, mut all) = (0.0, 0.0);
            let (mut finer, mut coarser) = (0.0, 0.0);
            for texel in 0..lists.texels() {
                let width = lists.size()[0] as usize;
                let at = [texel % width, texel / width];
                let centre = level.centre(at.map(|index| index as f64));
                let tent = |axis: usize| {
                    let off = (centre[axis] - place[axis]).abs() / f64::from(level.spacing);
                    (1.0 - off).max(0.0)
                };
                let share = tent(0) * tent(1);
                all += share;
                let start = cone.least.max(match cone.plane {
                    None => cone.start,
                    Some(plane) => {
                        let across = [0, 1]
                            .map(|axis| plane.slope[axis] * (centre[axis] - cone.place[axis]));
                        let on_plane = cone.w + across[0] + across[1] + plane.offset;
                        if plane.is_lit { on_plane.max(cone.start) } else { on_plane }
                    }
                });
                let list = lists.list(texel);
                let (mut depth, mut taken, mut most) = (0.0, 0.0, [0.0_f64; 2]);
                for (&w, opacity) in list.w.iter().zip(list.opacities) {
                    let w = f64::from(w);
                    if w <= start {
                        continue;
                    }
                    let size = (w - cone.w) * cone.rate;
                    let weight = weight(size, &sizes, index);
                    let opacity = opacity.to_sum().as_ref()[channel];
                    depth += weight * optical_depth(opacity);
                    taken += weight * opacity;
                    let side = usize::from(size > sizes[index]);
                    most[side] = most[side].max(weight * opacity);
                }
                mean += share * (-depth).exp();
                sum += share * taken;
                finer += share * most[0];
                coarser += share * most[1];
            }
            product *= mean + (1.0 - all).max(0.0);
            between[index] += finer;
            between[index + 1] += coarser;
        }
        match accumulate {
            Accumulate::Multiply => product,
            Accumulate::Add => 1.0 - sum.min(1.0),
            Accumulate::Max => 1.0 - between.into_iter().fold(0.0, f64::max).min(1.0),
        }
    })
}
