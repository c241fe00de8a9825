//! An order of receivers in which neighbours follow each other.

use dsm_core::ShadedPoint;
use glam::DVec3;

/// Bits of a place for each axis.
const BITS: u32 = 21;

/// Fills `order` with the indices of `points` along a Hilbert curve through the box
/// around them, whatever order they come in; those that are not finite come last.
/// O(n log n).
pub(super) fn neighbours_first(points: &[ShadedPoint], order: &mut Vec<usize>) {
    let finite = || points.iter().map(|point| point.position).filter(|at| at.is_finite());
    let low = finite().fold(DVec3::INFINITY, DVec3::min);
    let high = finite().fold(DVec3::NEG_INFINITY, DVec3::max);
    let side = (high - low).max_element().max(f64::MIN_POSITIVE);
    let most = f64::from((1_u32 << BITS) - 1);
    let place = |at: DVec3| ((at - low) / side * most).to_array().map(|axis| axis as u32);
    let key = |index: usize| {
        let at = points[index].position;
        let along = if at.is_finite() { along_curve(place(at), BITS) } else { u64::MAX };
        (along, at.to_array().map(f64::to_bits), points[index].seed)
    };
    order.clear();
    order.extend(0..points.len());
    order.sort_by_cached_key(|&index| key(index));
}

/// How far along the Hilbert curve through a cube of 2^`bits` places a side a place
/// lies (Skilling, *Programming the Hilbert curve*, 2004).
fn along_curve(mut place: [u32; 3], bits: u32) -> u64 {
    for bit in (1..bits).rev().map(|bit| 1_u32 << bit) {
        let below = bit - 1;
        for axis in 0..3 {
            if place[axis] & bit != 0 {
                place[0] ^= below;
            } else {
                let swapped = (place[0] ^ place[axis]) & below;
                place[0] ^= swapped;
                place[axis] ^= swapped;
            }
        }
    }
    place[1] ^= place[0];
    place[2] ^= place[1];
    let turned = (1..bits).map(|bit| 1_u32 << bit).filter(|bit| place[2] & bit != 0);
    let turn = turned.fold(0, |turn, bit| turn ^ (bit - 1));
    place.iter_mut().for_each(|axis| *axis ^= turn);
    (0..bits).rev().fold(0, |along, bit| {
        place.iter().fold(along, |along, axis| along << 1 | u64::from(axis >> bit & 1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::Facing;

    fn points(places: impl Iterator<Item = DVec3>) -> Vec<ShadedPoint> {
        let point = |position| ShadedPoint { position, facing: Facing::Light, seed: 0 };
        places.map(point).collect()
    }

    #[test]
    fn the_curve_goes_through_every_place_in_steps_of_one() {
        let mut places: Vec<[u32; 3]> =
            (0..512).map(|index| [index & 7, index >> 3 & 7, index >> 6]).collect();
        places.sort_by_key(|&place| along_curve(place, 3));
        assert!(places.iter().enumerate().all(|(i, &place)| along_curve(place, 3) == i as u64));
        for pair in places.windows(2) {
            let step: u32 = (0..3).map(|axis| pair[0][axis].abs_diff(pair[1][axis])).sum();
            assert_eq!(step, 1, "{pair:?}");
        }
    }

    #[test]
    fn steps_on_a_plane_are_short() {
        // 32 × 32 points, column after column in steps of 13.
        let places = (0..1024).map(|i| DVec3::new((i * 13 % 32).into(), 7e5, (i / 32).into()));
        let points = points(places);
        let mut order = Vec::new();
        neighbours_first(&points, &mut order);
        let mut seen = order.clone();
        seen.sort_unstable();
        assert_eq!(seen, (0..1024).collect::<Vec<_>>());
        let steps = order
            .windows(2)
            .map(|pair| points[pair[0]].position.distance(points[pair[1]].position));
        assert!(steps.sum::<f64>() / 1023.0 < 1.7);
    }

    #[test]
    fn what_is_not_finite_comes_last() {
        let points = points([DVec3::NAN, DVec3::ONE, DVec3::INFINITY, DVec3::ZERO].into_iter());
        let mut order = Vec::new();
        neighbours_first(&points, &mut order);
        assert_eq!(order[..2], [3, 1]);
        neighbours_first(&[], &mut order);
        assert!(order.is_empty());
    }
}
