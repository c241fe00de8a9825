//! Which fragments of a level count, and how much (Selgrad et al. 2014, §5.2).

/// The weight of a level's fragments by their w: 0 up to the place of the finer level, 1
/// at its own, 0 from the coarser one's on, linear between. The finest level counts in
/// full up to its own place, the coarsest beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hat {
    /// The places of the finer level, of this one and of the coarser.
    pub(super) knots: [f64; 3],
}

impl Hat {
    /// The hats of levels at these places, which rise.
    pub(super) fn of_places(places: &[f64], level: usize) -> Self {
        let before = level.checked_sub(1).map_or(f64::NEG_INFINITY, |before| places[before]);
        let after = places.get(level + 1).copied().unwrap_or(f64::INFINITY);
        Self { knots: [before, places[level], after] }
    }

    /// The weight at `w`.
    #[inline]
    pub(super) fn weight(&self, w: f64) -> f64 {
        let [before, own, after] = self.knots;
        let rising = if before.is_finite() { (w - before) / (own - before) } else { 1.0 };
        let falling = if after.is_finite() { (after - w) / (after - own) } else { 1.0 };
        rising.min(falling).clamp(0.0, 1.0)
    }

    /// How fast the weight rises, and falls, per unit of w.
    #[inline]
    pub(super) fn slopes(&self) -> [f64; 2] {
        let [before, own, after] = self.knots;
        let slope = |from: f64, to: f64| {
            if from.is_finite() && to.is_finite() { (to - from).recip() } else { 0.0 }
        };
        [slope(before, own), slope(own, after)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        let places = [1.0, 2.5, 3.0, 7.0];
        let hats: Vec<_> = (0..4).map(|level| Hat::of_places(&places, level)).collect();
        for step in 0..100 {
            let w = f64::from(step) / 10.0;
            let sum: f64 = hats.iter().map(|hat| hat.weight(w)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{w}");
        }
        assert_eq!(hats[0].weight(0.0), 1.0);
        assert_eq!(hats[3].weight(9.0), 1.0);
        assert_eq!((hats[1].weight(1.75), hats[1].slopes()[1]), (0.5, 2.0));
    }
}
