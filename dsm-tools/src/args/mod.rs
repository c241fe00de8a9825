//! What was typed, and what it asks for.

mod bake;
mod convert;
mod demo;
mod diff;
mod filtering;
mod inspect;
mod layer_rule;
mod lookup;
mod merge;
mod mip;
mod render;
mod values;
mod verify;

pub(crate) use bake::Bake;
pub(crate) use convert::{Convert, ConvertTarget};
pub(crate) use demo::Demo;
pub(crate) use diff::Diff;
pub(crate) use inspect::{Inspect, SliceFile};
pub(crate) use lookup::{Lookup, Space};
pub(crate) use merge::Merge;
pub(crate) use mip::Mip;
pub(crate) use render::{Method, Render};
pub(crate) use values::{ImageFile, ImageFormat};
pub(crate) use verify::Verify;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

/// Bakes, converts, inspects, looks up, mip-maps, compares, merges, verifies and
/// renders with deep shadow maps.
#[derive(Debug, Parser)]
#[command(name = "dsm-tools", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Bake(bake::BakeFlags),
    Convert(convert::ConvertFlags),
    Demo(demo::DemoFlags),
    Diff(diff::DiffFlags),
    Inspect(inspect::InspectFlags),
    Lookup(lookup::LookupFlags),
    Mip(mip::MipFlags),
    Merge(merge::MergeFlags),
    Render(render::RenderFlags),
    Verify(verify::VerifyFlags),
}

/// What the program was asked to do, with everything checked that can be
/// without opening a file.
#[derive(Debug)]
pub(crate) enum Request {
    Bake(Box<Bake>),
    Convert(Convert),
    Demo(Demo),
    Diff(Diff),
    Inspect(Inspect),
    Lookup(Lookup),
    Mip(Mip),
    Merge(Merge),
    Render(Box<Render>),
    Verify(Verify),
}

impl Request {
    /// Reads the command line.
    pub(crate) fn parse() -> Result<Self, clap::Error> {
        Ok(match Arguments::try_parse()?.command {
            Command::Bake(flags) => {
                Self::Bake(Box::new(flags.try_into().map_err(|error| wrong("bake", error))?))
            }
            Command::Convert(flags) => {
                Self::Convert(flags.try_into().map_err(|error| wrong("convert", error))?)
            }
            Command::Demo(flags) => Self::Demo(flags.into()),
            Command::Diff(flags) => Self::Diff(flags.into()),
            Command::Inspect(flags) => Self::Inspect(flags.into()),
            Command::Lookup(flags) => {
                Self::Lookup(flags.try_into().map_err(|error| wrong("lookup", error))?)
            }
            Command::Mip(flags) => Self::Mip(flags.into()),
            Command::Merge(flags) => Self::Merge(flags.into()),
            Command::Render(flags) => {
                Self::Render(Box::new(flags.try_into().map_err(|error| wrong("render", error))?))
            }
            Command::Verify(flags) => Self::Verify(flags.into()),
        })
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
}
