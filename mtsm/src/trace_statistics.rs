//! What tracers count.

use std::sync::atomic::{AtomicU64, Ordering};

/// What a tracer was asked, and could not answer from its map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceStatistics {
    /// Shadow rays.
    pub rays: u64,
    /// Rays that leave the raster at the depths of the map: what stands outside
    /// is not known, and lets all light through.
    pub leaving: u64,
    /// Rays of receivers that lie no deeper than the light, or at no place at
    /// all (NaN): lit.
    pub beside: u64,
}

/// Counts from any thread.
#[derive(Debug, Default)]
pub(crate) struct TraceCounters {
    rays: AtomicU64,
    leaving: AtomicU64,
    beside: AtomicU64,
}

impl TraceCounters {
    pub(crate) fn add(&self, counted: TraceStatistics) {
        let TraceStatistics { rays, leaving, beside } = counted;
        for (counter, count) in
            [(&self.rays, rays), (&self.leaving, leaving), (&self.beside, beside)]
        {
            if count > 0 {
                counter.fetch_add(count, Ordering::Relaxed);
            }
        }
    }

    pub(crate) fn get(&self) -> TraceStatistics {
        TraceStatistics {
            rays: self.rays.load(Ordering::Relaxed),
            leaving: self.leaving.load(Ordering::Relaxed),
            beside: self.beside.load(Ordering::Relaxed),
        }
    }
}
