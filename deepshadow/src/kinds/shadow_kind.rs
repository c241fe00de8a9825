//! The trait that each kind of map implements.

use std::path::Path;

use dsm_io::detail::Container;

use crate::bake::Job;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::{Error, Result};
use crate::file::OpenMap;
use crate::file::open_options::OpenOptions;

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

    /// Opens the map that a container holds.
    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>>;
}

/// That a switch is for other kinds.
pub(super) fn refuse(switch: &str, kinds: &str) -> Result<()> {
    Err(Error::Unsupported(format!("{switch} is for maps of kind {kinds}")))
}
