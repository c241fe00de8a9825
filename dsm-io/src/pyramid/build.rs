//! Builds the pyramid: visits the tiles, and writes all levels as they come.

use dsm_core::{Progress, Transmittance};
use rayon::prelude::*;
use std::ops::ControlFlow;

use super::coarse::average_children;
use super::fragment::{Averager, Copies};
use super::open_tiles::{FinishedTile, OpenTiles};
use super::plan::{Plan, PyramidOptions};
use super::source::PyramidSource;
use super::tile_levels::TileLevels;
use super::traversal::{Step, Traversal};
use crate::achieved_error::AchievedError;
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::progress::{Watch, tell};
use crate::tile_id::TileId;
use crate::writer::MapWriter;

/// Tiles that are worked on together, for each thread.
const TILES_A_THREAD: usize = 4;

/// Writes all tiles of a map that is begun, of level 0 and of the levels that
/// `options` ask for above it, which are added. `progress` is told how many of
/// how many tiles of level 0 that are not empty are done.
///
/// Every tile's error is against the exact average of the functions that
/// `source` gives, with the errors that those state: measured where pixels are
/// not larger than a tile, above that bounded by what was measured on the way.
/// It is within the level's tolerance ([`Tolerance::of_level`]) unless the
/// source's own errors leave no room.
///
/// Tiles are compressed in parallel, on the current rayon pool. The same input
/// gives the same bytes whatever the number of threads. Memory: a byte a tile,
/// a few tiles a thread, one tile a level and one pixel's functions a level. A
/// tile that is clear costs nothing, and an area of such tiles neither.
///
/// [`Tolerance::of_level`]: dsm_core::Tolerance::of_level
///
/// # Errors
///
/// [`Error::Channels`] if `T` has another number of channels than the map;
/// [`Error::Setting`] if the options make no sense, or the writer has more than
/// level 0 already; else what keeps tiles from being read or written.
pub fn build_pyramid<T: Transmittance, S: PyramidSource<T>>(
    source: &S,
    writer: &mut MapWriter,
    options: &PyramidOptions,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<()> {
    let (channels, asked) = (writer.metadata().channels, T::CHANNELS as u8);
    if channels != asked {
        return Err(Error::Channels { channels, asked });
    }
    let &[level] = writer.levels() else {
        return Err(Error::setting("a pyramid is built on a map that has level 0 only"));
    };
    let info = &writer.metadata().info;
    let plan = Plan::new([level.width, level.height], level.tile_width, info, options)?;
    for number in 1..=plan.top() {
        let [width, height] = plan.pyramid.size(number);
        let tolerance = plan.tolerance(number).epsilon();
        writer
            .add_level(Level { number, ..Level::new(width, height, plan.tile_size, tolerance) })?;
    }
    let traversal = Traversal::new(level.tiles(), plan.top(), |x, y| !source.is_clear(x, y));
    let pending = (0..=plan.top()).map(|_| Vec::new()).collect();
    let open = OpenTiles::new(plan.pyramid.level_count());
    let averager = Averager::default();
    let depth_error = source.depth_error();
    Builder { plan, source, writer, open, pending, averager, depth_error }
        .run(traversal, &mut progress)
}

/// A pyramid while it is built.
struct Builder<'a, T: Transmittance, S> {
    plan: Plan,
    source: &'a S,
    writer: &'a mut MapWriter,
    open: OpenTiles<T>,
    /// Copies of the nodes of each height whose parents have not come.
    pending: Vec<Vec<Copies<T>>>,
    averager: Averager<T>,
    /// What coarse levels inherit of level 0's.
    depth_error: f32,
}

/// A tile to write.
enum Output<T> {
    Encoded(TileId, EncodedTile, AchievedError),
    Finished(FinishedTile<T>),
}

impl<T: Transmittance, S: PyramidSource<T>> Builder<'_, T, S> {
    fn run(mut self, mut traversal: Traversal, progress: Watch<'_>) -> Result<()> {
        let count = traversal.tile_count();
        let window = TILES_A_THREAD * rayon::current_num_threads().max(1);
        let mut done = 0;
        loop {
            let (mut steps, mut tiles) = (Vec::new(), Vec::new());
            while tiles.len() < window
                && let Some(step) = traversal.next()
            {
                steps.push(step);
                if let Step::Tile { x, y } = step {
                    tiles.push(TileId::new(0, x, y));
                }
            }
            if steps.is_empty() {
                return Ok(());
            }
            done += tiles.len() as u64;
            // Not of `self`: a writer is one thread's.
            let (plan, source, level, encoding) =
                (&self.plan, self.source, self.writer.levels()[0], self.writer.encoding());
            let work = |id: TileId| {
                let rect = level.tile_rect(id.x, id.y).ok_or(Error::NoSuchTile(id))?;
                TileLevels::new(plan, id, rect, source.tile(id)?, encoding)
            };
            let worked = tiles.into_par_iter().map(work).collect::<Result<Vec<_>>>()?;
            self.take(&steps, worked)?;
            tell(progress, done, count)?;
        }
    }

    /// Takes the steps that were worked for, in their order.
    fn take(&mut self, steps: &[Step], worked: Vec<TileLevels<T>>) -> Result<()> {
        let mut worked = worked.into_iter();
        let mut outputs = Vec::new();
        for &step in steps {
            match step {
                Step::Tile { x, y } => {
                    let Some(tile) = worked.next() else { continue };
                    let id = TileId::new(0, x, y);
                    let output = |(tile, error)| Output::Encoded(id, tile, error);
                    outputs.extend(tile.level_zero.map(output));
                    for (level, fragment) in (1..).zip(tile.fragments) {
                        self.open.add(level, fragment);
                    }
                    self.pending[0].extend(tile.copies);
                }
                Step::Close { height, x, y } => {
                    self.average(height, [x, y])?;
                    let finished = self.open.close(TileId::new(height, x, y));
                    outputs.extend(finished.map(Output::Finished));
                }
            }
        }
        self.write(outputs)
    }

    /// Averages what the children of a node left into pixels of the node.
    fn average(&mut self, height: u32, node: [u32; 2]) -> Result<()> {
        let Some(children) = self.pending.get_mut(height as usize - 1).map(std::mem::take) else {
            return Ok(());
        };
        if children.is_empty() {
            return Ok(());
        }
        let (fragment, copies) =
            average_children(&self.plan, &mut self.averager, height, node, &children)?;
        self.open.add(self.plan.cell_level + height, fragment);
        self.pending[height as usize].extend(copies);
        Ok(())
    }

    /// Encodes in parallel what is not encoded, and writes all in order.
    fn write(&mut self, outputs: Vec<Output<T>>) -> Result<()> {
        let (levels, encoding) = (self.writer.levels(), self.writer.encoding());
        let encoded: Vec<_> = outputs
            .into_par_iter()
            .map(|output| match output {
                Output::Encoded(id, tile, error) => Ok((id, tile, error)),
                Output::Finished(tile) => {
                    let level = levels.get(tile.id.level as usize);
                    let level = level.ok_or(Error::NoSuchLevel(tile.id.level))?;
                    tile.encode(level, encoding).map(|(encoded, error)| (tile.id, encoded, error))
                }
            })
            .collect::<Result<_>>()?;
        for (id, tile, error) in encoded {
            let tile = if id.level > 0 { tile.with_depth_error(self.depth_error) } else { tile };
            self.writer.write_encoded(id, &tile, error)?;
        }
        Ok(())
    }
}
