//! The switches of prefiltered maps.

use clap::{Args, ValueEnum};
use deepshadow::{Accumulate, Epsilon, PrefilterSettings};

use super::values;

/// How levels are made, of kind prefiltered.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct PrefilterFlags {
    /// How levels are made where no other switch says, of kind prefiltered: what is
    /// nearest to traced rays; or as the method was published (--epsilon 2 --accumulate
    /// add --levels mip, and plain means of depths) [default: nearest]
    #[arg(long, value_enum)]
    preset: Option<PresetName>,
    /// How near in depth fragments become one, in widths of a level's filter at their
    /// depth, of kind prefiltered [default: 0.6 of the depths that the level is for]
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[arg(value_parser = values::length)]
    epsilon: Option<f32>,
    /// How opacities of one pixel become one, of kind prefiltered [default: multiply]
    #[arg(long, value_enum)]
    accumulate: Option<AccumulateName>,
    /// The levels of kind prefiltered: mip, or y, whose levels keep their size from N × N
    /// pixels on [default: y:128]
    #[arg(long, value_name = "mip|y[:N]", value_parser = levels)]
    levels: Option<Levels>,
    /// The last level of kind prefiltered: it bounds how soft shadows are [default: the one
    /// whose filter covers the map]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=24))]
    max_level: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PresetName {
    Nearest,
    Paper,
}

/// Modes of accumulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum AccumulateName {
    Add,
    Multiply,
    Max,
}

impl AccumulateName {
    /// The refusal of the switch where nothing is looked up in levels.
    pub(super) const NOT_PREFILTERED: &str = "--accumulate is for --method prefilter and hybrid";
}

impl From<AccumulateName> for Accumulate {
    fn from(name: AccumulateName) -> Self {
        match name {
            AccumulateName::Add => Self::Add,
            AccumulateName::Multiply => Self::Multiply,
            AccumulateName::Max => Self::Max,
        }
    }
}

/// The size at which a stack begins; none for MIP levels alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Levels(Option<u32>);

fn levels(text: &str) -> Result<Levels, String> {
    let size = match text.split_once(':') {
        None if text == "mip" => return Ok(Levels(None)),
        None if text == "y" => Ok(STACK_SIZE),
        Some(("y", size)) => size.parse(),
        _ => return Err("must be mip, y or y:N".to_owned()),
    };
    match size {
        Ok(size @ 1..=65_536) => Ok(Levels(Some(size))),
        _ => Err("a stack begins at 1 to 65536 pixels".to_owned()),
    }
}

/// The size at which a stack begins where none is told.
const STACK_SIZE: u32 = 128;

impl PrefilterFlags {
    /// How levels are made; none if no switch was given.
    pub(super) fn settings(self) -> Option<PrefilterSettings> {
        let Self { preset, epsilon, accumulate, levels, max_level } = self;
        let is_given = preset.is_some()
            || epsilon.is_some()
            || accumulate.is_some()
            || levels.is_some()
            || max_level.is_some();
        let mut settings = match preset {
            Some(PresetName::Paper) => PrefilterSettings::paper(),
            _ => PrefilterSettings::default(),
        };
        if let Some(widths) = epsilon {
            settings = settings.with_epsilon(Epsilon::Widths(widths));
        }
        if let Some(name) = accumulate {
            settings = settings.with_accumulate(name.into());
        }
        if let Some(Levels(size)) = levels {
            settings = settings.with_stack_size(size);
        }
        is_given.then(|| settings.with_max_level(max_level))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_mip_or_a_stack() {
        assert_eq!(levels("mip"), Ok(Levels(None)));
        assert_eq!(levels("y"), Ok(Levels(Some(128))));
        assert_eq!(levels("y:64"), Ok(Levels(Some(64))));
        for wrong in ["", "z", "y:", "y:0", "y:-1", "mip:3", "y:99999999"] {
            assert!(levels(wrong).is_err(), "{wrong}");
        }
    }
}
