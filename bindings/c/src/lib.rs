//! `libdeepshadow`: the front door in C.
//!
//! What C calls stands in [`border`], and only there is code unsafe: pointers become
//! references and slices, panics and errors become status codes. The rest is safe.

mod border;
mod failure;
mod hit_source;
mod settings;
