//! Bakes: settings, occluders and reports.

mod job;
mod occluders;
mod report;
mod settings;

pub(crate) use job::{Job, Seen};
pub use occluders::{AnyHitSource, Occluders, SourceError, ThroughView};
pub use report::BakeReport;
pub use settings::{Bake, Channels};
