//! The plane that a receiver lies in, as the map shows it.

use dsm_core::Transmittance;
use glam::{DMat3, DVec3};

use super::lookup::LevelLists;

/// Texels around a receiver that its surface is looked for in, along a side.
const SIDE: usize = 3;

/// Of these, how many have to show it.
const FEWEST: usize = 5;

/// The steepest surface, in sides of a texel in depth for each across: 83°.
const STEEPEST: f64 = 8.0;

/// How far fragments may be from the plane through them, and the receiver from it, in
/// sides of a texel in depth.
const APART: f64 = 0.3;

/// By how much w of a plane grows per texel to the right, and downwards, if fragments
/// around a receiver lie in one plane with it: of each texel that nearest to it in depth.
/// `side` is what a texel's side in depth is in w.
///
/// # Errors
///
/// What a list cannot be read for.
pub(super) fn own_plane<T: Transmittance, L: LevelLists<T>>(
    lists: &L,
    size: [u32; 2],
    place: [f64; 2],
    w: f64,
    side: f64,
) -> Result<Option<[f64; 2]>, L::Error> {
    let first = place.map(|at| at.floor() - 1.0);
    let is_inside =
        (0..2).all(|axis| first[axis] >= 0.0 && first[axis] + SIDE as f64 <= f64::from(size[axis]));
    if !is_inside {
        return Ok(None);
    }
    // Of each texel that has one, how much nearer to the light its fragment is than the
    // receiver.
    let mut found = [[0.0; 3]; SIDE * SIDE];
    let mut count = 0;
    for texel in 0..SIDE * SIDE {
        let step = [texel % SIDE, texel / SIDE];
        let at = [0, 1].map(|axis| first[axis] as u32 + step[axis] as u32);
        let nearest = lists.with_list(0, at, |list| {
            // The lists fall: the first not above, or the one before it.
            let next = list.count_above(w as f32);
            let of = |at: usize| list.w.get(at).map(|&own| f64::from(own) - w);
            let (above, below) = (next.checked_sub(1).and_then(of), of(next));
            match (above, below) {
                (Some(above), Some(below)) => Some(if above < -below { above } else { below }),
                (above, below) => above.or(below),
            }
        })?;
        if let Some(off) = nearest.filter(|off| off.abs() <= 2.0 * STEEPEST * side) {
            let across = [0, 1].map(|axis| first[axis] + step[axis] as f64 + 0.5 - place[axis]);
            found[count] = [across[0], across[1], off];
            count += 1;
        }
    }
    let found = &found[..count];
    if count < FEWEST {
        return Ok(None);
    }
    let Some([right, down, own]) = plane_through(found) else { return Ok(None) };
    let steep = right.abs().max(down.abs()) / side;
    let room = APART * side * (1.0 + steep);
    let is_near = |&[x, y, off]: &[f64; 3]| (off - own - right * x - down * y).abs() <= room;
    let is_plane = steep <= STEEPEST && own.abs() <= room && found.iter().all(is_near);
    Ok(is_plane.then_some([right, down]))
}

/// The plane of least squares through places (x, y, height): its slopes, and its height
/// at (0, 0).
fn plane_through(places: &[[f64; 3]]) -> Option<[f64; 3]> {
    let mut normal = DMat3::ZERO;
    let mut right = DVec3::ZERO;
    for &[x, y, height] in places {
        let row = DVec3::new(x, y, 1.0);
        normal += DMat3::from_cols(row * x, row * y, row);
        right += row * height;
    }
    // Texels stand one apart: those in one row tell no plane.
    (normal.determinant() > 0.5).then(|| (normal.inverse() * right).to_array())
}

#[cfg(test)]
mod tests {
    use super::super::level_plan::LevelPlan;
    use super::super::lists::FragmentLists;
    use super::super::map::PrefilteredMap;
    use super::*;
    use crate::fragments::oracle::frame;

    /// Fragments at these w; of those below 0 none.
    fn map(w: impl Fn(f64, f64) -> f64) -> PrefilteredMap<f32> {
        let mut lists = FragmentLists::new([8, 8]);
        for texel in 0..64_u32 {
            let own = w(f64::from(texel % 8) + 0.5, f64::from(texel / 8) + 0.5);
            // Others far before and far behind it.
            lists.push(0.9, 1.0);
            if own > 0.0 {
                lists.push(own as f32, 1.0);
            }
            lists.push(0.01, 1.0);
            lists.finish_texel().unwrap();
        }
        let geometry = LevelPlan::BASE.geometry([8, 8]).unwrap();
        PrefilteredMap::of_levels(frame([8, 8], 0.0), vec![lists], geometry)
    }

    fn found(map: &PrefilteredMap<f32>, place: [f64; 2], w: f64) -> Option<[f64; 2]> {
        let Ok(found) = own_plane::<f32, _>(map, [8, 8], place, w, 0.01);
        found
    }

    #[test]
    fn a_plane_is_found_and_nothing_else() {
        let on_plane = |x: f64, y: f64| 0.25 + 0.02 * x - 0.005 * y;
        let place = [3.3, 4.8];
        let w = on_plane(place[0], place[1]);
        let [right, down] = found(&map(on_plane), place, w).unwrap();
        assert!((right - 0.02).abs() < 1e-6 && (down + 0.005).abs() < 1e-6, "{right} {down}");
        // In part of the texels only, as at an outline.
        let edge = map(|x, y| if x < 4.0 { on_plane(x, y) } else { -1.0 });
        let [right, _] = found(&edge, place, w).unwrap();
        assert!((right - 0.02).abs() < 1e-6);
        let corner = map(|x, y| if x < 4.0 && y < 5.0 { on_plane(x, y) } else { -1.0 });
        assert_eq!(found(&corner, place, w), None);
        // Off the plane, on none, too steep, or next to the border.
        assert_eq!(found(&map(on_plane), place, w - 0.02), None);
        let rough = map(|x, y| on_plane(x, y) + 0.03 * ((x * 7.0 + y * 3.0) % 2.0));
        assert_eq!(found(&rough, place, w), None);
        assert_eq!(found(&map(|x, _| 0.1 + 0.1 * x), place, 0.1 + 0.33), None);
        assert_eq!(found(&map(on_plane), [0.3, 4.8], on_plane(0.3, 4.8)), None);
    }
}
