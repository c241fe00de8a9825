//! From a file that has functions to a `.dsm` file, a row of tiles at a time;
//! from a `.dsm` file to a deep OpenEXR; and the check that one file keeps its
//! bound against another.

mod compare;
mod deep_samples;
mod exponential;
mod export;
mod function_samples;
mod image_options;
mod report;
mod rows;
mod source;
mod tiles;

pub use compare::{MapDifference, check_bound, compare, compare_levels};
pub use export::{ExportOptions, ExportReport, export_deep_exr};
pub use report::ImportReport;
pub use source::MapSource;
pub use tiles::{ConvertOptions, convert};
