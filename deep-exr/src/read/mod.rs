//! From the bytes of a file to columns of samples.

mod choice;
mod chunk;
mod decoder;
mod deep;
mod flat;
pub(crate) mod header;
mod part;
mod plan;
mod readable_part;
pub(crate) mod reader;
mod scan;
mod source;
mod values;
