//! Pictures of Lokovic & Veach 2000 as this project draws them, and how far
//! rendered shadows are from traced ones.

mod comparison;
mod stage;
mod strips;

pub use comparison::{Comparison, ComparisonRow};
pub use stage::{Stage, map_settings};
pub use strips::{STRIPS, strip};
