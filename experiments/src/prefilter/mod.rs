//! Prefiltered maps on the scenes that other programs were measured on.

pub mod page;
pub mod peer;
pub mod run;
