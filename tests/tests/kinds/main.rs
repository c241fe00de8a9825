//! Maps of any kind, from any source of bytes.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod ranges;
mod toy;
