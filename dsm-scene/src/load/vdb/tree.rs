//! Trees of values: nodes of 32³ nodes of 16³ leaves of 8³ voxels.

use glam::IVec3;

use super::bytes::Bytes;
use super::values::{Mask, Storage, ValueType};
use crate::error::Result;
use crate::volume_builder::VolumeBuilder;

/// Voxels farther out would not be told apart in `f32`.
const MAX_DISTANCE: i32 = 1 << 24;
const LEAF_LOG2: u32 = 3;
const LEAF_VOXELS: usize = 1 << (3 * LEAF_LOG2);
/// Inner nodes: children along a side, and the voxels along a child's, as powers of 2.
const UPPER: Inner = Inner { side_log2: 5, child_log2: 7 };
const LOWER: Inner = Inner { side_log2: 4, child_log2: 3 };

#[derive(Clone, Copy)]
struct Inner {
    side_log2: u32,
    child_log2: u32,
}

impl Inner {
    const fn places(self) -> usize {
        1 << (3 * self.side_log2)
    }

    /// The first voxel of a place, z before y before x.
    fn voxel(self, origin: IVec3, place: usize) -> IVec3 {
        origin + (coordinates(place, self.side_log2) << self.child_log2)
    }
}

fn coordinates(place: usize, side_log2: u32) -> IVec3 {
    let (place, mask) = (place as i32, (1 << side_log2) - 1);
    IVec3::new(place >> (2 * side_log2), place >> side_log2 & mask, place & mask)
}

/// A tree as it is walked through.
pub(super) struct Tree<'a> {
    storage: Storage,
    volume: &'a mut VolumeBuilder,
    /// The leaves, whose values come last.
    leaves: Vec<IVec3>,
    values: Vec<f32>,
}

/// Reads the tree of a grid, and the values of its leaves, into `volume`.
///
/// What isn't active counts by what it holds, as it does where a grid is sampled; the
/// background counts within the active voxels' box.
pub(super) fn read_tree(
    file: &mut Bytes<'_>,
    leaves: Bytes<'_>,
    compression: u32,
    value_type: ValueType,
    is_half: bool,
    volume: &mut VolumeBuilder,
) -> Result<()> {
    if file.u32()? != 1 {
        return Err(file.refuse("unsupported: tree of several buffers"));
    }
    let background = value_type.value(file.take(value_type.size())?);
    volume.set_background(background)?;
    let storage = Storage { value_type, compression, is_half, background };
    let (tiles, roots) = (file.u32()?, file.u32()?);
    for _ in 0..tiles {
        file.take(12)?;
        let value = value_type.value(file.take(value_type.size())?);
        if file.u8()? != 0 || (value != 0.0 && value != background) {
            return Err(file.refuse("unsupported: tiles of 4096 voxels per side"));
        }
    }
    let mut tree = Tree { storage, volume, leaves: Vec::new(), values: Vec::new() };
    for _ in 0..roots {
        tree.read_upper(file)?;
    }
    tree.read_leaves(leaves)
}

impl Tree<'_> {
    fn read_upper(&mut self, file: &mut Bytes<'_>) -> Result<()> {
        let mut origin = [0; 3];
        for at in &mut origin {
            let start = *file;
            *at = file.i32()?;
            if !(-MAX_DISTANCE..=MAX_DISTANCE).contains(at) {
                return Err(start.refuse("a node lies beyond ±2^24 voxels"));
            }
        }
        for lower in self.read_inner(file, UPPER, IVec3::from(origin))? {
            let leaves = self.read_inner(file, LOWER, lower)?;
            file.take(leaves.len() * LEAF_VOXELS / 8)?;
            self.leaves.extend(leaves);
        }
        Ok(())
    }

    /// Reads the values of an inner node; where its children are.
    fn read_inner(
        &mut self,
        file: &mut Bytes<'_>,
        node: Inner,
        origin: IVec3,
    ) -> Result<Vec<IVec3>> {
        let children = Mask::read(file, node.places())?;
        let active = Mask::read(file, node.places())?;
        self.storage.read(file, node.places(), active, &mut self.values)?;
        let mut found = Vec::with_capacity(children.count());
        for (place, &value) in self.values.iter().enumerate() {
            let voxel = node.voxel(origin, place);
            if children.has(place) {
                found.push(voxel);
            } else if active.has(place) || (value != 0.0 && value != self.storage.background) {
                self.volume.fill(voxel, 1 << node.child_log2, value)?;
            }
        }
        Ok(found)
    }

    fn read_leaves(&mut self, mut file: Bytes<'_>) -> Result<()> {
        for origin in std::mem::take(&mut self.leaves) {
            let active = Mask::read(&mut file, LEAF_VOXELS)?;
            match self.storage.value_type {
                ValueType::Bool => {
                    file.take(12)?;
                    let values = Mask::read(&mut file, LEAF_VOXELS)?;
                    self.values.clear();
                    self.values.extend((0..LEAF_VOXELS).map(|at| f32::from(values.has(at))));
                }
                ValueType::Mask => {
                    file.take(12)?;
                    self.values.clear();
                    self.values.extend((0..LEAF_VOXELS).map(|at| f32::from(active.has(at))));
                }
                _ => self.storage.read(&mut file, LEAF_VOXELS, active, &mut self.values)?,
            }
            for (place, &value) in self.values.iter().enumerate() {
                let voxel = origin + coordinates(place, LEAF_LOG2);
                if active.has(place) || (value != 0.0 && value != self.storage.background) {
                    self.volume.set(voxel, value)?;
                } else if value != 0.0 {
                    self.volume.set_outside(voxel, value)?;
                }
            }
        }
        Ok(())
    }
}
