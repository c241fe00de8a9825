//! Settings of coherent sampling.

/// How [`CoherentShadow`](super::coherent_shadow::CoherentShadow) samples a light.
///
/// ```
/// use dsm_trace::detail::CoherenceSettings;
///
/// let settings = CoherenceSettings::new(16).with_reach(0.1);
/// assert_eq!((settings.side(), settings.rays()), (16, 256));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CoherenceSettings {
    side: u32,
    reach: f64,
    predicts: bool,
    covers: bool,
}

/// The most cells along a side of the light.
pub const MOST_CELLS: u32 = 256;

impl CoherenceSettings {
    /// `side` × `side` cells, 1 to [`MOST_CELLS`] along a side, and the defaults
    /// for the rest.
    #[must_use]
    pub const fn new(side: u32) -> Self {
        let side = if side < 1 { 1 } else { side };
        let side = if side > MOST_CELLS { MOST_CELLS } else { side };
        Self { side, reach: 0.05, predicts: true, covers: false }
    }

    /// Sets how far from the receiver before a receiver may lie, as a share of its
    /// distance from the light's centre, for that one's blockers to count: at least
    /// 0. Beyond, all cells are traced. Larger is faster, and misses more.
    #[must_use]
    pub const fn with_reach(self, reach: f64) -> Self {
        Self { reach: reach.max(0.0), ..self }
    }

    /// Sets whether anything is predicted; if not, every cell is traced. Not, where
    /// something moves: blockers of other times say nothing.
    #[must_use]
    pub const fn with_prediction(self, predicts: bool) -> Self {
        Self { predicts, ..self }
    }

    /// Sets whether a cell counts as blocked without a ray, at an edge too, where a
    /// blocker of another ray lies within a third of a cell of its sample (§5.2.2).
    /// Faster; thin occluders become thicker by it.
    #[must_use]
    pub const fn with_covered_samples(self, covers: bool) -> Self {
        Self { covers, ..self }
    }

    /// Cells along a side of the light.
    #[must_use]
    pub const fn side(&self) -> u32 {
        self.side
    }

    /// Cells of the light, each with a ray if nothing is predicted.
    #[must_use]
    pub const fn rays(&self) -> u32 {
        self.side * self.side
    }

    /// See [`Self::with_reach`].
    #[must_use]
    pub const fn reach(&self) -> f64 {
        self.reach
    }

    /// See [`Self::with_prediction`].
    #[must_use]
    pub const fn predicts(&self) -> bool {
        self.predicts
    }

    /// See [`Self::with_covered_samples`].
    #[must_use]
    pub const fn covers(&self) -> bool {
        self.covers
    }
}
