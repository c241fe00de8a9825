//! The threads that calls work with.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Failure, Result};

/// The most threads that a call may ask for.
const MOST: usize = 1024;

/// The shared pool, and the process that its threads live in: a process made by `fork`
/// has none of them.
static SHARED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// A pool of this many threads, or the shared one with a thread a core.
pub(crate) fn pool(threads: Option<usize>) -> Result<Arc<ThreadPool>> {
    if let Some(threads) = threads {
        if !(1..=MOST).contains(&threads) {
            return Err(Failure::setting(format!("threads must lie between 1 and {MOST}")));
        }
        return build(threads);
    }
    let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, pool)) = &*shared
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let pool = build(0)?;
    // A pool of the parent process waits for threads that are not there: it is left alone.
    std::mem::forget(shared.replace((process, Arc::clone(&pool))));
    Ok(pool)
}

fn build(threads: usize) -> Result<Arc<ThreadPool>> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(Arc::new).map_err(|error| Failure::setting(format!("cannot start threads: {error}")))
}
