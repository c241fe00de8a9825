//! Where the steps of a plan put what they make.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use super::job::{Plan, PlannedMap};
use super::sum::Sum;

/// The places of a map's parts, beside the map.
///
/// Their folder is named after all that decides the parts' bytes: parts of another plan are
/// never taken for this one's.
#[derive(Clone, Debug)]
pub(crate) struct MapFiles {
    pub(crate) output: PathBuf,
    pub(crate) folder: PathBuf,
}

/// What is written beside a map that was verified.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Done {
    bytes: u64,
    sum: String,
}

impl MapFiles {
    /// Those of a map of a plan, relative to the plan's folder.
    pub(crate) fn new(plan: &Plan, map: &PlannedMap) -> Result<Self> {
        let mut sum = Sum::new();
        let Plan { version, kind, resolution, tile, bake, threads: _, mip, parts, .. } = plan;
        let decides = (version, kind, resolution, tile, bake, mip, parts, map);
        sum.add(&serde_json::to_vec(&decides)?);
        let output = PathBuf::from(&map.output);
        let mut name = output.file_stem().context("a map has a name")?.to_owned();
        name.push(format!(".parts-{}", sum.text()));
        Ok(Self { folder: output.with_file_name(name), output })
    }

    /// A part.
    pub(crate) fn part(&self, index: usize) -> PathBuf {
        self.folder.join(format!("{:05}.dsm", index + 1))
    }

    /// The map without its smaller levels, where it is to have some.
    pub(crate) fn whole(&self, plan: &Plan) -> PathBuf {
        if plan.mip { self.folder.join("whole.dsm") } else { self.output.clone() }
    }

    fn done(&self) -> PathBuf {
        self.folder.join("done.json")
    }

    /// Whether the map is there as it was verified.
    pub(crate) fn is_done(&self) -> bool {
        let Ok(text) = std::fs::read(self.done()) else { return false };
        let Ok(done) = serde_json::from_slice::<Done>(&text) else { return false };
        let length = std::fs::metadata(&self.output).map(|file| file.len());
        length.is_ok_and(|length| length == done.bytes)
            && Sum::of_file(&self.output).is_ok_and(|sum| sum == done.sum)
    }

    /// Remembers that the map was verified, and removes its parts.
    pub(crate) fn set_done(&self, plan: &Plan) -> Result<()> {
        let bytes = std::fs::metadata(&self.output)?.len();
        let done = Done { bytes, sum: Sum::of_file(&self.output)? };
        let done = serde_json::to_vec(&done)?;
        deepshadow::files::detail::replace_file(&self.done(), &done)?;
        let parts = (0..plan.parts.len()).map(|part| self.part(part));
        let whole = plan.mip.then(|| self.whole(plan));
        for path in parts.chain(whole) {
            remove(&path)?;
        }
        Ok(())
    }

    /// Makes the folders that parts and map are put in.
    pub(crate) fn make_folders(&self) -> Result<()> {
        let made = std::fs::create_dir_all(&self.folder);
        made.with_context(|| format!("cannot make the folder {}", self.folder.display()))
    }
}

fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("{}: cannot be removed", path.display()))
        }
        _ => Ok(()),
    }
}

/// Refuses a scene whose file is another one than when the plan was made.
pub(crate) fn check_scene(map: &PlannedMap) -> Result<()> {
    let (Some(path), Some(sum)) = (map.scene_file(), &map.sum) else { return Ok(()) };
    let found = Sum::of_file(&path).with_context(|| format!("{}", path.display()))?;
    ensure!(
        found == *sum,
        "{} has changed since the plan was made: make the plan again, or put the scene back",
        path.display()
    );
    Ok(())
}
