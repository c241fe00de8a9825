//! Progress of long work.

use std::ops::ControlFlow;

use dsm_core::Progress;

use crate::error::{Error, Result};

/// Who is told how far long work has come, and may break it off. What is told a tile or a row at a
/// time need not be compiled for every caller: the crate's doors alone are.
pub(crate) type Watch<'a> = &'a mut dyn FnMut(Progress) -> ControlFlow<()>;

/// Tells `watch` how far the work has come; [`Error::Interrupted`] if it breaks it
/// off.
pub(crate) fn tell(watch: Watch<'_>, done: impl Into<u64>, total: impl Into<u64>) -> Result<()> {
    match watch(Progress::new(done.into(), total.into())) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
