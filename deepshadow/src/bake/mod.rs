//! Bakes: settings, occluders and reports.

mod job;
pub(crate) mod occluders;
mod parts;
pub(crate) mod report;
pub(crate) mod settings;

pub(crate) use job::{Job, Seen};
