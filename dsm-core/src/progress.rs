//! Progress of long work.

use std::ops::ControlFlow;

/// The progress of long work, reported to the caller, who may cancel it by
/// answering [`ControlFlow::Break`]: bakes, conversions, merges, mip levels,
/// comparisons and pictures.
///
/// ```
/// use std::ops::ControlFlow;
/// use dsm_core::Progress;
///
/// let watch = |progress: Progress| {
///     println!("{} of {}", progress.done, progress.total);
///     if progress.done > 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
/// };
/// assert!(watch(Progress::new(11, 20)).is_break());
/// assert!(Progress::ignore(Progress::new(11, 20)).is_continue());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Steps that are done: tiles, rows or blocks.
    pub done: u64,
    /// All steps.
    pub total: u64,
}

impl Progress {
    /// Progress of `done` out of `total` steps.
    #[must_use]
    pub const fn new(done: u64, total: u64) -> Self {
        Self { done, total }
    }

    /// Continues, whatever the progress.
    pub const fn ignore(self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
