//! `dsm-tools`: deep shadow maps on the command line.

mod args;
mod cmd;
mod hints;
mod in_map;
mod input;
mod interrupt;
mod memory;
mod openable;
mod output;
mod page;
mod parallel;
mod plan;
mod points;
mod positions;
mod report;
mod signals;
mod usage;
mod wide_light;

use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;

use args::Request;

/// The input or a check failed.
const FAILED: u8 = 1;
/// Wrong usage.
const WRONG_USAGE: u8 = 2;

fn main() -> ExitCode {
    signals::survive_file_size_limit();
    let request = match Request::parse() {
        Ok(request) => request,
        Err(error) => {
            // Nobody may be there to read it.
            drop(match usage::line(&error) {
                Some(line) => writeln!(io::stderr(), "{line}"),
                None => error.print(),
            });
            return if error.use_stderr() { WRONG_USAGE.into() } else { ExitCode::SUCCESS };
        }
    };
    let done = request.check_outputs().and_then(|()| match request {
        Request::Bake(request) => cmd::bake::run(&request),
        Request::Completions(request) => cmd::completions::run(&request),
        Request::Convert(request) => cmd::convert::run(&request),
        Request::Demo(request) => cmd::demo::run(&request),
        Request::Diff(request) => cmd::diff::run(&request),
        Request::Inspect(request) => cmd::inspect::run(&request),
        Request::Lookup(request) => cmd::lookup::run(&request),
        Request::Man(request) => cmd::man::run(&request),
        Request::Mip(request) => cmd::mip::run(&request),
        Request::Merge(request) => cmd::merge::run(&request),
        Request::Plan(request) => cmd::plan::run(&request),
        Request::Step(request) => cmd::step::run(&request),
        Request::Render(request) => cmd::render::run(&request),
        Request::Report(request) => cmd::report::run(&request),
        Request::Verify(request) => cmd::verify::run(&request),
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            drop(writeln!(io::stderr(), "{}", error_line(&error)));
            FAILED.into()
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let kinds = error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>());
    kinds.map(io::Error::kind).any(|kind| kind == ErrorKind::BrokenPipe)
}

/// The error and its causes in one line, whatever file names hold.
fn error_line(error: &anyhow::Error) -> String {
    let hint = hints::hint(error).map(|hint| format!("; {hint}")).unwrap_or_default();
    output::printable(&format!("error: {error:#}{hint}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::{Context, anyhow};

    #[test]
    fn errors_are_one_line_with_their_causes() {
        let error = anyhow!("no such\r\nthing").context("reading a\nb");
        assert_eq!(error_line(&error), "error: reading a b: no such  thing");
    }

    #[test]
    fn broken_pipes_are_found_below_other_errors() {
        let pipe = Err::<(), _>(io::Error::from(ErrorKind::BrokenPipe)).context("writing");
        assert!(is_broken_pipe(&pipe.unwrap_err()));
        assert!(!is_broken_pipe(&anyhow!("broken pipe")));
    }
}
