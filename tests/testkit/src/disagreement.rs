//! Failures of a check.

use crate::trial::Trial;

/// An answer that depends on what it must not depend on, or that is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{trial}: {reason}")]
pub struct Disagreement {
    /// The trial that disagrees.
    pub trial: Box<Trial>,
    /// The reason.
    pub reason: String,
}

impl Disagreement {
    pub(crate) fn new(trial: &Trial, reason: impl Into<String>) -> Self {
        Self { trial: Box::new(*trial), reason: reason.into() }
    }
}
