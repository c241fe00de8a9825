//! What of a map stands in a page: all levels, as many as fit, or the middle of the only one.

use anyhow::Result;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use deepshadow::ShadowMap;
use deepshadow::files::detail::{Level, TileRect};
use serde::Serialize;

use super::level_columns::{ColumnHead, LevelColumns};

/// Packed numbers are hardly ever smaller than this share of what they were: a level that would not
/// fit even so is not tried.
const SMALLEST_SHARE: u64 = 12;
/// Bytes of a number, and the least of its row.
const ROW_BYTES: u64 = 8;

/// A level of a map, as a page holds it.
#[derive(Debug, Serialize)]
pub(super) struct EmbeddedLevel {
    index: u32,
    /// Pixels that are held, from this corner of the level on.
    width: u32,
    height: u32,
    corner: [u32; 2],
    full_width: u32,
    full_height: u32,
    /// Width and height of a tile.
    tile: [u32; 2],
    /// Column, row, and stated largest and mean error of tiles that are not empty.
    tiles: Vec<(u32, u32, f32, f32)>,
    columns: Vec<ColumnHead>,
    has_lists: bool,
    columns_id: String,
    /// The packed columns in base64.
    #[serde(skip)]
    pub(super) text: String,
}

/// The levels that a page holds of each map, and what it leaves out.
pub(super) struct Embedded {
    pub(super) levels: Vec<Vec<EmbeddedLevel>>,
    pub(super) note: Option<String>,
}

impl Embedded {
    /// As many levels as fit in `budget` bytes, the smallest ones first; of views the first. If
    /// none does, the middle of the smallest level. The same of each map.
    pub(super) fn new(maps: &[&ShadowMap], budget: u64) -> Result<Self> {
        let count = maps.iter().map(|map| map.levels().len()).min().unwrap_or(0) as u32;
        let is_views = maps.iter().any(|map| map.levels().iter().any(|level| level.view > 0));
        let order: Vec<u32> =
            if is_views { (0..count).collect() } else { (0..count).rev().collect() };
        let (mut left, mut taken) = (budget, Vec::new());
        for &index in &order {
            let Some(level) = embed_all(maps, index, None, left)? else { break };
            left -= size(&level);
            taken.push((index, level));
        }
        let note = match (taken.len() as u32, order.first()) {
            (taken, _) if taken == count => None,
            (0, Some(&index)) => {
                let (level, note) = middle(maps, index, budget)?;
                taken.push((index, level));
                Some(note)
            }
            (kept, _) if is_views => {
                Some(format!("only the first {kept} of {count} views are in this page"))
            }
            (kept, _) => {
                let [width, height] = maps[0].size();
                let names = if count - kept == 1 {
                    "level 0".to_owned()
                } else {
                    format!("levels 0 to {}", count - kept - 1)
                };
                Some(format!(
                    "{names} of the map of {width} × {height} pixels left out of this page"
                ))
            }
        };
        taken.sort_by_key(|(index, _)| *index);
        let mut levels: Vec<Vec<EmbeddedLevel>> = maps.iter().map(|_| Vec::new()).collect();
        for (_, of_maps) in taken {
            levels.iter_mut().zip(of_maps).for_each(|(levels, level)| levels.push(level));
        }
        Ok(Self { levels, note })
    }
}

fn size(levels: &[EmbeddedLevel]) -> u64 {
    levels.iter().map(|level| level.text.len() as u64 + 40 * level.tiles.len() as u64 + 1000).sum()
}

/// A level of all maps, or none if it takes more than `budget` bytes.
fn embed_all(
    maps: &[&ShadowMap],
    index: u32,
    rect: Option<TileRect>,
    budget: u64,
) -> Result<Option<Vec<EmbeddedLevel>>> {
    let mut levels = Vec::new();
    let mut left = budget;
    for (number, map) in maps.iter().enumerate() {
        let Some(level) = embed(map, number, index, rect, left)? else { return Ok(None) };
        let taken = size(std::slice::from_ref(&level));
        if taken > left {
            return Ok(None);
        }
        left -= taken;
        levels.push(level);
    }
    Ok(Some(levels))
}

fn embed(
    map: &ShadowMap,
    number: usize,
    index: u32,
    rect: Option<TileRect>,
    budget: u64,
) -> Result<Option<EmbeddedLevel>> {
    let level = &map.levels()[index as usize];
    let most = budget.saturating_mul(SMALLEST_SHARE);
    let directory = map.container().directory(index)?;
    let vertices = directory.iter().map(|(_, tile)| tile.vertex_count).fold(0, u64::saturating_add);
    let bytes = vertices.saturating_mul(ROW_BYTES).saturating_add(level.pixel_count());
    if rect.is_none() && bytes > most {
        return Ok(None);
    }
    let whole = TileRect { x: 0, y: 0, width: level.width, height: level.height };
    let rect = rect.unwrap_or(whole);
    let has_media = map.kind_metadata()?.get("media").is_some_and(|media| !media.is_null());
    let names: &[&str] = if has_media { &MEDIA_COLUMNS } else { &[] };
    let mut columns = LevelColumns::new(names);
    // A row of tiles at a time, so that what is too large is found before all of it is held.
    let mut top = rect.y;
    while top < rect.y + rect.height {
        let bottom = (top / level.tile_height + 1).saturating_mul(level.tile_height);
        let bottom = bottom.min(rect.y + rect.height);
        let rows = TileRect { x: rect.x, y: top, width: rect.width, height: bottom - top };
        map.contents_of(index, rows, |contents| columns.push(&contents))?;
        if columns.raw_bytes() > most {
            return Ok(None);
        }
        top = bottom;
    }
    let (heads, has_lists, packed) = columns.finish();
    let touches = |x: u32, y: u32| level.tile_rect(x, y).is_some_and(|tile| meet(tile, rect));
    let tiles = directory
        .iter()
        .filter(|(id, tile)| !tile.is_empty() && touches(id.x, id.y))
        .map(|(id, tile)| (id.x, id.y, tile.error.max, tile.error.mean))
        .collect();
    Ok(Some(EmbeddedLevel {
        index,
        width: rect.width,
        height: rect.height,
        corner: [rect.x, rect.y],
        full_width: level.width,
        full_height: level.height,
        tile: [level.tile_width, level.tile_height],
        tiles,
        columns: heads,
        has_lists,
        columns_id: format!("map-{number}-level-{index}"),
        text: STANDARD.encode(packed),
    }))
}

/// Columns of fragments of a map with media: tiles without any have one less.
const MEDIA_COLUMNS: [&str; 5] = ["depth", "to depth", "opacity", "covered 64ths", "mask"];

fn meet(a: TileRect, b: TileRect) -> bool {
    a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height
}

/// The largest part around a level's middle that fits, halved until it does, and the note of it.
fn middle(maps: &[&ShadowMap], index: u32, budget: u64) -> Result<(Vec<EmbeddedLevel>, String)> {
    let Level { width, height, .. } = maps[0].levels()[index as usize];
    let mut size = [width, height];
    loop {
        size = size.map(|side| side.div_ceil(2));
        let [x, y] = [(width - size[0]) / 2, (height - size[1]) / 2];
        let rect = TileRect { x, y, width: size[0], height: size[1] };
        // One pixel is held, however many numbers it has.
        let budget = if size == [1, 1] { u64::MAX } else { budget };
        if let Some(levels) = embed_all(maps, index, Some(rect), budget)? {
            let [right, bottom] = [x + size[0], y + size[1]];
            let note = format!(
                "only pixels {x} ≤ x < {right}, {y} ≤ y < {bottom} of {width} × {height} are in this page"
            );
            return Ok((levels, note));
        }
    }
}

impl EmbeddedLevel {
    pub(super) fn columns_id(&self) -> &str {
        &self.columns_id
    }
}
