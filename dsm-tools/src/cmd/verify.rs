//! `verify`: whether maps are what they should be.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Result, bail};
use dsm_io::{Limits, MapReader};
use serde::Serialize;

use crate::args::Verify;

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
    let files: Vec<_> = request.files.iter().map(|path| check(path)).collect();
    let outcome = Outcome { ok: files.iter().all(|file| file.ok), files };
    let mut output = BufWriter::new(io::stdout().lock());
    if request.json {
        serde_json::to_writer(&mut output, &outcome).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        outcome.write_text(&mut output)?;
    }
    output.flush()?;
    outcome.result()
}

fn check(path: &Path) -> FileOutcome {
    let errors = match MapReader::open(path, &Limits::default()) {
        Ok(reader) => reader.verify(),
        Err(error) => vec![error],
    };
    let errors: Vec<_> = errors.iter().map(|error| format!("{:#}", error)).collect();
    FileOutcome { path: path.display().to_string(), ok: errors.is_empty(), errors }
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
