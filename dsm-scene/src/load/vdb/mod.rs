//! OpenVDB volumes.
//!
//! No length in a file is believed: blocks are unpacked into what the nodes' masks
//! say, and masks lie in the file.

mod blosc;
mod bytes;
pub(crate) mod choice;
mod header;
#[cfg(test)]
mod tests;
mod transform;
mod tree;
mod values;

use std::path::Path;

use self::bytes::Bytes;
use self::choice::{GridChoice, choose};
use self::header::{GridHeader, grids, read_metadata};
use self::transform::read_transform;
use self::tree::read_tree;
use self::values::{ValueType, read_compression};
use super::read_file;
use crate::error::Result;
use crate::volume::Volume;
use crate::volume_builder::VolumeBuilder;

pub(super) fn load(path: &Path, choice: Option<&GridChoice>) -> Result<Volume> {
    parse(&read_file(path)?, choice)
}

/// Reads the medium that is in the bytes of an OpenVDB file, as
/// [`load_volume`](super::load_volume).
///
/// # Errors
///
/// What is wrong with the file.
pub fn volume_from_bytes(bytes: &[u8], choice: Option<&GridChoice>) -> Result<Volume> {
    parse(bytes, choice)
}

fn parse(bytes: &[u8], choice: Option<&GridChoice>) -> Result<Volume> {
    let grids = grids(bytes)?;
    let chosen = choose(&grids, choice)?;
    let own = Grid::read(bytes, chosen)?;
    if own.class.as_deref() == Some("level set") {
        return Err(chosen.refuse("a level set is a surface, not a density"));
    }
    // An instance has a transform of its own and another grid's tree.
    let (header, tree) = if chosen.parent.is_empty() {
        (chosen, own)
    } else {
        let Some(parent) =
            grids.iter().find(|grid| grid.is_called(&chosen.parent) && grid.parent.is_empty())
        else {
            return Err(chosen.refuse("the grid that it is an instance of is not in the file"));
        };
        let tree = Grid { transform: own.transform, ..Grid::read(bytes, parent)? };
        (parent, tree)
    };
    let Some(value_type) = ValueType::of_tree(&header.tree) else {
        let reason = format!("unsupported grid {}: only scalars in a tree of 5, 4, 3", header.tree);
        return Err(chosen.refuse(reason));
    };
    let mut builder = VolumeBuilder::default();
    let mut topology = tree.topology;
    let leaves = Bytes::new(bytes).at(header.leaves)?;
    read_tree(&mut topology, leaves, tree.compression, value_type, tree.is_half, &mut builder)?;
    builder.build_placed(tree.transform)
}

/// What stands before a grid's tree.
struct Grid<'a> {
    compression: u32,
    is_half: bool,
    class: Option<String>,
    transform: glam::DAffine3,
    topology: Bytes<'a>,
}

impl<'a> Grid<'a> {
    fn read(bytes: &'a [u8], header: &GridHeader) -> Result<Self> {
        let mut file = Bytes::new(bytes).at(header.contents)?;
        let compression = read_compression(&mut file)?;
        let (mut is_half, mut class) = (header.is_half, None);
        read_metadata(&mut file, |name, value| match name {
            "is_saved_as_half_float" => is_half |= value.iter().any(|&byte| byte != 0),
            "class" => class = Some(String::from_utf8_lossy(value).into_owned()),
            _ => {}
        })?;
        let transform = read_transform(&mut file)?;
        Ok(Self { compression, is_half, class, transform, topology: file })
    }
}
