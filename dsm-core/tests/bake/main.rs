//! From hit sources to maps, against a naive oracle and closed forms.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod closed_forms;
mod compression;
mod oracle;
mod pixels;
mod quantized;
mod sources;
mod tiles;
