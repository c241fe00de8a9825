//! What a check found.

use crate::trial::Trial;

/// An answer that depends on what it must not depend on, or that is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{trial}: {reason}")]
pub struct Disagreement {
    /// Where.
    pub trial: Box<Trial>,
    /// What is wrong.
    pub reason: String,
}

impl Disagreement {
    pub(crate) fn new(trial: &Trial, reason: impl Into<String>) -> Self {
        Self { trial: Box::new(*trial), reason: reason.into() }
    }
}
