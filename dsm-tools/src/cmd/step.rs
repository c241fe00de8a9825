//! `step`: one task of a plan, if it is not done already.

use std::fs::File;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};
use deepshadow::files::detail::AtomicFile;
use deepshadow::files::{Limits, MapReader, PyramidOptions, mip};
use deepshadow::merge;

use crate::args::{StepRequest, bake_of};
use crate::parallel::with_threads;
use crate::plan::files::{MapFiles, check_scene};
use crate::plan::found::{self, FoundPart, is_sound};
use crate::plan::job::{Plan, PlannedMap, Step, bake_arguments};
use crate::plan::parts;

pub(crate) fn run(request: &StepRequest) -> Result<()> {
    let plan = Plan::read(&request.plan)?;
    if let Some(folder) = request.plan.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::env::set_current_dir(folder)
            .with_context(|| format!("cannot enter the folder {}", folder.display()))?;
    }
    let Some(step) = request.step else {
        return plan.steps().try_for_each(|step| all(&plan, step, request.quiet));
    };
    ensure!(step != Step::Mip || plan.mip, "the plan's maps have no smaller levels");
    match request.index {
        Some(index) => task(&plan, step, index, request.quiet),
        None => all(&plan, step, request.quiet),
    }
}

/// All tasks of a step.
fn all(plan: &Plan, step: Step, quiet: bool) -> Result<()> {
    let tasks = plan.task_count(step).unwrap_or(0);
    (0..tasks).try_for_each(|index| task(plan, step, index, quiet))
}

fn task(plan: &Plan, step: Step, index: u32, quiet: bool) -> Result<()> {
    let (map, part) = match step {
        Step::Bake => plan.task(index).map(|(map, part)| (map as u32, part))?,
        _ => (index, 0),
    };
    let map = plan.map(map)?;
    let files = MapFiles::new(plan, map)?;
    check_scene(map)?;
    let made = if files.is_done() {
        false
    } else {
        match step {
            Step::Bake => bake(plan, map, &files, part)?,
            Step::Merge => merge_parts(plan, map, &files)?,
            Step::Mip => make_levels(plan, &files)?,
            Step::Verify => verify(plan, &files)?,
        }
    };
    if !quiet {
        let what = match step {
            Step::Bake => format!("{}, part {}", map.title(), part + 1),
            _ => map.title(),
        };
        let made = if made { "done" } else { "there already" };
        writeln!(std::io::stdout(), "{} of {what}: {made}", step.name())?;
    }
    Ok(())
}

fn bake(plan: &Plan, map: &PlannedMap, files: &MapFiles, part: usize) -> Result<bool> {
    let path = files.part(part);
    // Later steps have what they need of it.
    if is_sound(plan, map, part, &path) {
        return Ok(false);
    }
    files.make_folders()?;
    let request = bake_of(bake_arguments(plan, map, plan.crop(part), &path));
    super::bake::run(&request.map_err(|error| anyhow!("{error}"))?)?;
    Ok(true)
}

fn merge_parts(plan: &Plan, map: &PlannedMap, files: &MapFiles) -> Result<bool> {
    let paths: Vec<PathBuf> = (0..plan.parts.len()).map(|part| files.part(part)).collect();
    // A file that is not there is a part that is missing, one that is damaged an error.
    let there = paths.iter().filter(|path| path.exists());
    let found = there.map(|path| Ok((path.clone(), FoundPart::open(path)?.0)));
    parts::check(plan, map, &found.collect::<Result<Vec<_>>>()?)?;
    let whole = files.whole(plan);
    if let [alone] = &paths[..] {
        copy(alone, &whole)?;
    } else {
        with_threads(Some(plan.threads), || {
            Ok(merge(&paths, &whole, None, |_| ControlFlow::Continue(()))?)
        })?;
    }
    Ok(true)
}

/// Copies a file, so that there is all of it or nothing.
fn copy(from: &Path, to: &Path) -> Result<()> {
    let mut source = File::open(from).with_context(|| format!("{}", from.display()))?;
    let mut file = AtomicFile::create(to)?;
    std::io::copy(&mut source, &mut file).with_context(|| format!("{}", from.display()))?;
    Ok(file.commit(&[])?)
}

fn make_levels(plan: &Plan, files: &MapFiles) -> Result<bool> {
    let map = MapReader::open(files.whole(plan), &Limits::default())?;
    with_threads(Some(plan.threads), || {
        let options = PyramidOptions::default();
        Ok(mip(&map, &files.output, &options, |_| ControlFlow::Continue(()))?)
    })?;
    Ok(true)
}

fn verify(plan: &Plan, files: &MapFiles) -> Result<bool> {
    found::verify(&files.output)?;
    files.set_done(plan)?;
    Ok(true)
}
