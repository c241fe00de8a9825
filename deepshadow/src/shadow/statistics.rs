//! Counts of a query's work.

use dsm_core::detail::BiasSummary;
use dsm_trace::detail::{CoherenceStatistics, TraceStatistics};

/// Work that a [`Shadow`](crate::Shadow) has done since it was made.
///
/// ```
/// let idle = deepshadow::ShadowStatistics::default();
/// assert!(idle.rays.is_none() && idle.biases.is_none());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ShadowStatistics {
    /// Rays or taps, of methods that have any.
    pub rays: Option<TraceStatistics>,
    /// The depth biases of all points, of filtered lookups.
    pub biases: Option<BiasSummary>,
    /// Use of a far table, of kinds that may have one.
    pub far_table: Option<bool>,
    /// Cells of the light that were traced, of coherent sampling.
    pub coherence: Option<CoherenceStatistics>,
}
