//! The plan as a file.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};

use super::cost::Costs;

/// The version of the plan's form.
const VERSION: u32 = 1;

/// The steps of a plan, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Step {
    /// Part `INDEX % parts` of map `INDEX / parts`
    Bake,
    /// The parts of map `INDEX` into one
    Merge,
    /// The smaller levels of map `INDEX`
    Mip,
    /// Map `INDEX` as a whole
    Verify,
}

impl Step {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Bake => "bake",
            Self::Merge => "merge",
            Self::Mip => "mip",
            Self::Verify => "verify",
        }
    }
}

/// A map of the plan. Paths are relative to the plan's folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlannedMap {
    pub(crate) scene: String,
    pub(crate) frame: Option<u32>,
    /// The sum of the scene's own file; None of a built-in one.
    pub(crate) sum: Option<String>,
    pub(crate) output: String,
}

/// Maps to bake, the parts of each, and what is done with them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Plan {
    /// The version of this form.
    pub(crate) version: u32,
    pub(crate) kind: String,
    pub(crate) resolution: [u32; 2],
    pub(crate) tile: u32,
    /// The switches of every bake, as they were given.
    pub(crate) bake: Vec<String>,
    /// Threads of a task.
    pub(crate) threads: usize,
    /// Whether maps get their smaller levels.
    pub(crate) mip: bool,
    /// The parts of every map: x₀, y₀, x₁, y₁.
    pub(crate) parts: Vec<[u32; 4]>,
    pub(crate) maps: Vec<PlannedMap>,
    /// What a task of each step takes; None if nobody tried.
    pub(crate) cost: Option<Costs>,
}

impl Plan {
    /// The version that new plans have.
    pub(crate) const VERSION: u32 = VERSION;

    /// Reads a plan.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read(path).with_context(|| format!("{}", path.display()))?;
        let read = || -> Result<Self> {
            let plan: Self = serde_json::from_slice(&text)?;
            plan.check()?;
            Ok(plan)
        };
        read().with_context(|| format!("{} is no plan of this program", path.display()))
    }

    /// Its text: one form for one plan.
    pub(crate) fn text(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    fn check(&self) -> Result<()> {
        let Self { version, maps, parts, resolution, .. } = self;
        ensure!(*version == VERSION, "version {version}; this program reads version {VERSION}");
        ensure!(!maps.is_empty() && !parts.is_empty(), "it has no maps or no parts");
        ensure!(self.task_count(Step::Bake).is_some(), "it has more than 2³² tasks");
        for part in parts {
            let [left, top, right, bottom] = *part;
            let fits =
                left < right && top < bottom && right <= resolution[0] && bottom <= resolution[1];
            ensure!(fits, "part {left},{top},{right},{bottom} does not lie in the map");
        }
        Ok(())
    }

    /// The tasks of a step; None for more than 2³².
    pub(crate) fn task_count(&self, step: Step) -> Option<u32> {
        let maps = u32::try_from(self.maps.len()).ok()?;
        match step {
            Step::Bake => maps.checked_mul(u32::try_from(self.parts.len()).ok()?),
            Step::Mip if !self.mip => Some(0),
            _ => Some(maps),
        }
    }

    /// The steps that there is something to do in.
    pub(crate) fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        let all = [Step::Bake, Step::Merge, Step::Mip, Step::Verify];
        all.into_iter().filter(|step| *step != Step::Mip || self.mip)
    }

    /// The map and the part of a task of bakes.
    pub(crate) fn task(&self, index: u32) -> Result<(usize, usize)> {
        let (index, parts) = (index as usize, self.parts.len());
        if index / parts >= self.maps.len() {
            bail!("the plan has {} bakes, numbered from 0", self.maps.len() * parts);
        }
        Ok((index / parts, index % parts))
    }

    /// A map of the plan.
    pub(crate) fn map(&self, index: u32) -> Result<&PlannedMap> {
        let count = self.maps.len();
        let map = self.maps.get(index as usize);
        map.with_context(|| format!("the plan has {count} maps, numbered from 0"))
    }

    /// The crop of a part; None if it is all of the map.
    pub(crate) fn crop(&self, part: usize) -> Option<[u32; 4]> {
        (self.parts.len() > 1).then(|| self.parts[part])
    }
}

impl PlannedMap {
    /// The scene's file in this frame; None for a built-in scene.
    pub(crate) fn scene_file(&self) -> Option<PathBuf> {
        let name = self.scene_name();
        (!name.starts_with("builtin:")).then(|| PathBuf::from(name))
    }

    /// The scene's name in this frame, as bakes state it.
    pub(crate) fn scene_name(&self) -> String {
        let path = Path::new(&self.scene);
        match self.frame {
            Some(frame) => {
                let path = deepshadow::scene::detail::frame_path(path, frame);
                path.to_string_lossy().into_owned()
            }
            None => self.scene.clone(),
        }
    }

    /// What the map is called in messages.
    pub(crate) fn title(&self) -> String {
        match self.frame {
            Some(frame) => format!("{} in frame {frame}", self.scene_name()),
            None => self.scene_name(),
        }
    }
}

/// The command line of a bake of a part, with the program's name.
pub(crate) fn bake_arguments(
    plan: &Plan,
    map: &PlannedMap,
    crop: Option<[u32; 4]>,
    output: &Path,
) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = ["dsm-tools", "bake"].map(OsString::from).to_vec();
    arguments.push(map.scene.clone().into());
    arguments.extend(["-o".into(), output.as_os_str().to_owned()]);
    arguments.extend(plan.bake.iter().map(OsString::from));
    if let Some([left, top, right, bottom]) = crop {
        arguments.extend(["--crop".into(), format!("{left},{top},{right},{bottom}").into()]);
    }
    if let Some(frame) = map.frame {
        arguments.extend(["--frame".into(), frame.to_string().into()]);
    }
    arguments.extend(["--threads".into(), plan.threads.to_string().into(), "--quiet".into()]);
    arguments
}
