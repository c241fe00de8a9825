//! The command line, parsed and checked.

mod bake;
mod completions;
mod compression;
mod convert;
mod demo;
mod diff;
mod far_table;
mod filtering;
mod inspect;
mod layer_rule;
mod lookup;
mod man;
#[cfg(test)]
mod manual;
mod merge;
mod mip;
mod plan;
mod prefilter;
mod render;
mod report;
mod selection;
mod step;
mod values;
mod verify;
mod version;

pub(crate) use bake::Bake;
pub(crate) use completions::Completions;
pub(crate) use convert::{Convert, ConvertTarget};
pub(crate) use demo::Demo;
pub(crate) use diff::Diff;
pub(crate) use inspect::{Inspect, SliceFile};
pub(crate) use lookup::{Lookup, Points, Space};
pub(crate) use man::Man;
pub(crate) use merge::Merge;
pub(crate) use mip::Mip;
pub(crate) use plan::PlanRequest;
pub(crate) use render::{Method, Render};
pub(crate) use report::Report;
pub(crate) use step::StepRequest;
pub(crate) use values::{ImageFile, ImageFormat, is_exr};
pub(crate) use verify::Verify;

use std::ffi::OsString;
use std::path::Path;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use deepshadow::files::dsm_remote::is_url;

use crate::input::STREAM;

/// Bakes, converts, inspects, looks up, mip-maps, compares, merges, verifies and
/// renders with deep shadow maps, here or on a farm.
#[derive(Debug, Parser)]
#[command(name = "dsm-tools", version = version::version(), max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Bake(bake::BakeFlags),
    Completions(completions::CompletionsFlags),
    Convert(convert::ConvertFlags),
    Demo(demo::DemoFlags),
    Diff(diff::DiffFlags),
    Inspect(inspect::InspectFlags),
    Lookup(lookup::LookupFlags),
    Man(man::ManFlags),
    Mip(mip::MipFlags),
    Merge(merge::MergeFlags),
    Plan(plan::PlanFlags),
    Render(render::RenderFlags),
    Report(report::ReportFlags),
    Step(step::StepFlags),
    Verify(verify::VerifyFlags),
}

/// A request, with everything checked that can be without opening a file.
#[derive(Debug)]
pub(crate) enum Request {
    Bake(Box<Bake>),
    Completions(Completions),
    Convert(Convert),
    Demo(Demo),
    Diff(Diff),
    Inspect(Inspect),
    Lookup(Lookup),
    Man(Man),
    Mip(Mip),
    Merge(Merge),
    Plan(PlanRequest),
    Render(Box<Render>),
    Report(Report),
    Step(StepRequest),
    Verify(Verify),
}

impl Request {
    /// Checks that what the command writes can be written, before hours of work
    /// are lost to a name that cannot.
    pub(crate) fn check_outputs(&self) -> anyhow::Result<()> {
        for output in self.outputs() {
            // Stores have no folders to make first.
            if is_url(output) {
                continue;
            }
            let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
            if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
                let (output, folder) = (output.display(), folder.display());
                anyhow::bail!(
                    "{output}: cannot create a file beside it: {folder} is no folder; make it first"
                );
            }
            deepshadow::files::detail::check_output(output)?;
        }
        Ok(())
    }

    /// The files that the command writes; the demo makes its own folder.
    fn outputs(&self) -> Vec<&Path> {
        match self {
            Self::Bake(bake) => vec![&bake.output],
            Self::Convert(convert) => vec![&convert.output],
            Self::Mip(mip) => vec![&mip.output],
            Self::Merge(merge) => vec![&merge.output],
            Self::Render(render) => vec![&render.output.path],
            Self::Report(report) => named(Some(&report.html)).into_iter().collect(),
            Self::Inspect(inspect) => {
                let slice = inspect.slice.as_ref().map(|slice| &slice.image);
                let images = inspect.plot.iter().chain(slice).map(|image| image.path.as_path());
                images.chain(named(inspect.html.as_deref())).collect()
            }
            Self::Diff(diff) => named(diff.html.as_deref()).into_iter().collect(),
            Self::Plan(plan) => {
                let files = [Some(&plan.output), plan.slurm.as_ref(), plan.openjd.as_ref()];
                files.into_iter().flatten().map(AsRef::as_ref).collect()
            }
            Self::Lookup(lookup) => match &lookup.points {
                Points::Csv(_) => Vec::new(),
                Points::Picture { output, .. } => vec![output],
            },
            Self::Completions(_)
            | Self::Demo(_)
            | Self::Man(_)
            | Self::Step(_)
            | Self::Verify(_) => Vec::new(),
        }
    }

    /// Reads the command line.
    pub(crate) fn parse() -> Result<Self, clap::Error> {
        Self::of(Arguments::try_parse()?)
    }

    fn of(arguments: Arguments) -> Result<Self, clap::Error> {
        Ok(match arguments.command {
            Command::Bake(flags) => {
                Self::Bake(Box::new(flags.try_into().map_err(|error| wrong("bake", error))?))
            }
            Command::Completions(flags) => Self::Completions(flags.into()),
            Command::Convert(flags) => {
                Self::Convert(flags.try_into().map_err(|error| wrong("convert", error))?)
            }
            Command::Demo(flags) => Self::Demo(flags.into()),
            Command::Diff(flags) => Self::Diff(flags.into()),
            Command::Inspect(flags) => Self::Inspect(flags.into()),
            Command::Lookup(flags) => {
                Self::Lookup(flags.try_into().map_err(|error| wrong("lookup", error))?)
            }
            Command::Man(flags) => Self::Man(flags.into()),
            Command::Mip(flags) => Self::Mip(flags.into()),
            Command::Merge(flags) => Self::Merge(flags.into()),
            Command::Plan(flags) => {
                Self::Plan(flags.try_into().map_err(|error| wrong("plan", error))?)
            }
            Command::Step(flags) => Self::Step(flags.into()),
            Command::Render(flags) => {
                Self::Render(Box::new(flags.try_into().map_err(|error| wrong("render", error))?))
            }
            Command::Report(flags) => {
                Self::Report(flags.try_into().map_err(|error| wrong("report", error))?)
            }
            Command::Verify(flags) => {
                Self::Verify(flags.try_into().map_err(|error| wrong("verify", error))?)
            }
        })
    }
}

/// The request that these words of a command line are: what reports are made of.
pub(crate) fn render_request(words: &[OsString]) -> Result<Box<Render>, clap::Error> {
    let command = ["dsm-tools", "render"].map(OsString::from);
    match Request::of(Arguments::try_parse_from(command.iter().chain(words))?)? {
        Request::Render(request) => Ok(request),
        _ => Err(wrong("render", "no request to render")),
    }
}

/// A page's file, if it is not printed.
fn named(page: Option<&Path>) -> Option<&Path> {
    page.filter(|path| path.as_os_str() != STREAM)
}

/// The program's command line: what completions and manual pages are made from.
pub(crate) fn program() -> clap::Command {
    Arguments::command()
}

/// The `bake` of a command line, for commands that bake.
pub(crate) fn bake_of(arguments: impl IntoIterator<Item = OsString>) -> Result<Bake, clap::Error> {
    match Request::of(Arguments::try_parse_from(arguments)?)? {
        Request::Bake(bake) => Ok(*bake),
        _ => Err(wrong("bake", "another command")),
    }
}

/// A usage error of a command that only its switches together show.
fn wrong(name: &str, error: impl std::fmt::Display) -> clap::Error {
    let mut program = Arguments::command();
    program.build();
    let command = program.find_subcommand(name).cloned();
    command.unwrap_or(program).error(ErrorKind::ValueValidation, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn the_examples_of_every_command_are_accepted() {
        for command in Arguments::command().get_subcommands() {
            let name = command.get_name();
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<_> =
                help.lines().filter(|line| line.starts_with("  dsm-tools ")).collect();
            assert!(!examples.is_empty(), "{name}");
            for example in examples {
                let words: Vec<_> = example.split_whitespace().collect();
                assert_eq!(words[1], name, "{example}");
                let request = Arguments::try_parse_from(&words).and_then(Request::of);
                assert!(request.is_ok(), "{example}: {:?}", request.err());
            }
        }
    }
}
