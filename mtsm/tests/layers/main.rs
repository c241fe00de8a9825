//! Layered maps against naive sums of what their rays meet.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod depths;
mod oracle;
mod runs;
mod soft_pcf;
mod tracing;
mod views;
