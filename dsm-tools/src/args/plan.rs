//! The switches of `plan`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::RangedU64ValueParser;

use super::values;
use crate::plan::frames::{Frames, frames};

const EXAMPLES: &str = "\
Examples:
  dsm-tools plan a.toml -o plan.json --crops 16 -- --resolution 8192
  dsm-tools plan a.##.toml -o p.json --frames 1-9 --slurm s.sh -- --kind mtsm
  dsm-tools plan a.usd -o p.json --time 600 --openjd j.json -- --samples 64";

/// Plans bakes that a farm's own scheduler runs
///
/// Each SCENE, in each frame, becomes a map: a scene file has one light, so lights are scenes.
/// The plan says how maps are cut into parts and what each step takes, and is written as a
/// script for Slurm or a job template of Open Job Description besides. Their tasks call
/// `dsm-tools step`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PlanFlags {
    /// Scenes, as `bake` takes them, relative to the plan's folder
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<String>,
    /// The plan to write
    #[arg(short, long, value_name = "PLAN.json")]
    output: PathBuf,
    /// The frames of sequences: 1-100, 1-100:10 or 1,5,9
    #[arg(long, value_name = "FRAMES", value_parser = frames)]
    frames: Option<Frames>,
    /// The folder of the maps, relative to the plan's
    #[arg(long, value_name = "FOLDER", default_value = "maps")]
    maps: String,
    /// Parts of each map, of whole tiles [default: 1]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<u32>::new().range(1..))]
    #[arg(conflicts_with_all = ["memory", "time"])]
    crops: Option<u32>,
    /// As many parts that a bake of one takes no more memory: bytes, or with K, M or G
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    memory: Option<u64>,
    /// As many parts that a bake of one takes no longer, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = values::positive_length)]
    time: Option<f64>,
    /// Gives maps their smaller levels, of kind deep
    #[arg(long)]
    mip: bool,
    /// Threads of each task
    #[arg(long, value_name = "N", default_value = "1")]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    threads: usize,
    /// Tiles along a side of what is baked to find what bakes take; 0 for no trial
    #[arg(long, value_name = "N", default_value = "4")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(0..=64))]
    trial: u32,
    /// A script to write that submits the plan to Slurm
    #[arg(long, value_name = "SCRIPT")]
    slurm: Option<PathBuf>,
    /// A job template to write, of Open Job Description
    #[arg(long, value_name = "JOB.json")]
    openjd: Option<PathBuf>,
    /// What each `bake` is told, but for SCENE, -o, --crop, --frame and --threads
    #[arg(last = true, value_name = "BAKE")]
    bake: Vec<String>,
}

/// A checked `plan`.
#[derive(Debug)]
pub(crate) struct PlanRequest {
    pub(crate) scenes: Vec<String>,
    pub(crate) output: PathBuf,
    pub(crate) frames: Option<Vec<u32>>,
    pub(crate) maps: String,
    pub(crate) crops: Option<u32>,
    pub(crate) memory: Option<u64>,
    pub(crate) time: Option<f64>,
    pub(crate) mip: bool,
    pub(crate) threads: usize,
    pub(crate) trial: u32,
    pub(crate) slurm: Option<PathBuf>,
    pub(crate) openjd: Option<PathBuf>,
    pub(crate) bake: Vec<String>,
}

/// Switches of `bake` that the plan decides.
const OWN: [&str; 8] =
    ["--crop", "--frame", "--threads", "-o", "--output", "--mip", "--json", "--quiet"];

impl TryFrom<PlanFlags> for PlanRequest {
    type Error = String;

    fn try_from(flags: PlanFlags) -> Result<Self, String> {
        let PlanFlags { scenes, output, frames, maps, crops, memory, time, mip, .. } = flags;
        let PlanFlags { threads, trial, slurm, openjd, bake, .. } = flags;
        let own = |word: &&String| {
            let name = word.split('=').next().unwrap_or(word);
            OWN.contains(&name)
        };
        if let Some(word) = bake.iter().find(own) {
            return Err(format!("behind --: {word} is what the plan decides for each bake"));
        }
        if trial == 0 && (memory.is_some() || time.is_some()) {
            return Err("--memory and --time need a --trial".to_owned());
        }
        let frames = frames.map(|Frames(frames)| frames);
        Ok(Self {
            scenes,
            output,
            frames,
            maps,
            crops,
            memory,
            time,
            mip,
            threads,
            trial,
            slurm,
            openjd,
            bake,
        })
    }
}
