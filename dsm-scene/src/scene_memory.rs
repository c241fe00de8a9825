//! The memory that a scene takes.

use std::fmt;

use crate::error::{Error, Result};
use crate::scene::{Object, Shape};

/// Bytes of what is built to bake or trace a triangle or a segment of a strand, measured:
/// 205 for the rasteriser, once for each object, and 310 for the tracer, once for each
/// shape.
const BYTES_PER_PRIMITIVE: u64 = 320;

/// The memory that a scene takes, by what takes it: models and images by the name of
/// their file, once each, and what has to be built to bake or trace them.
///
/// ```
/// let scene = dsm_scene::builtin_scene("hairball")?;
/// let memory = scene.memory();
/// assert!(memory.total() > 1 << 20);
/// println!("{memory}");
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneMemory {
    /// Names and bytes.
    items: Vec<(String, u64)>,
}

impl SceneMemory {
    /// All bytes together.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.items.iter().fold(0, |sum, (_, bytes)| sum.saturating_add(*bytes))
    }

    /// What takes memory and how many bytes, the largest first.
    #[must_use]
    pub fn largest(&self) -> Vec<(&str, u64)> {
        let mut items: Vec<_> =
            self.items.iter().map(|(name, bytes)| (name.as_str(), *bytes)).collect();
        items.sort_by_key(|&(_, bytes)| std::cmp::Reverse(bytes));
        items
    }

    /// Refuses `bytes` more than what is there, for `name`, if all are more than `limit`.
    ///
    /// # Errors
    ///
    /// [`Error::Memory`].
    pub(crate) fn check(&self, name: &str, bytes: u64, limit: u64) -> Result<()> {
        let needed = self.total().saturating_add(bytes);
        if needed <= limit {
            return Ok(());
        }
        let mut with = self.clone();
        with.add(name, bytes);
        Err(Error::Memory { needed, limit, largest: with.to_string() })
    }

    pub(crate) fn add(&mut self, name: &str, bytes: u64) {
        match self.items.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum = sum.saturating_add(bytes),
            None => self.items.push((name.to_owned(), bytes)),
        }
    }

    /// Adds what is built of these objects.
    pub(crate) fn add_structures(&mut self, objects: &[Object]) {
        let primitives = objects.iter().map(|object| match &*object.shape {
            Shape::Mesh(mesh) => mesh.triangles().len() as u64,
            Shape::Curves(curves) => curves.segments().len() as u64,
            Shape::Volume(_) => 0,
        });
        let count: u64 = primitives.sum();
        if count > 0 {
            self.add("structures to trace", count.saturating_mul(BYTES_PER_PRIMITIVE));
        }
    }
}

/// The largest three, in MiB.
impl fmt::Display for SceneMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (name, bytes)) in self.largest().into_iter().take(3).enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            write!(f, "{comma}{name} {}", Mebibytes(bytes))?;
        }
        match self.items.len() {
            0..=3 => Ok(()),
            more => write!(f, ", and {} more", more - 3),
        }
    }
}

/// Bytes as people read them.
pub(crate) struct Mebibytes(pub(crate) u64);

impl fmt::Display for Mebibytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} MiB", self.0.div_ceil(1 << 20))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_large_is_named_first() {
        let mut memory = SceneMemory::default();
        for (name, mebibytes) in [("a.obj", 1), ("b.png", 60), ("c.ply", 7), ("b.png", 4)] {
            memory.add(name, mebibytes << 20);
        }
        assert_eq!(memory.total(), 72 << 20);
        assert_eq!(memory.to_string(), "b.png 64 MiB, c.ply 7 MiB, a.obj 1 MiB");
        assert!(memory.check("d.vdb", 8 << 20, 80 << 20).is_ok());
        let refused = memory.check("d.vdb", (8 << 20) + 1, 80 << 20).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "the scene takes 81 MiB of memory, more than the 80 MiB it may take: b.png 64 MiB, \
             d.vdb 9 MiB, c.ply 7 MiB, and 1 more"
        );
        assert!(memory.check("e", u64::MAX, u64::MAX - 1).is_err(), "sums do not wrap around");
    }
}
