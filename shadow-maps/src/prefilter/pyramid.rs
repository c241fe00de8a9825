//! All levels of a map from its finest (Selgrad et al. 2014, §4.2).

use dsm_core::Transmittance;
use dsm_core::detail::Result;
use rayon::prelude::*;

use super::level_plan::{LevelGeometry, LevelPlan};
use super::lists::{FragmentList, FragmentLists};
use super::merge::Merge;
use super::settings::PrefilterSettings;

/// The levels above `base`, with `base` first, and where their texels stand. `texel` is
/// the side of a texel of level 0 at depth 1, `light` the width of the light, which some
/// choices of ε follow. Every texel is a function of four: the same on any number of
/// threads. O(fragments of all levels).
///
/// # Errors
///
/// [`Error::Level`](dsm_core::Error::Level) for a level that the map cannot have,
/// [`Error::Setting`](dsm_core::Error::Setting) for an ε that is none,
/// [`Error::TooLarge`](dsm_core::Error::TooLarge) past 2³² fragments of a level.
pub(super) fn filtered<T: Transmittance>(
    base: FragmentLists<T>,
    settings: &PrefilterSettings,
    texel: f64,
    light: f64,
) -> Result<(Vec<FragmentLists<T>>, Vec<LevelGeometry>)> {
    let (plan, geometry) = settings.plan(base.size())?;
    let merge = |level: &LevelGeometry| -> Result<Merge> {
        let reach = settings.epsilon.reach(f64::from(level.width), texel, light)?;
        Ok(Merge { accumulate: settings.accumulate, depth: settings.depth, reach })
    };
    let base = if settings.joined { joined(&base, &merge(&geometry[0])?)? } else { base };
    let mut levels = vec![base];
    for (number, level) in (0..).zip(&geometry).skip(1) {
        let finer = &levels[levels.len() - 1];
        let (before, merge) = (&geometry[levels.len() - 1], merge(level)?);
        levels.push(coarser(finer, before, level, number, &plan, &merge)?);
    }
    Ok((levels, geometry))
}

/// Fragments of one list that lie within ε, joined.
fn joined<T: Transmittance>(base: &FragmentLists<T>, merge: &Merge) -> Result<FragmentLists<T>> {
    by_rows(base.size(), |x, y, out| {
        // Four times the same: their mean is any of them.
        merge.append([base.at(x, y); 4], out);
    })
}

/// The next level of `finer`.
fn coarser<T: Transmittance>(
    finer: &FragmentLists<T>,
    before: &LevelGeometry,
    level: &LevelGeometry,
    number: u32,
    plan: &LevelPlan,
    merge: &Merge,
) -> Result<FragmentLists<T>> {
    if !level.is_stack && number <= plan.subsampled {
        return by_rows(level.size, |x, y, out| {
            // In turn, so that the level stands where it should.
            let (right, down) = ((x + y) & 1, y & 1);
            let FragmentList { w, opacities } = finer.at(2 * x + right, 2 * y + down);
            w.iter().zip(opacities).for_each(|(&w, &opacity)| out.push(w, opacity));
        });
    }
    // How far the two texels of an axis are apart, and where the first is from twice or
    // once the texel's own number.
    let (step, apart, first) = if !level.is_stack {
        (2, 1, [0; 2])
    } else {
        let apart = 1_i64 << (number - plan.stack_from.unwrap_or(number) - 1);
        // The first level of a stack stands on corners: it looks one texel back.
        let back = if before.is_stack { apart / 2 } else { 1 };
        let apart = if before.is_stack { apart } else { 1 };
        let origins = [0, 1].map(|axis| i64::from(level.origin[axis] - before.origin[axis]));
        (1, apart, origins.map(|origin| origin - back))
    };
    by_rows(level.size, |x, y, out| {
        let (x, y) = (step * x + first[0], step * y + first[1]);
        let places = [(x, y), (x + apart, y), (x, y + apart), (x + apart, y + apart)];
        merge.append(places.map(|(x, y)| finer.at(x, y)), out);
    })
}

/// Lists that `make` appends texel by texel, on all threads.
fn by_rows<T: Transmittance>(
    size: [u32; 2],
    make: impl Fn(i64, i64, &mut FragmentLists<T>) + Sync,
) -> Result<FragmentLists<T>> {
    let [width, height] = size;
    let rows: Result<Vec<_>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let mut row = FragmentLists::new([width, 1]);
            for x in 0..width {
                make(x.into(), y.into(), &mut row);
                row.finish_texel()?;
            }
            Ok(row)
        })
        .collect();
    let mut all = FragmentLists::new(size);
    rows?.iter().try_for_each(|row| all.append(row))?;
    Ok(all)
}
