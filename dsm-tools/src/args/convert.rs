//! The switches of `convert`.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use dsm_core::Tolerance;
use dsm_io::{Block, WriteOptions};

use super::values::{self, Effort};

/// Makes a map from a deep image, a flat depth image or another map
///
/// Prints what had to be clamped, dropped or assumed.
#[derive(Debug, Args)]
pub(crate) struct ConvertFlags {
    /// A deep .exr, a flat .exr with a channel Z, or a .dsm; its content
    /// tells which
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The map to write, .dsm
    #[arg(value_name = "OUT", value_parser = values::map_file())]
    output: PathBuf,
    /// How far the light may be off at any depth, in [0, 1); 0 copies.
    /// Of a .dsm this is added to what it states already
    #[arg(long, value_name = "E", default_value = "0", allow_negative_numbers = true)]
    #[arg(value_parser = values::tolerance)]
    tolerance: Tolerance,
    /// How tiles are packed
    #[arg(long, value_enum, default_value_t = BlockName::Zstd)]
    block: BlockName,
    /// Width and height of tiles, in pixels
    #[arg(long, value_name = "N", default_value_t = 64)]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    tile: u32,
    /// The part of an .exr to read [default: the first deep one]
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress, and print nothing
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum BlockName {
    None,
    Zstd,
}

/// What `convert` was asked.
#[derive(Debug)]
pub(crate) struct Convert {
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) tolerance: Tolerance,
    pub(crate) write: WriteOptions,
    pub(crate) part: Option<String>,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
}

impl From<ConvertFlags> for Convert {
    fn from(flags: ConvertFlags) -> Self {
        let ConvertFlags { input, output, tolerance, block, tile, part, effort, quiet } = flags;
        let block = match block {
            BlockName::None => Block::Plain,
            BlockName::Zstd => Block::Zstd,
        };
        let write = WriteOptions::default().with_tile_size(tile).with_block(block);
        Self { input, output, tolerance, write, part, effort, quiet }
    }
}
