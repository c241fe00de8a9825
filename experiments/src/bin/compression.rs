//! Measures compressors side by side:
//! `compression [OUT] [SCENE…]` writes `results/compression.md` in the folder OUT, by
//! default `docs`; maps are baked of SCENEs, too: scene files or models, where they are.

use std::path::PathBuf;

use anyhow::Result;
use dsm_experiments::compression::page::page;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let default = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs"));
    let folder = arguments.next().unwrap_or_else(default);
    let files: Vec<PathBuf> = arguments.collect();
    page(&files)?.write(&folder)
}
