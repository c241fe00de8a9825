//! Progress of long work, on a terminal only.

use std::ops::ControlFlow;

use anyhow::Result;
use deepshadow::visibility::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::interrupt::Interrupt;

/// A bar that shows progress until somebody asks to stop.
pub(crate) struct Watch {
    bar: ProgressBar,
    interrupt: Interrupt,
}

impl Watch {
    /// Shows `what` is going on, on a terminal, unless `quiet`.
    pub(crate) fn start(what: &str, quiet: bool) -> Result<Self> {
        Ok(Self { bar: bar(0, what.to_owned(), quiet), interrupt: Interrupt::listen()? })
    }

    /// Shows the progress; breaks the work off if that was asked.
    pub(crate) fn at(&self, progress: Progress) -> ControlFlow<()> {
        self.bar.set_length(progress.total);
        self.bar.set_position(progress.done);
        if self.interrupt.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Sets what is written beside the bar.
    pub(crate) fn set_message(&self, message: String) {
        self.bar.set_message(message);
    }
}

/// The bar goes with the work.
impl Drop for Watch {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A bar over `length` steps on stderr. Nothing is drawn if `quiet` or where
/// nobody looks.
pub(crate) fn bar(length: u64, what: String, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(length), target).with_message(what);
    match ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} % {per_sec} {eta:>4} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
