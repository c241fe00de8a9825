//! A load that is under way, and who waits for it.

use std::any::Any;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use crate::error::Error;

/// A tile of any number of channels.
pub(super) type Value = Arc<dyn Any + Send + Sync>;

/// The outcome of a load.
pub(super) type Loaded = Result<Value, Arc<Error>>;

#[derive(Debug)]
enum State {
    Running,
    Abandoned,
    Finished(Loaded),
}

/// One tile's load. The thread that registered it runs it; all others wait.
#[derive(Debug)]
pub(super) struct Load {
    state: Mutex<State>,
    changed: Condvar,
}

impl Load {
    pub(super) const fn new() -> Self {
        Self { state: Mutex::new(State::Running), changed: Condvar::new() }
    }

    pub(super) fn finish(&self, loaded: Loaded) {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = State::Finished(loaded);
        self.changed.notify_all();
    }

    /// Sends whoever waits to try again, unless the load is finished.
    pub(super) fn abandon(&self) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if matches!(*state, State::Running) {
            *state = State::Abandoned;
            self.changed.notify_all();
        }
    }

    /// Waits for the outcome; `None` if the load was abandoned.
    pub(super) fn wait(&self) -> Option<Loaded> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let running = |state: &mut State| matches!(state, State::Running);
        let state = self.changed.wait_while(state, running);
        match &*state.unwrap_or_else(PoisonError::into_inner) {
            State::Finished(loaded) => Some(loaded.clone()),
            State::Running | State::Abandoned => None,
        }
    }
}
