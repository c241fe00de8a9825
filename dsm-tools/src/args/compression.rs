//! The switches of compression.

use clap::{Args, ValueEnum};
use deepshadow::visibility::{Compression, CompressionMethod, Side};

/// How visibility functions are compressed.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct CompressionFlags {
    /// Algorithm of the compression, of kind deep: min-link, the fewest vertices within the
    /// tolerance, for the smallest files; greedy in one pass, the fastest [default: min-link]
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Where a map may be off: lighter, nowhere darker than what it is made of; darker,
    /// nowhere lighter [default: both]
    #[arg(long, value_enum)]
    side: Option<SideName>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodName {
    Greedy,
    MinLink,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum SideName {
    Both,
    Lighter,
    Darker,
}

impl CompressionFlags {
    /// The first switch that is given.
    pub(super) fn given(&self) -> Option<&'static str> {
        let method = self.method.map(|_| "--method");
        method.or(self.side.map(|_| "--side"))
    }

    /// What was asked for, if anything was.
    pub(super) fn compression(&self) -> Result<Option<Compression>, String> {
        if self.given().is_none() {
            return Ok(None);
        }
        let side = match self.side {
            Some(SideName::Lighter) => Side::Lighter,
            Some(SideName::Darker) => Side::Darker,
            Some(SideName::Both) | None => Side::Both,
        };
        let method = match self.method {
            Some(MethodName::Greedy) => CompressionMethod::Greedy,
            Some(MethodName::MinLink) => CompressionMethod::MinLink,
            None => CompressionMethod::default(),
        };
        let compression = Compression::new(method).with_side(side);
        if compression.check().is_err() {
            return Err("--side lighter and darker need --method min-link".to_owned());
        }
        Ok(Some(compression))
    }
}
