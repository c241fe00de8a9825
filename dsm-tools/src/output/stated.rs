//! The errors that a map states, for documents and for people.

use deepshadow::detail::StatedError;
use serde::Serialize;

/// The error of a level: beside δ, δ itself, and both as one difference.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct StatedReport {
    max_error: f32,
    mean_error: f32,
    /// δ, in scene units.
    pub(crate) depth_error: f32,
    /// What a function is off by at any one depth.
    error_at_depth: f32,
}

impl From<StatedError> for StatedReport {
    fn from(stated: StatedError) -> Self {
        Self {
            max_error: stated.max,
            mean_error: stated.mean,
            depth_error: stated.depth,
            error_at_depth: stated.at_depth,
        }
    }
}

impl StatedReport {
    /// The numbers for a table, in columns of 11, 12, 13 and 12 letters.
    pub(crate) fn columns(&self) -> String {
        let Self { max_error, mean_error, depth_error, error_at_depth } = self;
        format!("{max_error:>11.2e}{mean_error:>12.2e}{depth_error:>13.2e}{error_at_depth:>12.2e}")
    }

    /// The sentence about depths that were moved; none where they were not.
    pub(crate) fn about_depths(&self) -> Option<String> {
        let Self { max_error, depth_error, error_at_depth, .. } = self;
        (*depth_error > 0.0).then(|| {
            format!(
                "depths up to {depth_error:.3e} farther from the light: off by {max_error:.3e} \
                 beside that, by {error_at_depth:.3e} at one depth"
            )
        })
    }
}
