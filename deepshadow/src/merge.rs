//! Several maps into one, of any kind.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{Progress, Tolerance};
use dsm_io::detail::Container;
use dsm_io::{Error as FileError, Limits, MergeReport};

use crate::error::{Error, Result};
use crate::kind::Kind;
use crate::kinds::implementation;

/// How maps become one.
pub(crate) struct MergeSettings<'a> {
    /// What a product may be off by on top of what the maps state.
    pub(crate) tolerance: Option<Tolerance>,
    /// Who is told how far it has come.
    pub(crate) watch: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
}

/// Makes one map of several files of one kind, at `output`, which may be one of them. `watch` is
/// told how far it has come, and may break it off.
///
/// Crops of one map, of any kind that has them, are put together as they are stored: the result
/// has the bytes of the map baked as a whole. Deep maps are joined or multiplied besides, as
/// [`files::merge`](dsm_io::merge()) tells. Memory: 64 bytes a tile, and a few tiles a thread.
/// On an error `output` is what it was before.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use deepshadow::{Bake, Kind, bake, merge};
///
/// let scene = deepshadow::scene::builtin_scene("spinning-sphere")?;
/// let folder = tempfile::tempdir()?;
/// let [left, right, both, whole] =
///     ["left.dsm", "right.dsm", "both.dsm", "whole.dsm"].map(|name| folder.path().join(name));
/// let settings = Bake::new([128, 64])?.with_kind(Kind::FRAGMENTS);
/// let bake = |crop: Option<[u32; 4]>, path: &std::path::Path| {
///     let settings = settings.clone().with_crop(crop);
///     bake(&scene, &scene.light, &settings, path, |_| ControlFlow::Continue(()))
/// };
/// bake(Some([0, 0, 64, 64]), &left)?;
/// bake(Some([64, 0, 128, 64]), &right)?;
/// merge(&[left, right], &both, None, |_| ControlFlow::Continue(()))?;
/// bake(None, &whole)?;
/// assert!(std::fs::read(both)? == std::fs::read(whole)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Error::Unsupported`] for files of several kinds, or a tolerance of crops; [`Error::Query`]
/// for what the kind has no merge of; [`Error::File`] for maps that do not fit together, or what
/// is wrong with one, or keeps the output from being written; [`Error::Interrupted`].
pub fn merge(
    maps: &[impl AsRef<Path>],
    output: &Path,
    tolerance: Option<Tolerance>,
    mut watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<MergeReport> {
    let limits = Limits::default();
    let open = |path: &Path| -> Result<(Kind, Container)> {
        let container = Container::open(path, &limits)?;
        let found = container.kind().map_err(|error| error.in_file(container.path()))?;
        let wanted = "one that this program knows";
        let kind = Kind::named(&found).ok_or(FileError::Kind { found, wanted });
        Ok((kind.map_err(|error| error.in_file(container.path()))?, container))
    };
    let opened = maps.iter().map(|path| open(path.as_ref()));
    let (kinds, containers): (Vec<Kind>, Vec<Container>) =
        opened.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    let Some(&kind) = kinds.first() else {
        return Err(Error::Unsupported("there is nothing to merge".to_owned()));
    };
    if let Some(at) = kinds.iter().position(|other| *other != kind) {
        let reason = format!(
            "{} is a map of kind {}, and {} one of kind {}: maps of one kind are merged",
            maps[at].as_ref().display(),
            kinds[at].name(),
            maps[0].as_ref().display(),
            kind.name(),
        );
        return Err(Error::Unsupported(reason));
    }
    let mut settings = MergeSettings { tolerance, watch: &mut watch };
    implementation(kind).merge(containers, &limits, output, &mut settings).map_err(|error| {
        match error {
            Error::File(FileError::Interrupted) => Error::Interrupted,
            error => error,
        }
    })
}
