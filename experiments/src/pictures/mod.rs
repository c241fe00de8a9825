//! Pictures of Lokovic & Veach 2000 as this project draws them, and how far
//! rendered shadows are from traced ones.

mod comparison;
mod stage;
mod strips;

pub use self::{
    comparison::{Comparison, ComparisonRow},
    stage::{Stage, map_settings},
    strips::{STRIPS, strip},
};
