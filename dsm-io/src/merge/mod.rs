//! Several maps into one: the light past all of them, or parts put together.

pub(crate) mod assemble;
mod multiply;
mod windows;

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{Progress, Tolerance};

use self::windows::Windows;
use crate::crop::Crop;
use crate::error::{Error, Result};
use crate::kind::map_kind::MapKind;
use crate::kind::reader::KindReader;
use crate::reader::MapReader;

/// The operation that made one map of several, as [`merge`] reports it.
///
/// ```no_run
/// use dsm_core::Progress;
/// use dsm_io::{Limits, MapReader, MergeReport, merge};
///
/// let open = |path: &str| MapReader::open(std::path::Path::new(path), &Limits::default());
/// let parts = [open("left.dsm")?, open("right.dsm")?];
/// match merge(&parts, "whole.dsm".as_ref(), None, Progress::ignore)? {
///     MergeReport::Multiplied { tolerance, .. } => println!("within {}", tolerance.epsilon()),
///     MergeReport::Assembled => println!("crops of one map"),
///     _ => {}
/// }
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MergeReport {
    /// Level 0 of the maps was multiplied.
    #[non_exhaustive]
    Multiplied {
        /// The tolerance that the product states.
        tolerance: Tolerance,
        /// Number of other levels that the maps had.
        lost_levels: usize,
    },
    /// The maps were parts of one, which they are again.
    Assembled,
}

/// Makes one map of two or more, at `output`. `progress` is told how much is
/// done, and of how much.
///
/// Maps of the same pixels are multiplied: the fraction of light that gets past
/// all of them, where what they block has nothing to do with each other. (Two
/// opaque halves of a pixel multiply to ¼; the truth is ½ or 0.) The product
/// states the sum of their tolerances and `tolerance`, which it may add: 0
/// multiplies steps as they are, and smooth stretches within 5e-7. Only if
/// several maps used the slack that a tolerance has for that, it states as
/// much more as the sum needs. One coloured map makes a coloured product. The
/// tiles are those of the first map, and so are attributes; the number of
/// samples and the filter are kept where all agree. Level 0 alone is read.
///
/// Crops of one map, which together cover it once, are put together. Their
/// tiles are copied as they are, so that the result is the file that would
/// have been written as a whole.
///
/// Maps of one display window and camera, in data windows that share no pixel, are
/// put together too, as a render in stripes or tiles leaves them: functions are
/// copied into tiles of the first map's size, and pixels that no map has are clear.
///
/// Memory: a few tiles of each map a thread, and 64 bytes a tile. Tiles are
/// multiplied in parallel, on the current rayon pool. The same input gives the
/// same bytes whatever the number of threads. Where all maps are empty, a tile
/// costs nothing. On an error `output` is what it was before; it may be one of
/// the maps.
///
/// ```
/// use dsm_core::{DeepMap, MapInfo, PixelListsBuilder, Progress, Vertex};
/// use dsm_io::{Limits, MapReader, MergeReport, Metadata, WriteOptions, merge, write_map};
/// # use dsm_io::AchievedError;
///
/// // Two maps of one pixel, of half and a quarter of the light past depth 2.
/// let folder = tempfile::tempdir()?;
/// let mut maps = Vec::new();
/// for left in [0.5, 0.25] {
///     let mut pixels = PixelListsBuilder::<f32>::new(1, 1);
///     pixels.push(Vertex::new(2.0, 1.0));
///     pixels.push(Vertex::new(2.0, left));
///     pixels.finish_pixel()?;
///     let map = DeepMap::new(MapInfo::default(), pixels.finish()?);
///     let path = folder.path().join(format!("{left}.dsm"));
///     let metadata = Metadata::new(1, 1, 1, MapInfo::default());
///     write_map(&path, metadata, &map, AchievedError::NONE, WriteOptions::default())?;
///     maps.push(MapReader::open(&path, &Limits::default())?);
/// }
/// let output = folder.path().join("both.dsm");
/// let report = merge(&maps, &output, None, Progress::ignore)?;
/// assert!(matches!(report, MergeReport::Multiplied { .. }));
/// let both = MapReader::open(&output, &Limits::default())?.read_map::<f32>(0)?;
/// assert_eq!(both.pixel(0, 0).at(3.0), 0.125);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Error::Setting`] or [`Error::Mismatch`] if there are fewer than two maps, they are neither of the
/// same pixels nor crops that fit together, their cameras or windows differ,
/// crops are given a tolerance, or tolerances add up to 1; else what is wrong
/// with a map, or keeps the output from being written.
pub fn merge(
    maps: &[MapReader],
    output: &Path,
    tolerance: Option<Tolerance>,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<MergeReport> {
    let [first, others @ ..] = maps else {
        return Err(Error::setting("there is nothing to merge"));
    };
    if others.is_empty() {
        let reason = match first.crop() {
            None => {
                "one map alone can't be merged: it needs another one of the same pixels".to_owned()
            }
            Some(_) => format!(
                "this is one crop alone, {}: merging needs the others, which cover the rest of the map",
                size_text(first)
            ),
        };
        return Err(refuse(first, reason));
    }
    if let Some(windows) = Windows::of(maps) {
        refuse_tolerance(tolerance)?;
        windows.join(output, &mut progress)?;
        return Ok(MergeReport::Assembled);
    }
    if others.iter().all(|other| pixels(other) == pixels(first)) {
        return multiply::multiply(maps, output, tolerance.unwrap_or_default(), &mut progress);
    }
    if maps.iter().all(|map| map.crop().is_some()) {
        refuse_tolerance(tolerance)?;
        assemble::assemble(maps, output, &mut progress)?;
        return Ok(MergeReport::Assembled);
    }
    let sizes: Vec<_> = maps.iter().map(size_text).collect();
    Err(Error::mismatch(format!(
        "maps of the same pixels are multiplied, and crops of one map or data windows of one \
         picture put together, but these have {}",
        sizes.join(", ")
    )))
}

/// Refuses a tolerance for parts.
fn refuse_tolerance(tolerance: Option<Tolerance>) -> Result<()> {
    let reason = "parts are put together as they are: a tolerance has no use";
    tolerance.map_or(Ok(()), |_| Err(Error::setting(reason)))
}

/// Which pixels a file has, of which map.
fn pixels(map: &MapReader) -> ([u32; 2], Option<Crop>) {
    let whole = map.whole_metadata();
    ([whole.width, whole.height], map.crop())
}

fn size_text(map: &MapReader) -> String {
    let ([width, height], crop) = pixels(map);
    match crop {
        None => format!("{width} × {height} pixels"),
        Some(crop) => format!(
            "{} × {} pixels at ({}, {}) of {width} × {height}",
            crop.width, crop.height, crop.x, crop.y
        ),
    }
}

/// An error about a map that names its file, if it has one.
fn refuse<K: MapKind>(map: &KindReader<K>, reason: String) -> Error {
    Error::mismatch(reason).in_file(map.container().path())
}
