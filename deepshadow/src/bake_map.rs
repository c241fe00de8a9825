//! Bakes of any kind of map.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::Progress;
use dsm_scene::Light;

use crate::bake::Job;
use crate::bake::occluders::Occluders;
use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::{Error, Result};
use crate::kinds::implementation;

/// Bakes what `light` sees of `occluders` into a file that replaces `output`, if
/// there is one. `watch` is told before every tile how far the bake has come, from
/// any thread, and may break it off.
///
/// Of an area light the kinds that are traced are baked from behind it. The same
/// arguments give the same bytes, whatever the number of threads. On an error
/// `output` is what it was before.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use deepshadow::{Bake, Kind, bake};
///
/// let scene = deepshadow::scene::builtin_scene("spinning-sphere")?;
/// let settings = Bake::new([32, 32])?.with_kind(Kind::LAYERS);
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("sphere.dsm");
/// let report = bake(&scene, &scene.light, &settings, &path, |_| ControlFlow::Continue(()))?;
/// assert!(report.bytes > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Error::Unsupported`] for settings that the kind does not have,
/// [`Error::Occluders`] with what a source says, [`Error::Interrupted`] if `watch`
/// broke it off; else what keeps the map from being made or written.
pub fn bake(
    occluders: &dyn Occluders,
    light: &Light,
    settings: &Bake,
    output: &Path,
    watch: impl Fn(Progress) -> ControlFlow<()> + Sync,
) -> Result<BakeReport> {
    settings.check()?;
    let job = Job::new(occluders, light, settings, &watch)?;
    implementation(settings.kind).bake(&job, output).map_err(|error| match error {
        Error::File(dsm_io::Error::Interrupted) => Error::Interrupted,
        Error::File(dsm_io::Error::HitSource(error)) => Error::Occluders(error),
        error => error,
    })
}

impl Bake {
    /// Checks that the kind has everything that was set.
    ///
    /// # Errors
    ///
    /// [`Error::Unsupported`] with what the kind does
    /// not have.
    pub fn check(&self) -> Result<()> {
        let kind = implementation(self.kind);
        if self.filtering.is_some() && !kind.is_filtered() {
            let reason = "ε, levels and accumulation are for maps of kind prefiltered";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        if self.light_samples.is_some() && !kind.has_light_samples() {
            let reason = "--light-samples is for maps of kind attenuation";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        if self.views.is_some() && !kind.has_views() {
            let reason = "--views is for maps of kind views";
            return Err(Error::Unsupported(reason.to_owned()));
        }
        kind.check(self)
    }
}
