//! Progress of long work.

use std::ops::ControlFlow;

use dsm_core::Progress;

use crate::error::{Error, Result};

/// Tells `watch` how far the work has come; [`Error::Interrupted`] if it breaks it
/// off.
pub(crate) fn tell(
    watch: &mut impl FnMut(Progress) -> ControlFlow<()>,
    done: impl Into<u64>,
    total: impl Into<u64>,
) -> Result<()> {
    match watch(Progress::new(done.into(), total.into())) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
