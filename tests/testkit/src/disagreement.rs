//! Failures of a check.

use crate::trial::Trial;

/// An answer that depends on what it must not depend on, or that is none.
///
/// ```
/// use dsm_testkit::{Agreement, check_answers};
///
/// // An area has a unit: it is not the same number in a larger world.
/// let area = |trial: &dsm_testkit::Trial| Ok(vec![trial.placement.scale().powi(2)]);
/// let error = check_answers(1.0, &Agreement::default(), area).unwrap_err();
/// assert_ne!(error.trial.placement.scale(), 1.0);
/// ```
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
