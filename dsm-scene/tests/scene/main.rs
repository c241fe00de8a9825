//! Scenes as a caller sees them: files in, hits and shadows out.

mod builtin_scenes;
mod hits;
mod hostile_files;
mod media;
mod real_files;
mod scene_file;
mod shadows;
mod support;
