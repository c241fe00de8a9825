//! Long work: its threads, a caller's progress function, and Ctrl-C.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use deepshadow::visibility::Progress;
use pyo3::prelude::*;

use crate::error::{Failure, Result};
use crate::threads;

/// How often signals are looked for and progress is told.
const INTERVAL: Duration = Duration::from_millis(50);

/// How far some work has come, and whether it shall end.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    done: AtomicU64,
    total: AtomicU64,
    is_stopped: AtomicBool,
}

impl Watch {
    /// Notes how far the work has come, from any thread.
    pub(crate) fn at(&self, progress: Progress) -> ControlFlow<()> {
        self.total.store(progress.total, Ordering::Relaxed);
        self.done.fetch_max(progress.done, Ordering::Relaxed);
        if self.is_stopped.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn now(&self) -> (u64, u64) {
        (self.done.load(Ordering::Relaxed), self.total.load(Ordering::Relaxed))
    }
}

/// The caller's progress function, and what it was told last.
struct Teller<'a> {
    function: Option<&'a Py<PyAny>>,
    told: (u64, u64),
}

impl Teller<'_> {
    /// Tells the caller and runs handlers of signals. Only the thread that called in may
    /// do that: handlers run on no other.
    fn tell(&mut self, now: (u64, u64)) -> Result<()> {
        Python::attach(|py| {
            py.check_signals()?;
            let Some(function) = self.function.filter(|_| now != self.told) else { return Ok(()) };
            self.told = now;
            let answer = function.bind(py).call1(now)?;
            if answer.is_none() || answer.is_truthy()? { Ok(()) } else { Err(Failure::cancelled()) }
        })
    }
}

/// Runs `work` on `threads` threads without the interpreter's lock. Meanwhile `progress`
/// is called with what is done and of how much; an exception of it, a false answer or
/// Ctrl-C ends the work.
pub(crate) fn run<R, E>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Watch) -> std::result::Result<R, E> + Send,
) -> Result<R>
where
    R: Send,
    E: Into<Failure> + Send,
{
    let pool = threads::pool(threads)?;
    let watch = Watch::default();
    let mut teller = Teller { function: progress, told: (0, 0) };
    let mut broken = None;
    let finished = py.detach(|| {
        std::thread::scope(|scope| {
            let (ends, end) = channel::<()>();
            let (watch, pool) = (&watch, &pool);
            let worker = scope.spawn(move || {
                // Dropped when the work is over, however it ends.
                let _ends = ends;
                pool.install(|| work(watch))
            });
            while end.recv_timeout(INTERVAL) != Err(RecvTimeoutError::Disconnected) {
                if broken.is_none() {
                    broken = teller.tell(watch.now()).err();
                    watch.is_stopped.store(broken.is_some(), Ordering::Relaxed);
                }
            }
            worker.join()
        })
    });
    let result = finished.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    if let Some(error) = broken {
        return Err(error);
    }
    let value = result.map_err(Into::into)?;
    teller.tell(watch.now())?;
    Ok(value)
}
