//! `plan`: bakes that a farm's own scheduler runs.

use std::collections::HashSet;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use deepshadow::Kind;
use deepshadow::scene::detail::{frame_path, has_frame};

use crate::args::{Bake, PlanRequest, bake_of};
use crate::plan::job::{Plan, PlannedMap};
use crate::plan::sum::Sum;
use crate::plan::trial::Trial;
use crate::plan::{openjd, slurm};

pub(crate) fn run(request: &PlanRequest) -> Result<()> {
    let PlanRequest { output, slurm: script, openjd: template, .. } = request;
    let name = output.file_name().context("a plan has a name")?;
    let folder = folder_of(output);
    for path in [script, template].into_iter().flatten() {
        let own = fs::canonicalize(folder_of(path)).ok();
        ensure!(
            own.is_some() && own == fs::canonicalize(folder).ok(),
            "{} has to lie in the folder of the plan",
            path.display()
        );
    }
    let files: Vec<PathBuf> =
        [Some(output), script.as_ref(), template.as_ref()].into_iter().flatten().cloned().collect();
    let files = files.iter().map(std::path::absolute);
    let files = files.collect::<std::io::Result<Vec<_>>>()?;
    std::env::set_current_dir(folder)
        .with_context(|| format!("cannot enter the folder {}", folder.display()))?;
    let plan = planned(request)?;
    let mut files = files.into_iter();
    let name = name.to_str().context("the plan's name has to be text")?;
    let mut write = |text: String| -> Result<()> {
        let path = files.next().context("a file without a name")?;
        Ok(deepshadow::files::detail::replace_file(&path, text.as_bytes())?)
    };
    write(plan.text()?)?;
    if let Some(path) = script {
        write(slurm::script(&plan, name))?;
        make_executable(path)?;
    }
    if template.is_some() {
        write(serde_json::to_string_pretty(&openjd::template(&plan, name))? + "\n")?;
    }
    tell(&plan);
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The plan, from its own folder.
fn planned(request: &PlanRequest) -> Result<Plan> {
    let maps = maps(request)?;
    let settings = settings(request, &maps[0])?;
    let mut plan = Plan {
        version: Plan::VERSION,
        kind: settings.kind.name().to_owned(),
        resolution: settings.resolution,
        tile: settings.tile_size,
        bake: request.bake.clone(),
        threads: request.threads,
        mip: request.mip,
        parts: settings.parts(1)?,
        maps,
        cost: None,
    };
    ensure!(!plan.mip || settings.kind == Kind::DEEP, "--mip is for maps of kind deep");
    let is_flat = settings.kind != Kind::VIEWS;
    let is_cut = request.crops.is_some_and(|crops| crops > 1)
        || request.memory.is_some()
        || request.time.is_some();
    if is_cut {
        // A kind without crops says what to do instead.
        let mut part = settings.clone();
        part.crop = settings.parts(1)?.first().copied();
        part.check()?;
    }
    if let Some(crops) = request.crops {
        plan.parts = settings.parts(crops)?;
    }
    if request.trial == 0 {
        return Ok(plan);
    }
    let tiles = |[left, top, right, bottom]: [u32; 4]| {
        let axis = |first: u32, end: u32| u64::from((end - first).div_ceil(plan.tile));
        axis(left, right) * axis(top, bottom)
    };
    let all = tiles([0, 0, plan.resolution[0], plan.resolution[1]]);
    let mut whole = settings.clone();
    whole.crop = settings.parts(1)?.first().copied();
    if whole.check().is_err() {
        // A trial of a part is none of a kind without parts.
        return Ok(plan);
    }
    let trial = Trial::run(&plan, &plan.maps[0], request.trial)?;
    let mut parts = plan.parts.clone();
    if request.memory.is_some() || request.time.is_some() {
        let most = trial.tiles_within(request.memory, request.time, is_flat)?;
        // Parts are not all alike: as few as keep all of them within it.
        let mut count = all.div_ceil(most);
        loop {
            parts = settings.parts(u32::try_from(count).context("too many parts")?)?;
            if count >= all || parts.iter().all(|&part| tiles(part) <= most) {
                break;
            }
            count = (count + count.div_ceil(16)).min(all);
        }
    }
    let largest = parts.iter().map(|&part| tiles(part)).max().unwrap_or(all);
    let cost = Some(trial.costs(largest, all, is_flat));
    Ok(Plan { parts, cost, ..plan })
}

/// The maps of all scenes in all frames.
fn maps(request: &PlanRequest) -> Result<Vec<PlannedMap>> {
    let mut maps = Vec::new();
    let mut names = HashSet::new();
    let frames: Vec<Option<u32>> = match &request.frames {
        Some(frames) => frames.iter().copied().map(Some).collect(),
        None => vec![None],
    };
    for scene in &request.scenes {
        ensure!(
            request.frames.is_some() || !scene.contains('#'),
            "{scene} is a sequence: --frames tells which of it"
        );
        let stem = match scene.strip_prefix("builtin:") {
            Some(name) => name.to_owned(),
            None => {
                let stem = Path::new(scene).file_stem().context("a scene has a name")?;
                stem.to_str().context("names of scenes have to be text")?.to_owned()
            }
        };
        for &frame in &frames {
            let name = match frame {
                None => stem.clone(),
                Some(frame) => {
                    let stem = Path::new(&stem);
                    let numbered = if has_frame(stem) {
                        stem.to_owned()
                    } else {
                        format!("{}.####", stem.display()).into()
                    };
                    frame_path(&numbered, frame).display().to_string()
                }
            };
            let output = format!("{}/{name}.dsm", request.maps);
            ensure!(
                names.insert(output.clone()),
                "two scenes would be {output}: their files' names have to differ"
            );
            let mut map = PlannedMap { scene: scene.clone(), frame, sum: None, output };
            if let Some(path) = map.scene_file() {
                let sum = Sum::of_file(&path).with_context(|| format!("{}", path.display()))?;
                map.sum = Some(sum);
            }
            maps.push(map);
        }
    }
    Ok(maps)
}

/// What bakes are told, checked as `bake` checks it.
fn settings(request: &PlanRequest, map: &PlannedMap) -> Result<deepshadow::Bake> {
    let mut arguments: Vec<OsString> = ["dsm-tools", "bake"].map(OsString::from).to_vec();
    arguments.push(map.scene.clone().into());
    arguments.extend(["-o", "map.dsm"].map(OsString::from));
    arguments.extend(request.bake.iter().map(OsString::from));
    let Bake { settings, finds_resolution, .. } = match bake_of(arguments) {
        Ok(bake) => bake,
        Err(error) => {
            let text = error.to_string();
            let line = text.lines().next().unwrap_or_default();
            bail!("behind --: {}", line.trim_start_matches("error: "));
        }
    };
    ensure!(!finds_resolution, "behind --: a plan needs a --resolution of this kind");
    Ok(settings)
}

#[cfg(unix)]
fn make_executable(path: &Path) -> Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let path = path.file_name().map(Path::new).unwrap_or(path);
    let mut permissions = fs::metadata(path)?.permissions();
    permissions.set_mode(permissions.mode() | 0o111 & (permissions.mode() >> 2));
    Ok(fs::set_permissions(path, permissions)?)
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> Result<()> {
    Ok(())
}

/// Says what was planned, on stdout.
fn tell(plan: &Plan) {
    let mut lines = vec![format!("{} maps of {} parts each", plan.maps.len(), plan.parts.len())];
    for step in plan.steps() {
        let tasks = plan.task_count(step).unwrap_or(0);
        let cost = match plan.cost.and_then(|costs| costs.of(step)) {
            Some(cost) => format!(
                ", each up to {} MiB and {} s on {} threads",
                cost.memory.div_ceil(1 << 20),
                cost.seconds,
                plan.threads
            ),
            None => String::new(),
        };
        lines.push(format!("{}: {tasks} tasks{cost}", step.name()));
    }
    // Nobody may be there to read it.
    drop(std::io::Write::write_all(&mut std::io::stdout(), (lines.join("\n") + "\n").as_bytes()));
}
