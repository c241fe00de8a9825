//! Bakes: settings, occluders and reports.

mod job;
pub(crate) mod occluders;
pub(crate) mod report;
pub(crate) mod settings;

pub(crate) use job::{Job, Seen};
