//! The pyramid of a map that is stored.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{Progress, Rgb, Transmittance};

use super::build::build_pyramid;
use super::plan::PyramidOptions;
use super::source::{PyramidSource, SourceTile};
use crate::achieved_error::AchievedError;
use crate::codec::Packing;
use crate::error::{Error, Result};
use crate::format::directory::TileDirectory;
use crate::progress::Watch;
use crate::reader::MapReader;
use crate::tile::Tile;
use crate::tile_id::TileId;
use crate::write_options::WriteOptions;
use crate::writer::MapWriter;

/// Writes `map` to `output` with the levels of a pyramid that `options` ask
/// for; any it has already are replaced. `progress` is told how many of how
/// many tiles of level 0 that are not empty are done.
///
/// Level 0 keeps its bytes. The error of the others is against the average of
/// level 0 as it is stored. `output` may be the file that `map` was opened
/// from: it is replaced when all is written, and left as it was on an error.
/// For memory and determinism see [`build_pyramid`].
///
/// ```
/// # use dsm_core::{MapInfo, PixelListsBuilder, Vertex};
/// # use dsm_io::detail::{MapWriter, TileId};
/// # use dsm_io::{AchievedError, Metadata, WriteOptions};
/// use dsm_io::{Limits, MapReader, PyramidOptions, mip};
///
/// # let folder = tempfile::tempdir()?;
/// # let (input, output) = (folder.path().join("shadow.dsm"), folder.path().join("mip.dsm"));
/// # let mut pixels = PixelListsBuilder::<f32>::new(2, 1);
/// # pixels.push(Vertex::new(2.0, 1.0));
/// # pixels.push(Vertex::new(2.0, 0.0));
/// # pixels.finish_pixel()?;
/// # pixels.finish_pixel()?;
/// # let mut writer = MapWriter::create(
/// #     &input, Metadata::new(2, 1, 1, MapInfo::default()), WriteOptions::default())?;
/// # writer.write_tile(TileId::default(), pixels.finish()?.view(), AchievedError::NONE)?;
/// # writer.finish()?;
/// // Two pixels: one is blocked from depth 2 on, the other is empty.
/// let map = MapReader::open(&input, &Limits::default())?;
/// mip(&map, &output, &PyramidOptions::default(), dsm_core::Progress::ignore)?;
///
/// let map = MapReader::open(&output, &Limits::default())?;
/// assert_eq!(map.levels().len(), 2);
/// assert_eq!(map.read_map::<f32>(1)?.pixel(0, 0).at(3.0), 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Error::Mismatch`] if the map has several views, is not cut into squares or
/// does not begin at its own corner; else as [`build_pyramid`].
pub fn mip(
    map: &MapReader,
    output: &Path,
    options: &PyramidOptions,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<()> {
    mip_watched(map, output, options, &mut progress)
}

fn mip_watched(
    map: &MapReader,
    output: &Path,
    options: &PyramidOptions,
    progress: Watch<'_>,
) -> Result<()> {
    let refuse = |reason| Err(Error::mismatch(reason).in_file(map.container().path()));
    let level = map.levels()[0];
    if map.levels().iter().any(|level| level.view != 0) {
        return refuse("a map of several views has no one pyramid");
    }
    if [level.x, level.y] != [0, 0] || map.crop().is_some() {
        return refuse("it is a part of a map: merge the parts first");
    }
    if level.tile_width != level.tile_height {
        return refuse("its tiles are not square");
    }
    let packing = map.packing()?.unwrap_or(Packing::Zstd);
    let write = WriteOptions::default().with_tile_size(level.tile_width).with_packing(packing);
    let mut writer = MapWriter::create(output, map.metadata().clone(), write)?;
    if map.metadata().channels == 1 {
        build_pyramid::<f32, _>(&Stored(map), &mut writer, options, progress)
    } else {
        build_pyramid::<Rgb, _>(&Stored(map), &mut writer, options, progress)
    }?;
    writer.finish()?;
    Ok(())
}

/// Level 0 of a map, as it is stored.
struct Stored<'a>(&'a MapReader);

impl<T: Transmittance> PyramidSource<T> for Stored<'_> {
    type Functions<'a>
        = Tile<'a, T>
    where
        Self: 'a;

    fn is_clear(&self, x: u32, y: u32) -> bool {
        let entry = self.0.directory(0).ok().and_then(|directory| directory.get(x, y));
        entry.is_none_or(|entry| entry.is_empty() && entry.error == AchievedError::NONE)
    }

    fn depth_error(&self) -> f32 {
        let entries = self.0.directory(0).into_iter().flat_map(TileDirectory::iter);
        entries.map(|(_, entry)| entry.depth_error).fold(0.0, f32::max)
    }

    fn tile(&self, id: TileId) -> Result<SourceTile<Tile<'_, T>>> {
        let stored = self.0.encoded_tile(id)?;
        // A tile without vertices may still state an error.
        let functions = if stored.0.vertex_count == 0 { None } else { Some(self.0.tile(id)?) };
        Ok(SourceTile { functions, stored: Some(stored) })
    }
}
