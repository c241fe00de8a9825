//! From a file that has functions to a `.dsm` file, a row of tiles at a time,
//! and the check that one file keeps its bound against another.

mod compare;
mod deep_samples;
mod report;
mod rows;
mod source;
mod tiles;

pub use compare::{MapDifference, WorstPixel, check_bound, compare};
pub use report::ImportReport;
pub use source::MapSource;
pub use tiles::{ConvertOptions, convert};
