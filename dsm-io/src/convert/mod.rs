//! From a file that has functions to a `.dsm` file, a row of tiles at a time;
//! from a `.dsm` file to a deep OpenEXR; and the check that one file keeps its
//! bound against another.

pub(crate) mod camera_reading;
pub(crate) mod compare;
mod deep_samples;
mod exponential;
pub(crate) mod export;
pub(crate) mod export_options;
mod function_samples;
mod image_options;
pub(crate) mod report;
mod rows;
pub(crate) mod source;
pub(crate) mod target_size;
pub(crate) mod tiles;
