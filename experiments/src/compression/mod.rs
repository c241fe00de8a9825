//! Compressors side by side: vertices, bytes, errors and time.

mod functions;
mod maps;
pub mod page;
