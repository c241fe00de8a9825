//! Statistics of traced rays.

use std::sync::atomic::{AtomicU64, Ordering};

/// The number of traced rays, and of those without an answer in the map.
///
/// ```
/// use dsm_trace::detail::TraceStatistics;
///
/// let statistics = TraceStatistics { rays: 256, outside_map: 64, behind_light: 0 };
/// assert_eq!(statistics.rays - statistics.outside_map, 192);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceStatistics {
    /// Shadow rays.
    pub rays: u64,
    /// Rays that leave the raster at the depths of the map: occluders outside are
    /// unknown, and taken for none.
    pub outside_map: u64,
    /// Rays of receivers that lie no deeper than the light, or whose position is
    /// NaN: lit.
    pub behind_light: u64,
}

/// [`TraceStatistics`] that all threads add to.
///
/// ```
/// use dsm_trace::detail::{TraceCounters, TraceStatistics};
///
/// let counters = TraceCounters::default();
/// counters.add(TraceStatistics { rays: 256, outside_map: 3, behind_light: 0 });
/// assert_eq!(counters.get().rays, 256);
/// ```
#[derive(Debug, Default)]
pub struct TraceCounters {
    rays: AtomicU64,
    outside_map: AtomicU64,
    behind_light: AtomicU64,
}

impl TraceCounters {
    /// Adds the counts of one thread.
    pub fn add(&self, counted: TraceStatistics) {
        let TraceStatistics { rays, outside_map, behind_light } = counted;
        for (counter, count) in [
            (&self.rays, rays),
            (&self.outside_map, outside_map),
            (&self.behind_light, behind_light),
        ] {
            if count > 0 {
                counter.fetch_add(count, Ordering::Relaxed);
            }
        }
    }

    /// The sums so far.
    #[must_use]
    pub fn get(&self) -> TraceStatistics {
        TraceStatistics {
            rays: self.rays.load(Ordering::Relaxed),
            outside_map: self.outside_map.load(Ordering::Relaxed),
            behind_light: self.behind_light.load(Ordering::Relaxed),
        }
    }
}
