//! Counts of coherent sampling.

use std::sync::atomic::{AtomicU64, Ordering};

/// The number of cells of lights that receivers saw, and of those traced.
///
/// ```
/// use dsm_trace::detail::CoherenceStatistics;
///
/// let statistics = CoherenceStatistics { receivers: 2, cells: 512, rays: 200, ..Default::default() };
/// assert_eq!(statistics.rays as f64 / statistics.receivers as f64, 100.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoherenceStatistics {
    /// Receivers.
    pub receivers: u64,
    /// Receivers of which every cell was traced, for want of a neighbour.
    pub fresh: u64,
    /// Cells of all receivers.
    pub cells: u64,
    /// Cells that were traced.
    pub rays: u64,
    /// Traced cells whose prediction was wrong.
    pub mispredicted: u64,
}

impl CoherenceStatistics {
    /// Each count and its name's place in [`CoherenceCounters`].
    const fn counts(&self) -> [u64; 5] {
        [self.receivers, self.fresh, self.cells, self.rays, self.mispredicted]
    }
}

/// [`CoherenceStatistics`] that all threads add to.
#[derive(Debug, Default)]
pub(super) struct CoherenceCounters([AtomicU64; 5]);

impl CoherenceCounters {
    pub(super) fn add(&self, counted: &CoherenceStatistics) {
        for (counter, count) in self.0.iter().zip(counted.counts()) {
            counter.fetch_add(count, Ordering::Relaxed);
        }
    }

    pub(super) fn get(&self) -> CoherenceStatistics {
        let counts = self.0.each_ref().map(|counter| counter.load(Ordering::Relaxed));
        let [receivers, fresh, cells, rays, mispredicted] = counts;
        CoherenceStatistics { receivers, fresh, cells, rays, mispredicted }
    }
}
