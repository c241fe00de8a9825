//! Scenes baked into files, and read again: against traced rays, against closed
//! forms, in parts, with all mip levels, and broken off.

#![expect(clippy::unwrap_used, reason = "a test may stop where a scene or a file is refused")]
#![expect(clippy::print_stdout, reason = "what was skipped, and what was measured")]

mod closed_forms;
mod interruption;
#[path = "../pyramid/naive.rs"]
mod naive;
mod parts;
mod pyramid;
mod quantized;
mod rays;
mod scenes;
mod stated;
mod support;
