//! What is written of a figure.

use std::path::Path;

use anyhow::{Context, Result};

/// A figure's page and its plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The files' name, without an ending.
    pub name: &'static str,
    /// The page, in Markdown; it shows the plot.
    pub page: String,
    /// The plot, in SVG.
    pub plot: String,
}

impl Report {
    /// Writes both into `folder`.
    ///
    /// # Errors
    ///
    /// If they can't be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder)?;
        for (ending, text) in [("md", &self.page), ("svg", &self.plot)] {
            let path = folder.join(format!("{}.{ending}", self.name));
            std::fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
        }
        Ok(())
    }
}

/// A table of Markdown.
pub(crate) fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut text = line(&header.iter().map(|&cell| cell.to_owned()).collect::<Vec<_>>());
    text += &line(&vec!["---:".to_owned(); header.len()]);
    rows.into_iter().for_each(|row| text += &line(&row));
    text
}

/// Bytes as the paper counts them: in units of 2²⁰.
pub(super) fn megabytes(bytes: f64) -> String {
    format!("{:.2}", bytes / 1_048_576.0)
}
