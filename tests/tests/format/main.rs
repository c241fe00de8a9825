//! The `.dsm` format: what is written is read, whatever is damaged is found,
//! and the document is true.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may stop where a file is refused")]

mod allocation;
mod atomicity;
mod damage;
mod examples;
mod fuzz;
mod golden;
mod golden_deep;
mod metadata;
mod pixels;
mod round_trip;
mod spec_examples;
mod writer;
