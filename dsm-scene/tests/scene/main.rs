//! Scenes as a caller sees them: files in, hits and shadows out.

mod hostile_files;
mod real_files;
mod support;
