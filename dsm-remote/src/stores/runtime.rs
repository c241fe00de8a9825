//! The thread that runs requests.

use std::future::Future;
use std::sync::mpsc;
use std::sync::{Mutex, PoisonError};
use std::thread;

use tokio::runtime::{Builder, Handle};

use crate::error::{Error, Result};

/// The thread's handle, and the process that it belongs to.
static RUNNING: Mutex<Option<(u32, Handle)>> = Mutex::new(None);

/// The handle of this process's thread, which is started when it is needed first. A
/// child of a fork has none of its parent's threads, so it gets its own.
fn handle() -> Result<Handle> {
    let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((of, handle)) = &*running
        && *of == process
    {
        return Ok(handle.clone());
    }
    let runtime = Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(Error::io("start the thread of requests"))?;
    let handle = runtime.handle().clone();
    thread::Builder::new()
        .name("dsm-remote".to_owned())
        .spawn(move || runtime.block_on(std::future::pending::<()>()))
        .map_err(Error::io("start the thread of requests"))?;
    *running = Some((process, handle.clone()));
    Ok(handle)
}

/// Waits for a future, which another thread runs: callers may be in a runtime of their
/// own, which must not be entered twice.
pub(super) fn wait<T: Send + 'static>(
    future: impl Future<Output = Result<T>> + Send + 'static,
) -> Result<T> {
    let (sender, receiver) = mpsc::sync_channel(1);
    handle()?.spawn(async move {
        // The receiver waits until it gets this.
        drop(sender.send(future.await));
    });
    receiver.recv().unwrap_or_else(|_| {
        let lost = std::io::Error::other("the thread of requests ended");
        Err(Error::io("wait for an answer")(lost))
    })
}
