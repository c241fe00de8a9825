//! Counts of a tracer's rays.

use std::sync::atomic::{AtomicU64, Ordering};

/// The rays of a tracer, and those that its map has no answer for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceStatistics {
    /// Shadow rays.
    pub rays: u64,
    /// Rays that leave the raster at the depths of the map: what stands outside
    /// is not known, and lets all light through.
    pub rays_outside_map: u64,
    /// Rays of receivers that lie no deeper than the light, or at no place at
    /// all (NaN): lit.
    pub receivers_behind_light: u64,
}

/// [`TraceStatistics`] that any thread adds to.
///
/// ```
/// use dsm_trace::TraceStatistics;
/// use dsm_trace::detail::TraceCounters;
///
/// let counters = TraceCounters::default();
/// counters.add(TraceStatistics { rays: 256, rays_outside_map: 3, receivers_behind_light: 0 });
/// assert_eq!(counters.get().rays, 256);
/// ```
#[derive(Debug, Default)]
pub struct TraceCounters {
    rays: AtomicU64,
    rays_outside_map: AtomicU64,
    receivers_behind_light: AtomicU64,
}

impl TraceCounters {
    /// Adds what was counted elsewhere.
    pub fn add(&self, counted: TraceStatistics) {
        let TraceStatistics { rays, rays_outside_map, receivers_behind_light } = counted;
        for (counter, count) in [
            (&self.rays, rays),
            (&self.rays_outside_map, rays_outside_map),
            (&self.receivers_behind_light, receivers_behind_light),
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
            rays_outside_map: self.rays_outside_map.load(Ordering::Relaxed),
            receivers_behind_light: self.receivers_behind_light.load(Ordering::Relaxed),
        }
    }
}
