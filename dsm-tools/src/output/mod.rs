//! What the commands write.

pub(crate) mod light;
pub(crate) mod picture;
pub(crate) mod plot;
pub(crate) mod progress;
pub(crate) mod slice;
pub(crate) mod stated;
pub(crate) mod summary;
pub(crate) mod written;

use std::io::{self, Write};

/// Prints a line for each warning on stderr, with `--quiet` too.
pub(crate) fn print_warnings(warnings: &[String]) {
    let line = |warning: &String| format!("{}\n", printable(&format!("warning: {warning}")));
    let lines: String = warnings.iter().map(line).collect();
    // Nobody may be there to read it.
    drop(io::stderr().write_all(lines.as_bytes()));
}

/// The text without what could break a line or move a terminal's cursor,
/// whatever file names and metadata hold.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}
