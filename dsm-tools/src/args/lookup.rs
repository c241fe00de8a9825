//! The switches of `lookup`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use dsm_core::{Footprint, LevelChoice};

use super::filtering::{self, FilterName};
use super::values::{self, Effort};

/// Answers how much light reaches each of many points
///
/// Reads points from a CSV file whose header names columns x, y and z, and
/// prints one line of CSV a point, in order: the fraction of light that is
/// left (v), or of each colour (r,g,b). A point outside the map, behind the
/// camera or with a NaN is lit: 1.
#[derive(Debug, Args)]
pub(crate) struct LookupFlags {
    /// A deep shadow map (.dsm)
    map: PathBuf,
    /// The points, as CSV
    #[arg(long, value_name = "P.csv")]
    points: PathBuf,
    /// What x, y and z are: a position in the scene; or a position in the map
    /// in pixels, and the depth
    #[arg(long, value_enum, default_value_t = Space::World)]
    space: Space,
    /// Which pixels are averaged: the one that contains the point, or all
    /// that a filter around it reaches
    #[arg(long, value_enum, default_value_t = FilterName::Point)]
    filter: FilterName,
    /// Full width of the filter in pixels of level 0, at least 1, of a tent 2
    /// [default: the least]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    width: Option<f32>,
    /// Level of the map's pyramid that is read, 0 being the finest; between
    /// two, both are; auto: the one whose pixels are half as wide as the
    /// filter
    #[arg(long, value_name = "L|auto", default_value = "0", allow_negative_numbers = true)]
    #[arg(value_parser = filtering::level)]
    level: LevelChoice,
    /// Depth that is taken off each point's, in scene units
    #[arg(long, value_name = "B", default_value = "0", allow_negative_numbers = true)]
    #[arg(value_parser = values::finite)]
    bias: f32,
    /// Print {points, rays, open_s, lookup_s} as a line of JSON on stderr
    #[arg(long)]
    stats: bool,
    #[command(flatten)]
    effort: Effort,
}

/// What the coordinates of points mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Space {
    World,
    Raster,
}

/// What `lookup` was asked.
#[derive(Debug)]
pub(crate) struct Lookup {
    pub(crate) map: PathBuf,
    pub(crate) points: PathBuf,
    pub(crate) space: Space,
    pub(crate) footprint: Footprint,
    pub(crate) level: LevelChoice,
    pub(crate) bias: f32,
    pub(crate) stats: bool,
    pub(crate) effort: Effort,
}

impl TryFrom<LookupFlags> for Lookup {
    type Error = String;

    fn try_from(flags: LookupFlags) -> Result<Self, String> {
        let LookupFlags { map, points, space, filter, width, level, bias, stats, effort } = flags;
        let footprint = filtering::footprint(filter, width)?;
        Ok(Self { map, points, space, footprint, level, bias, stats, effort })
    }
}
