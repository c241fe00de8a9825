//! A baker's tiles into a file of a size.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{Baker, HitSource, Progress, Tolerance, Transmittance};

use crate::bake::{BakeOptions, BakeReport, bake};
use crate::convert::source::MapSource;
use crate::convert::target_size::{convert_to_size, folder_beside};
use crate::convert::tiles::ConvertOptions;
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::metadata::Metadata;

/// Bakes the functions of `baker`, nearly exact, into a file beside `output` that goes, and
/// from there makes a map of at most `bytes` bytes, as [`convert_to_size`] does with
/// `options`. The report of the bake, and the tolerance that the map states: that of the
/// baker and of the conversion together.
///
/// # Errors
///
/// Those of [`bake`] and of [`convert_to_size`].
pub fn bake_to_size<T: Transmittance, S: HitSource<T>>(
    baker: &Baker<T, S>,
    output: &Path,
    options: &ConvertOptions,
    bytes: u64,
    describe: impl FnOnce(&mut Metadata),
    watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
) -> Result<(BakeReport, Tolerance)>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let folder = folder_beside(output)?;
    let path = folder.path().join("functions.dsm");
    let baked = bake(baker, &path, &BakeOptions::default(), describe, &watch)?;
    let mut functions = MapSource::open(&path, None, &Limits::default())?;
    let (_, found) = convert_to_size(&mut functions, output, options, bytes, watch)?;
    let own = baker.settings().tolerance();
    let stated = Tolerance::new(own.epsilon() + found.epsilon())?;
    let length = std::fs::metadata(output).map_err(Error::io("measure"))?.len();
    Ok((BakeReport { bytes: length, ..baked }, stated))
}
