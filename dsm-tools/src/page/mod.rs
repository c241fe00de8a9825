//! Pages of HTML that show maps: one file, which asks for nothing else.

mod document;
mod embedded;
mod level_columns;
mod limit;

pub(crate) use document::{PageDifference, WorstPlace};
pub(crate) use limit::PageLimit;

use std::io::{self, Write};
use std::path::Path;

use anyhow::Result;
use deepshadow::ShadowMap;
use deepshadow::files::detail::replace_file;

use crate::input::STREAM;
use crate::output::printable;

/// The page of one map, or of two side by side.
pub(crate) struct Page<'a> {
    /// The maps with the names that they are shown by; two have one size.
    pub(crate) maps: Vec<(String, &'a ShadowMap)>,
    /// How far the two are apart.
    pub(crate) difference: Option<PageDifference>,
    pub(crate) limit: PageLimit,
}

impl Page<'_> {
    /// Writes the page, all of it or nothing, or prints it if the name is `-`; says on stderr
    /// what it leaves out of the maps.
    pub(crate) fn write(&self, path: &Path) -> Result<()> {
        let (document, notes) = self.html()?;
        if path.as_os_str() == STREAM {
            io::stdout().write_all(document.as_bytes())?;
        } else {
            replace_file(path, document.as_bytes())?;
        }
        for note in notes {
            // Nobody may be there to read it.
            drop(writeln!(io::stderr(), "note: {}", printable(&note)));
        }
        Ok(())
    }
}
