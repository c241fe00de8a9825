//! A run of bytes that one thread fetches and others may wait for.

use std::ops::Range;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use crate::error::{Error, Result};

type Outcome = Result<Vec<u8>, Arc<Error>>;

/// Bytes that were asked for together.
#[derive(Debug)]
pub(super) struct Block {
    range: Range<u64>,
    outcome: Mutex<Option<Arc<Outcome>>>,
    came: Condvar,
}

impl Block {
    pub(super) const fn new(range: Range<u64>) -> Self {
        Self { range, outcome: Mutex::new(None), came: Condvar::new() }
    }

    pub(super) const fn range(&self) -> &Range<u64> {
        &self.range
    }

    /// Fetches the block; whoever waits for it is told, whatever happens.
    pub(super) fn fill(&self, fetch: impl FnOnce(Range<u64>) -> Result<Vec<u8>>) {
        let filling = Filling(self);
        filling.end(fetch(self.range.clone()).map_err(Arc::new));
    }

    /// Adds the part of `range` that the block has to `bytes`, once it came.
    pub(super) fn copy(&self, range: &Range<u64>, bytes: &mut Vec<u8>) -> Result<()> {
        let outcome = self.outcome.lock().unwrap_or_else(PoisonError::into_inner);
        let outcome = self.came.wait_while(outcome, |outcome| outcome.is_none());
        let outcome = outcome.unwrap_or_else(PoisonError::into_inner).clone();
        match outcome.as_deref() {
            Some(Ok(held)) => {
                let start = range.start.max(self.range.start) - self.range.start;
                let end = range.end.min(self.range.end) - self.range.start;
                // Both lie in the block, which is in memory.
                bytes.extend(held.get(start as usize..end as usize).unwrap_or_default());
                Ok(())
            }
            Some(Err(error)) => Err(Error::Shared(Arc::clone(error))),
            None => Err(Error::Changed),
        }
    }
}

/// Ends the wait for a block, even if its fetch panics.
struct Filling<'a>(&'a Block);

impl Filling<'_> {
    fn end(self, outcome: Outcome) {
        *self.0.outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(outcome));
    }
}

impl Drop for Filling<'_> {
    fn drop(&mut self) {
        let mut outcome = self.0.outcome.lock().unwrap_or_else(PoisonError::into_inner);
        let lost = || std::io::Error::other("another thread gave up");
        outcome.get_or_insert_with(|| Arc::new(Err(Arc::new(Error::io("read")(lost())))));
        self.0.came.notify_all();
    }
}
