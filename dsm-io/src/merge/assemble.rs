//! Crops into the map that they are parts of.

use std::path::Path;

use dsm_core::Tolerance;

use super::refuse;
use crate::error::{Error, Result, check_limit};
use crate::format::level::Level;
use crate::format::write::ContainerWriter;
use crate::kind::map_kind::MapKind;
use crate::kind::reader::KindReader;
use crate::limits::Limits;
use crate::progress::{Watch, tell};
use crate::tile_id::TileId;

/// Puts crops of a map of any kind together, tile by tile as they are stored, at `output`.
/// Together they hold each pixel of the map once, of every view. `progress` is told of tiles.
///
/// Memory: 64 bytes a tile, and one stored tile.
///
/// # Errors
///
/// [`Error::Mismatch`] for crops that are not of one map, or do not cover it once; else what
/// is wrong with a crop, or keeps the output from being written.
pub fn assemble<K: MapKind>(
    crops: &[KindReader<K>],
    output: &Path,
    progress: Watch<'_>,
) -> Result<()> {
    let Some(first) = crops.first() else {
        return Err(Error::setting("there is nothing to put together"));
    };
    if let Some(whole) = crops.iter().find(|crop| crop.crop().is_none()) {
        return Err(refuse(whole, "it is a whole map, no crop of one".to_owned()));
    }
    let (json, tolerance) = metadata(crops)?;
    let whole = first.whole_metadata();
    let levels: Vec<Level> = first
        .levels()
        .iter()
        .map(|&part| Level {
            x: 0,
            y: 0,
            width: whole.width,
            height: whole.height,
            tolerance: tolerance.epsilon(),
            ..part
        })
        .collect();
    let sources = sources(crops, &levels[0])?;
    let mut writer = ContainerWriter::create(output)?;
    for &level in &levels {
        writer.add_level(level)?;
    }
    let total = (sources.len() * levels.len()) as u64;
    let mut done = 0_u64;
    for (number, level) in (0..).zip(&levels) {
        let [columns, _] = level.tiles();
        for (index, source) in (0..).zip(&sources) {
            let id = TileId::new(number, index % columns, index / columns);
            copy_tile(&crops[*source], level, id, &mut writer)
                .map_err(|error| error.in_file(crops[*source].container().path()))?;
            done += 1;
            tell(progress, done, total)?;
        }
    }
    writer.finish(&json)?;
    Ok(())
}

/// The header of the whole map, and the tolerance that it states.
fn metadata<K: MapKind>(crops: &[KindReader<K>]) -> Result<(Vec<u8>, Tolerance)> {
    let first = &crops[0];
    let part = first.levels()[0];
    let mut whole = first.whole_metadata().clone();
    for other in crops {
        let level = other.levels()[0];
        let mut stated = other.whole_metadata().clone();
        // A crop may have had to state more than was asked for.
        let tolerance = stated.info.tolerance;
        if whole.info.tolerance.epsilon() < tolerance.epsilon() {
            whole.info.tolerance = tolerance;
        }
        stated.info.tolerance = whole.info.tolerance;
        let differs = if stated != whole || other.levels().len() != first.levels().len() {
            Some("metadata")
        } else if [level.tile_width, level.tile_height] != [part.tile_width, part.tile_height] {
            Some("tile sizes")
        } else {
            None
        };
        if let Some(what) = differs {
            return Err(refuse(other, differ(what)));
        }
    }
    let keys: Vec<_> = crops.iter().map(KindReader::keys).collect();
    let pixels = u64::from(whole.width) * u64::from(whole.height);
    let joined = K::join_keys(&keys, pixels).map_err(|what| refuse(first, differ(what)))?;
    // Other numbers of digits, or another program: not one map. Keys that this program does
    // not know stay.
    let json = first.container().metadata();
    let is_raw = crops.iter().all(|crop| crop.container().metadata() == json);
    let json = if is_raw && joined == *keys[0] {
        json.to_vec()
    } else {
        whole.to_json_of::<K>(&joined)?
    };
    Ok((json, whole.info.tolerance))
}

fn differ(what: &str) -> String {
    format!("its {what} differ from another map's: no crops of one map")
}

/// Which crop holds each tile of `level`, row by row.
fn sources<K: MapKind>(crops: &[KindReader<K>], level: &Level) -> Result<Vec<usize>> {
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

fn copy_tile<K: MapKind>(
    crop: &KindReader<K>,
    level: &Level,
    id: TileId,
    writer: &mut ContainerWriter,
) -> Result<()> {
    let part = crop.levels()[id.level as usize];
    let [left, top] = corner(&part);
    let own = TileId::new(id.level, id.x - left, id.y - top);
    debug_assert!(
        part.tile_rect(own.x, own.y).map(|rect| [rect.width, rect.height])
            == level.tile_rect(id.x, id.y).map(|rect| [rect.width, rect.height])
    );
    let (tile, error) = crop.encoded_tile(own)?;
    writer.write_tile(id, &tile, error)
}
