//! The switches of `diff`.

use std::path::PathBuf;

use clap::Args;

use super::values::{self, Effort};
use crate::page::PageLimit;

const EXAMPLES: &str = "\
Examples:
  dsm-tools diff old.dsm new.dsm --json
  dsm-tools diff old.dsm new.dsm --html changes.html";

/// Tells how far the visibility functions of two maps are apart
///
/// Prints the largest difference, at any depth and on both sides of steps, and
/// the mean one, over all pixels of all levels that both have. Maps that
/// differ are no failure.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct DiffFlags {
    /// A deep shadow map (.dsm), a deep .exr or a flat depth .exr
    a: PathBuf,
    /// Another one of the same size
    b: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Write a page of HTML that shows both maps at any depth, side by side, with their
    /// difference, and the curves of any pixel; it is one file and asks for no other
    #[arg(long, value_name = "OUT", value_parser = values::html_file())]
    html: Option<PathBuf>,
    /// The most bytes of that page; of maps that are too large it shows the levels that
    /// fit, or the middle, and says so
    #[arg(long, value_name = "SIZE", requires = "html", default_value_t = PageLimit::DEFAULT)]
    max_size: PageLimit,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// A checked `diff`.
#[derive(Debug)]
pub(crate) struct Diff {
    pub(crate) files: [PathBuf; 2],
    pub(crate) json: bool,
    pub(crate) html: Option<PathBuf>,
    pub(crate) max_size: PageLimit,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
}

impl From<DiffFlags> for Diff {
    fn from(flags: DiffFlags) -> Self {
        let DiffFlags { a, b, json, html, max_size, effort, quiet } = flags;
        Self { files: [a, b], json, html, max_size, effort, quiet }
    }
}
