//! Scenes as a caller sees them: files in, hits and shadows out.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may stop, and says when it was skipped"
)]

mod animations;
mod builtin_scenes;
mod cases;
mod document;
mod gltf_models;
mod hits;
mod hostile_files;
mod light;
mod media;
mod memory;
mod models;
mod packed_models;
mod real_files;
mod scene_file;
mod shadows;
mod stages;
mod support;
mod volumes;
