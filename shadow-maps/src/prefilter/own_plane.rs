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
