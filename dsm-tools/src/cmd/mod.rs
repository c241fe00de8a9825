//! The commands, each from a checked request.

pub(crate) mod bake;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod diff;
pub(crate) mod inspect;
pub(crate) mod lookup;
pub(crate) mod man;
pub(crate) mod merge;
pub(crate) mod mip;
pub(crate) mod plan;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod step;
pub(crate) mod verify;
