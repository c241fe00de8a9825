//! What is written of an experiment.

use std::path::Path;

use anyhow::{Context, Result};

/// A page and the pictures that it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// The page's name in `results`, without an ending.
    pub name: &'static str,
    /// The page, in Markdown.
    pub text: String,
    /// Pictures: their paths from the folder of all documents, and their bytes.
    pub pictures: Vec<(String, Vec<u8>)>,
}

impl Page {
    /// Writes all into the folder of documents, whose parts must be there.
    ///
    /// # Errors
    ///
    /// If they can't be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let page = (format!("results/{}.md", self.name), self.text.clone().into_bytes());
        for (path, bytes) in std::iter::once(&page).chain(&self.pictures) {
            let path = folder.join(path);
            std::fs::write(&path, bytes).with_context(|| format!("writing {}", path.display()))?;
        }
        Ok(())
    }
}
