//! Warnings: what was done may not be what was meant.

use std::io::{self, Write};

use anyhow::{Result, bail};
use serde::{Serialize, Serializer};

use super::printable;

/// What a command warns of. Each warning is one line on stderr as soon as it is known, with
/// `--quiet` too, and one of the document's `warnings`. With `--strict` the first one is the
/// command's error, once all else is done.
#[derive(Clone, Debug)]
pub(crate) struct Warnings {
    lines: Vec<String>,
    is_strict: bool,
    is_printed: bool,
}

impl Warnings {
    pub(crate) const fn new(is_strict: bool) -> Self {
        Self { lines: Vec::new(), is_strict, is_printed: !is_strict }
    }

    /// Prints none: a document on stderr has them.
    pub(crate) fn in_document(self, is_there: bool) -> Self {
        Self { is_printed: self.is_printed && !is_there, ..self }
    }

    /// Adds a warning: one sentence without a full stop.
    pub(crate) fn add(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        if self.is_printed {
            let line = format!("{}\n", printable(&format!("warning: {warning}")));
            // Nobody may be there to read it.
            drop(io::stderr().write_all(line.as_bytes()));
        }
        self.lines.push(warning);
    }

    /// Adds several warnings.
    pub(crate) fn extend<S: Into<String>>(&mut self, warnings: impl IntoIterator<Item = S>) {
        warnings.into_iter().for_each(|warning| self.add(warning));
    }

    /// All warnings, in order.
    pub(crate) fn lines(&self) -> &[String] {
        &self.lines
    }

    /// Ends the command.
    ///
    /// # Errors
    ///
    /// The first warning of a strict one.
    pub(crate) fn finish(&self) -> Result<()> {
        if let (Some(first), true) = (self.lines.first(), self.is_strict) {
            bail!("{first} (--strict)");
        }
        Ok(())
    }
}

impl Serialize for Warnings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.lines.serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_warning_is_the_error_of_a_strict_command() {
        for is_strict in [false, true] {
            let mut warnings = Warnings::new(is_strict);
            assert!(warnings.finish().is_ok());
            warnings.extend(["one", "two"]);
            let error = warnings.finish().err().map(|error| error.to_string());
            assert_eq!(error.as_deref(), is_strict.then_some("one (--strict)"));
            assert_eq!(serde_json::to_string(&warnings).unwrap(), "[\"one\",\"two\"]");
        }
    }
}
