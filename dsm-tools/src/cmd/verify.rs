//! `verify`: whether maps are what they should be.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Result, bail};
use dsm_io::{Container, Error, Limits, MapReader, MapSource, check_bound};
use mtsm::{LayeredKind, LayeredReader};
use serde::Serialize;

use crate::args::Verify;
use crate::output::progress;
use crate::parallel::with_threads;

/// What `--json` prints.
#[derive(Serialize)]
struct Outcome {
    ok: bool,
    files: Vec<FileOutcome>,
}

#[derive(Serialize)]
struct FileOutcome {
    path: String,
    ok: bool,
    errors: Vec<String>,
}

pub(crate) fn run(request: &Verify) -> Result<()> {
    let files: Vec<_> = with_threads(request.effort.threads, || {
        Ok(request.files.iter().map(|path| check(path, request)).collect())
    })?;
    let outcome = Outcome { ok: files.iter().all(|file| file.ok), files };
    let printed = print(&outcome, request.json);
    // A failed check stays one, whoever stopped listening.
    outcome.result()?;
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
    let errors = open_and_check(path, request).unwrap_or_else(|error| vec![whole_message(error)]);
    FileOutcome { path: path.display().to_string(), ok: errors.is_empty(), errors }
}

fn open_and_check(path: &Path, request: &Verify) -> dsm_io::Result<Vec<String>> {
    let limits = Limits::default();
    let container = Container::open(path, &limits)?;
    if LayeredKind::from_name(&container.kind()?).is_none() {
        return Ok(check_map(MapReader::new(container, &limits)?, request));
    }
    let reader = LayeredReader::new(container, &limits)?;
    let mut errors: Vec<_> = reader.verify().into_iter().map(whole_message).collect();
    if request.against.is_some() {
        errors.push(format!("{}: a layered map has no source to be held to", path.display()));
    }
    Ok(errors)
}

/// What is wrong with a map. Only one that is sound is held to its bound.
fn check_map(reader: MapReader, request: &Verify) -> Vec<String> {
    let errors: Vec<_> = reader.verify().into_iter().map(whole_message).collect();
    match &request.against {
        Some(source) if errors.is_empty() => {
            check_against(reader, source, request).err().into_iter().collect()
        }
        _ => errors,
    }
}

fn check_against(reader: MapReader, path: &Path, request: &Verify) -> Result<(), String> {
    let limits = Limits::default();
    let checked = MapSource::open(path, request.part.as_deref(), &limits).and_then(|mut source| {
        let rows = u64::from(reader.metadata().height);
        let bar = progress::bar(rows, "comparing".to_owned(), request.quiet);
        let checked = check_bound(reader, &mut source, |rows| bar.set_position(rows.into()));
        bar.finish_and_clear();
        checked
    });
    match checked {
        Ok(_) => Ok(()),
        // That names a file already.
        Err(error @ Error::File(_)) => Err(whole_message(error)),
        Err(error) => Err(format!("against {}: {}", path.display(), whole_message(error))),
    }
}

/// An error with its causes, in one line.
fn whole_message(error: Error) -> String {
    format!("{:#}", anyhow::Error::from(error))
}

impl Outcome {
    fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        for FileOutcome { path, errors, .. } in &self.files {
            match errors.len() {
                0 => writeln!(output, "{path}: ok")?,
                1 => writeln!(output, "{path}: 1 error")?,
                count => writeln!(output, "{path}: {count} errors")?,
            }
            for error in errors {
                writeln!(output, "  {error}")?;
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
