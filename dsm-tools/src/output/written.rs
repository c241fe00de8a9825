//! What a command wrote.

use std::io::{self, Write};
use std::path::Path;

use anyhow::Result;
use serde::Serialize;

use super::printable;

/// A file that a command wrote: lines for people, or one JSON document.
#[derive(Serialize)]
pub(crate) struct Written<'a, D> {
    pub(crate) output: &'a Path,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) channels: u8,
    /// Length of the file.
    pub(crate) bytes: u64,
    /// What the command alone has to say, in the document.
    #[serde(flatten)]
    pub(crate) details: D,
    /// What was clamped, dropped, assumed or lost.
    pub(crate) notes: Vec<String>,
    /// What stands between size and bytes, for people.
    #[serde(skip)]
    pub(crate) summary: String,
    /// More for people, before the notes.
    #[serde(skip)]
    pub(crate) lines: Vec<String>,
}

impl<D: Serialize> Written<'_, D> {
    /// Prints the document if `json`, else lines unless `quiet`.
    pub(crate) fn print(&self, json: bool, quiet: bool) -> Result<()> {
        let text = match (json, quiet) {
            (true, _) => serde_json::to_string(self)? + "\n",
            (false, false) => self.text(),
            (false, true) => return Ok(()),
        };
        Ok(io::stdout().write_all(text.as_bytes())?)
    }

    fn text(&self) -> String {
        let Self { width, height, summary, bytes, .. } = self;
        let name = printable(&self.output.to_string_lossy());
        let mut text = format!("{name}: {width} × {height} pixels, {summary}, {bytes} bytes\n");
        for line in self.lines.iter().chain(&self.notes) {
            text += &format!("  {line}\n");
        }
        text
    }
}

/// The number of channels in words.
pub(crate) const fn channels_name(channels: u8) -> &'static str {
    if channels == 1 { "mono" } else { "RGB" }
}
