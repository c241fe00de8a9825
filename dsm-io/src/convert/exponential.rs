//! The error of the chord of a volume's exponential.
//!
//! Between depths a share x apart, a volume lets e^(−Lx) of the light
//! through; a ramp with the same ends lets 1 − (1 − e^(−L)) x through. They
//! are furthest apart where the slopes agree: with s = (1 − e^(−L)) / L at
//! x = −ln(s) / L, where e^(−Lx) = s.

/// The largest distance between the two, for a fall L = ln(before / after);
/// about L²/8 while that is small, 1 at infinity. Increases with L, L²'s share
/// in it decreases.
fn chord_distance(fall: f64) -> f64 {
    let drop = -(-fall).exp_m1();
    let slope = drop / fall;
    1.0 + drop * slope.ln() / fall - slope
}

/// Whether the two stay within `distance` for this fall, which may be
/// infinite or 0.
pub(super) fn keeps_to_chord(fall: f64, distance: f64) -> bool {
    distance >= 1.0 || fall * fall <= 8.0 * distance || chord_distance(fall) <= distance
}

/// A fall that keeps within `distance` of its chord, in (0, 1): close to the
/// largest one.
pub(super) fn longest_fall(distance: f64) -> f64 {
    // L² grows faster than the distance: each step keeps within it.
    const STEPS: usize = 6;
    (0..STEPS).fold((8.0 * distance).sqrt(), |fall, _| {
        fall * (distance / chord_distance(fall)).sqrt().max(1.0)
    })
}

/// The largest |chord − exponential| where the ends of the two may differ: the
/// chord goes from `chord[0]` to `chord[1]`, the exponential from `curve[0]`
/// to `curve[1]`.
pub(super) fn largest_difference(chord: [f64; 2], curve: [f64; 2]) -> f64 {
    let ends = (chord[0] - curve[0]).abs().max((chord[1] - curve[1]).abs());
    let fall = (curve[0] / curve[1]).ln();
    if !(fall > 0.0 && fall.is_finite()) {
        return ends;
    }
    // Where the slopes agree.
    let value = (chord[0] - chord[1]) / fall;
    let share = (curve[0] / value).ln() / fall;
    if !(0.0..=1.0).contains(&share) {
        return ends;
    }
    ends.max((chord[0] + (chord[1] - chord[0]) * share - value).abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest difference by looking everywhere.
    fn searched(chord: [f64; 2], curve: [f64; 2]) -> f64 {
        let difference = |i: i32| {
            let x = f64::from(i) / 1e5;
            let exponential = curve[0] * (curve[1] / curve[0]).powf(x);
            (chord[0] + (chord[1] - chord[0]) * x - exponential).abs()
        };
        (0..=100_000).map(difference).fold(0.0, f64::max)
    }

    #[test]
    fn the_distance_is_the_largest_there_is() {
        for fall in [1e-3_f64, 0.01, 0.5, 1.0, 3.0, 20.0] {
            let ends = [1.0, (-fall).exp()];
            let searched = searched(ends, ends);
            assert!((chord_distance(fall) - searched).abs() < 1e-8 * fall, "{fall}");
            assert!((largest_difference(ends, ends) - searched).abs() < 1e-8 * fall, "{fall}");
            assert!(keeps_to_chord(fall, 1.01 * searched), "{fall}");
            assert!(!keeps_to_chord(fall, 0.99 * searched), "{fall}");
        }
        assert!(keeps_to_chord(f64::INFINITY, 1.0) && !keeps_to_chord(f64::INFINITY, 0.9));
        assert!(keeps_to_chord(0.0, 1e-9));
    }

    #[test]
    fn differences_with_other_ends_are_the_largest_there_are() {
        for (chord, curve) in [
            ([1.0, 0.5], [0.9, 0.6]),
            ([0.5, 0.4], [0.5004, 0.3998]),
            ([0.3, 0.3], [0.3, 0.2]),
            ([0.8, 0.0], [0.8, 1e-4]),
            ([0.8, 0.1], [0.8, 0.8]),
        ] {
            let difference = largest_difference(chord, curve);
            assert!((difference - searched(chord, curve)).abs() < 1e-6, "{chord:?} {curve:?}");
        }
    }

    #[test]
    fn the_longest_fall_keeps_within_its_distance_and_is_not_short() {
        for exponent in -24..0 {
            let distance = 2_f64.powi(exponent);
            let fall = longest_fall(distance);
            assert!(chord_distance(fall) <= distance * (1.0 + 1e-7), "{distance}");
            assert!(chord_distance(1.2 * fall) > distance, "{distance}");
        }
    }
}
