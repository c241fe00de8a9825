//! `verify`: whether maps are what they should be.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use deepshadow::ShadowMap;
use deepshadow::files::dsm_remote::shown;
use deepshadow::files::{Error, Limits, MapSource};
use serde::Serialize;

use crate::args::Verify;
use crate::in_map::{empty_is, is_empty, is_part};
use crate::output::limit;
use crate::output::progress::{self, Watch};
use crate::output::stated::StatedReport;
use crate::output::warnings::Warnings;
use crate::parallel::with_threads;

/// The JSON document.
#[derive(Serialize)]
struct Outcome {
    ok: bool,
    files: Vec<FileOutcome>,
    warnings: Warnings,
}

#[derive(Serialize, Default)]
struct FileOutcome {
    path: String,
    ok: bool,
    errors: Vec<String>,
    /// What its levels state, the finest first; empty unless the map is sound.
    stated: Vec<StatedReport>,
    /// What its bound of layers changed.
    notes: Vec<String>,
    /// What it is if it holds nothing.
    #[serde(skip)]
    empty: Option<&'static str>,
    /// What its source cannot tell.
    #[serde(skip)]
    remark: Option<String>,
}

pub(crate) fn run(request: &Verify) -> Result<()> {
    let size = |path: &Path| path.metadata().map_or(0, |metadata| metadata.len());
    let bytes = request.files.iter().map(|path| size(path)).sum();
    // The comparison with a source has a bar of its own.
    let quiet = request.quiet || request.against.is_some();
    let bar = progress::bar(bytes, "verifying".to_owned(), quiet);
    let files: Vec<_> = with_threads(request.effort.threads, || {
        let check = |path: &PathBuf| {
            let found = check(path, request);
            bar.inc(size(path));
            found
        };
        Ok(request.files.iter().map(check).collect())
    })?;
    bar.finish_and_clear();
    let mut warnings = Warnings::new(request.strict);
    for FileOutcome { path, empty, remark, .. } in &files {
        warnings.extend(empty.map(|is| format!("{path}: the map holds nothing: it is {is}")));
        warnings.extend(remark.as_ref().map(|remark| format!("{path}: {remark}")));
    }
    let outcome = Outcome { ok: files.iter().all(|file| file.ok), files, warnings };
    let printed = print(&outcome, request.json);
    // A failed check stays one, whoever stopped listening.
    outcome.result()?;
    outcome.warnings.finish()?;
    Ok(printed?)
}

fn print(outcome: &Outcome, json: bool) -> io::Result<()> {
    let mut output = BufWriter::new(io::stdout().lock());
    if json {
        serde_json::to_writer(&mut output, outcome).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        outcome.write_text(&mut output)?;
    }
    output.flush()
}

fn check(path: &Path, request: &Verify) -> FileOutcome {
    let found = open_and_check(path, request).unwrap_or_else(|error| FileOutcome {
        errors: vec![whole_message(error)],
        ..FileOutcome::default()
    });
    let path = shown(path).display().to_string();
    FileOutcome { path, ok: found.errors.is_empty(), ..found }
}

/// What is wrong with a map, and what one that is sound states. Only that is held to
/// its bound.
fn open_and_check(path: &Path, request: &Verify) -> deepshadow::detail::Result<FileOutcome> {
    let map = ShadowMap::open(path)?;
    let mut errors: Vec<_> = map.verify().into_iter().map(whole_message).collect();
    if let (Some(source), true) = (&request.against, errors.is_empty()) {
        errors.extend(check_against(&map, source, request).err());
    }
    let remark = map.container().remark().map(str::to_owned);
    let mut found = FileOutcome { errors, remark, ..FileOutcome::default() };
    if found.errors.is_empty() {
        found.stated = map.stated_errors()?.into_iter().map(StatedReport::from).collect();
        found.notes.extend(limit::of_map(&map)?);
        found.empty = (is_empty(&map)? && !is_part(&map)).then(|| empty_is(map.kind()));
    }
    Ok(found)
}

fn check_against(map: &ShadowMap, path: &Path, request: &Verify) -> Result<(), String> {
    let source = MapSource::open(path, &request.selection, &Limits::default());
    let mut source = source.map_err(whole_message)?;
    let watch = Watch::start("comparing", request.quiet).map_err(whole_message)?;
    let checked = map.check_against(&mut source, |progress| watch.at(progress));
    drop(watch);
    checked.map_err(|error| match error {
        // That names a file already.
        deepshadow::Error::File(Error::File(_)) | deepshadow::Error::Query { .. } => {
            whole_message(error)
        }
        error => format!("against {}: {}", path.display(), whole_message(error)),
    })
}

/// An error with its causes, in one line.
fn whole_message(error: impl Into<anyhow::Error>) -> String {
    format!("{:#}", error.into())
}

impl Outcome {
    fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        for FileOutcome { path, errors, stated, notes, .. } in &self.files {
            match errors.len() {
                0 => writeln!(output, "{path}: ok")?,
                1 => writeln!(output, "{path}: 1 error")?,
                count => writeln!(output, "{path}: {count} errors")?,
            }
            for error in errors {
                writeln!(output, "  {error}")?;
            }
            let moved = stated.first().and_then(StatedReport::about_depths);
            for line in moved.iter().chain(notes) {
                writeln!(output, "  {line}")?;
            }
        }
        Ok(())
    }

    /// The first error stands for all in the line that scripts read.
    fn result(&self) -> Result<()> {
        let failed = self.files.iter().filter(|file| !file.ok).count();
        let first = self.files.iter().flat_map(|file| &file.errors).next();
        match first {
            None => Ok(()),
            Some(error) => bail!("{failed} of {} files failed: {error}", self.files.len()),
        }
    }
}
