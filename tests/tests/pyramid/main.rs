//! Mip pyramids: every level of a file is what plain averaging of its level 0
//! gives, within what the file states.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod bound;
mod files;
mod maps;
mod naive;
mod uncompressed;
