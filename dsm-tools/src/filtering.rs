//! Filtered lookups in a map's file, as far as commands share them.

use anyhow::{Context, Result, bail};
use dsm_core::{Footprint, LevelChoice, Pyramid, ShadowLookup, Transmittance, VisibilityField};
use dsm_io::{CachedMap, CursorPool, FieldKind};

/// Bytes of tiles that are kept at hand: the tiles of large maps come and go,
/// and small ones stay whole.
pub(crate) const TILE_BYTES: u64 = 1 << 30;

/// Pixels that the filter of one point may reach: about a second's work.
const MOST_PIXELS: u64 = 1 << 26;

/// How points of the world are looked up in the map.
pub(crate) fn shadow_lookup<T: Transmittance, K: FieldKind>(
    map: &CachedMap<T, K>,
) -> Result<ShadowLookup> {
    let metadata = map.reader().metadata();
    let known = metadata.info.camera.map(|_| ());
    known.context("the map has no camera to project points of the world with")?;
    Ok(ShadowLookup::new(&metadata.info, [metadata.width, metadata.height])?)
}

/// Cursors over the map, once it is known that it has the level and that the
/// filter reaches no more pixels of it than a lookup may visit.
pub(crate) fn cursors<T: Transmittance, K: FieldKind>(
    map: CachedMap<T, K>,
    footprint: &Footprint,
    level: LevelChoice,
) -> Result<CursorPool<T, K>> {
    let cursors = CursorPool::new(map, level)?;
    cursors.with_pyramid(|pyramid| check(pyramid, footprint, level))?;
    Ok(cursors)
}

/// Whether the pyramid has the level, and the filter reaches no more pixels of it
/// than a lookup may visit.
pub(crate) fn check<F: VisibilityField>(
    pyramid: &Pyramid<F>,
    footprint: &Footprint,
    level: LevelChoice,
) -> Result<()> {
    if let LevelChoice::Fixed(level) = level {
        match pyramid.levels().len() {
            count if level <= (count - 1) as f64 => {}
            1 => bail!("there is no level {level}: the map has one level, 0"),
            count => {
                bail!("there is no level {level}: the map has {count} levels, 0 to {}", count - 1)
            }
        }
    }
    let reached = pixels_of_a_filter(pyramid, footprint, level);
    if reached > MOST_PIXELS {
        bail!(
            "the filter reaches {reached} pixels, more than the {MOST_PIXELS} of a lookup: \
             look up a coarser level (--level)"
        );
    }
    Ok(())
}

/// About how many pixels a filter visits in the finer of its levels.
fn pixels_of_a_filter<F: VisibilityField>(
    pyramid: &Pyramid<F>,
    footprint: &Footprint,
    level: LevelChoice,
) -> u64 {
    let Footprint::Isotropic(filter) = footprint else { return 1 };
    let width = f64::from(filter.width());
    let finest = match level {
        LevelChoice::Fixed(level) => level,
        LevelChoice::Auto => (width / 2.0).log2(),
    };
    let levels = pyramid.levels();
    let level = (finest.max(0.0) as usize).min(levels.len() - 1);
    let reach = width / 2.0_f64.powi(level as i32) + 1.0;
    levels[level].size().map(|size| (reach as u64).min(size.into())).iter().product()
}
