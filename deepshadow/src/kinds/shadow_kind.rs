//! The trait that each kind of map implements.

use std::path::Path;

use dsm_io::detail::{Container, KindReader, MapKind, assemble};
use dsm_io::{Limits, MergeReport};

use crate::bake::Job;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::{Error, Result};
use crate::file::OpenMap;
use crate::file::open_options::OpenOptions;
use crate::merge::MergeSettings;

/// A kind of map, as bakes and open files need it.
pub(crate) trait ShadowKind: Send + Sync {
    /// The settings that the kind does not have, of those that were set.
    fn check(&self, settings: &Bake) -> Result<()>;

    /// Whether its levels are filtered as settings say.
    fn is_filtered(&self) -> bool {
        false
    }

    /// Whether it is made from several points of its light.
    fn has_light_samples(&self) -> bool {
        false
    }

    /// Whether it is views from several points of its light.
    fn has_views(&self) -> bool {
        false
    }

    /// Bakes a map into a file.
    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport>;

    /// Puts crops of a map of this kind together, or makes one of several in another way that
    /// the kind has.
    fn merge(
        &self,
        maps: Vec<Container>,
        limits: &Limits,
        output: &Path,
        settings: &mut MergeSettings<'_>,
    ) -> Result<MergeReport>;

    /// Opens the map that a container holds.
    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>>;
}

/// Puts crops of a map of kind `K` together.
pub(super) fn join<K: MapKind>(
    maps: Vec<Container>,
    limits: &Limits,
    output: &Path,
    settings: &mut MergeSettings<'_>,
) -> Result<MergeReport> {
    if settings.tolerance.is_some() {
        let reason = "crops are put together as they are: a tolerance has no use";
        return Err(Error::Unsupported(reason.to_owned()));
    }
    let maps = maps.into_iter().map(|map| KindReader::<K>::new(map, limits));
    let maps = maps.collect::<std::result::Result<Vec<_>, _>>()?;
    if let Some(map) = maps.iter().find(|map| map.crop().is_none()) {
        let reason = format!(
            "{} is put together of its crops; this is a whole one, and only maps of kind deep are \
             multiplied",
            K::TITLE
        );
        return Err(Error::query(map, reason));
    }
    if let [alone] = &maps[..] {
        let reason =
            "this is one crop alone: merging needs the others, which cover the rest of the map";
        return Err(Error::query(alone, reason));
    }
    assemble(&maps, output, settings.watch)?;
    Ok(MergeReport::Assembled)
}

/// That a switch is for other kinds.
pub(super) fn refuse(switch: &str, kinds: &str) -> Result<()> {
    Err(Error::Unsupported(format!("{switch} is for maps of kind {kinds}")))
}
