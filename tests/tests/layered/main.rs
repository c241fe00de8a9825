//! Layered maps in files.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod contents;
mod damage;
mod examples;
mod golden;
mod mutation;
mod round_trip;
