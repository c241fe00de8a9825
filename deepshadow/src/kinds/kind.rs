//! A kind of map, whichever it is.

use std::fmt;
use std::path::Path;

use dsm_io::Container;

use super::deep::Deep;
use super::fragments::Fragments;
use super::layers::Layers;
use super::mtsm::Mtsm;
use crate::bake::{Bake, BakeReport, Job};
use crate::error::{Error, Result};
use crate::map::{OpenMap, OpenOptions};
use crate::query::Method;

/// A kind of map that can be baked and queried.
///
/// ```
/// use deepshadow::Kind;
///
/// assert_eq!(Kind::named("mtsm").map(Kind::name), Some("mtsm"));
/// assert!(Kind::ALL.contains(&Kind::DEEP));
/// ```
#[derive(Clone, Copy)]
pub struct Kind(&'static dyn ShadowKind);

/// What the front door has to know of a kind of map.
pub(crate) trait ShadowKind: Send + Sync {
    /// The kind's name in headers and on the command line.
    fn name(&self) -> &'static str;

    /// A line about the kind.
    fn about(&self) -> &'static str;

    /// The settings that the kind does not have, of those that were set.
    fn check(&self, settings: &Bake) -> Result<()>;

    /// Bakes a map into a file.
    fn bake(&self, job: &Job<'_>, output: &Path) -> Result<BakeReport>;

    /// Opens the map that a container holds.
    fn open(&self, container: Container, options: &OpenOptions) -> Result<Box<dyn OpenMap>>;
}

impl Kind {
    /// Deep shadow maps.
    pub const DEEP: Self = Self(&Deep);

    /// All kinds.
    pub const ALL: &[Self] = &[Self::DEEP, Self(&Fragments), Self(&Layers), Self(&Mtsm)];

    /// The kind of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// The kind's name in headers and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.0.name()
    }

    /// A line about the kind.
    #[must_use]
    pub fn about(self) -> &'static str {
        self.0.about()
    }

    pub(crate) fn check(self, settings: &Bake) -> Result<()> {
        self.0.check(settings)
    }

    pub(crate) fn bake(self, job: &Job<'_>, output: &Path) -> Result<BakeReport> {
        self.0.bake(job, output)
    }

    pub(crate) fn open(
        self,
        container: Container,
        options: &OpenOptions,
    ) -> Result<Box<dyn OpenMap>> {
        self.0.open(container, options)
    }

    /// The kind that comes closest to rays through a scene, for a map that is
    /// asked by `method`: fragments, unless there are media, which fragments
    /// cannot hold, or rules for layers were set.
    #[must_use]
    pub fn for_area_lights(has_media: bool, method: &Method) -> Self {
        let has_rules = matches!(method, Method::Trace(trace) if trace.has_layer_rules());
        let no_planes = has_media || has_rules || matches!(method, Method::Pcf(_));
        if no_planes { Self(&Mtsm) } else { Self(&Fragments) }
    }
}

impl PartialEq for Kind {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Kind {}

impl fmt::Debug for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Kind({})", self.name())
    }
}

/// That a switch is for other kinds.
pub(super) fn refuse(switch: &str, kinds: &str) -> Result<()> {
    Err(Error::Unsupported(format!("{switch} is for maps of kind {kinds}")))
}
