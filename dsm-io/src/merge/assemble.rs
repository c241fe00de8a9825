//! Crops into the map that they are parts of.

use std::path::Path;

use super::refuse;
use crate::error::{Error, Result, check_limit};
use crate::format::level::Level;
use crate::format::write::ContainerWriter;
use crate::limits::Limits;
use crate::progress::{Watch, tell};
use crate::reader::MapReader;
use crate::tile_id::TileId;

/// Puts crops together, tile by tile as they are stored.
pub(super) fn assemble(crops: &[MapReader], output: &Path, progress: Watch<'_>) -> Result<()> {
    let Some(first) = crops.first() else { return Ok(()) };
    // Other numbers of digits, or another program: not one map.
    let json = first.container().metadata();
    let part = first.levels()[0];
    let whole = first.whole_metadata();
    for other in crops {
        let level = other.levels()[0];
        let differs = if other.container().metadata() != json {
            Some("metadata")
        } else if [level.tile_width, level.tile_height] != [part.tile_width, part.tile_height] {
            Some("tile sizes")
        } else if level.tolerance != part.tolerance {
            Some("tolerances")
        } else {
            None
        };
        if let Some(what) = differs {
            let reason = format!("its {what} differ from the first map's: no crops of one map");
            return Err(refuse(other, reason));
        }
    }
    let level = Level { x: 0, y: 0, width: whole.width, height: whole.height, ..part };
    let sources = sources(crops, &level)?;
    let mut writer = ContainerWriter::create(output)?;
    writer.add_level(level)?;
    let [columns, _] = level.tiles();
    let mut done = 0_u64;
    for (index, source) in (0..).zip(&sources) {
        let id = TileId::new(0, index % columns, index / columns);
        copy_tile(&crops[*source], &level, id, &mut writer)
            .map_err(|error| error.in_file(crops[*source].container().path()))?;
        done += 1;
        tell(progress, done, sources.len() as u64)?;
    }
    writer.finish(json)?;
    Ok(())
}

/// Which crop holds each tile of `level`, row by row.
fn sources(crops: &[MapReader], level: &Level) -> Result<Vec<usize>> {
    let [columns, _] = level.tiles();
    check_limit("tiles", level.tile_count(), Limits::default().max_tiles)?;
    let mut sources = vec![None; level.tile_count() as usize];
    for (source, crop) in crops.iter().enumerate() {
        let part = crop.levels()[0];
        let [part_columns, part_rows] = part.tiles();
        let [left, top] = corner(&part);
        for (y, x) in (0..part_rows).flat_map(|y| (0..part_columns).map(move |x| (y, x))) {
            let index = (top + y) as usize * columns as usize + (left + x) as usize;
            if sources[index].replace(source).is_some() {
                let reason = "it holds pixels that another crop holds as well";
                return Err(refuse(crop, reason.to_owned()));
            }
        }
    }
    let missing = sources.iter().position(Option::is_none);
    if let Some(missing) = missing {
        let (x, y) = (missing % columns as usize, missing / columns as usize);
        return Err(Error::mismatch(format!(
            "no crop holds the pixels from ({}, {}) on",
            x * level.tile_width as usize,
            y * level.tile_height as usize
        )));
    }
    Ok(sources.into_iter().flatten().collect())
}

/// Column and row of a crop's first tile in the whole map.
fn corner(part: &Level) -> [u32; 2] {
    // A reader refuses crops that begin elsewhere.
    [part.x.unsigned_abs() / part.tile_width, part.y.unsigned_abs() / part.tile_height]
}

fn copy_tile(
    crop: &MapReader,
    level: &Level,
    id: TileId,
    writer: &mut ContainerWriter,
) -> Result<()> {
    let part = crop.levels()[0];
    let [left, top] = corner(&part);
    let own = TileId::new(0, id.x - left, id.y - top);
    debug_assert!(
        part.tile_rect(own.x, own.y).map(|rect| [rect.width, rect.height])
            == level.tile_rect(id.x, id.y).map(|rect| [rect.width, rect.height])
    );
    let (tile, error) = crop.encoded_tile(own)?;
    writer.write_tile(id, &tile, error)
}
