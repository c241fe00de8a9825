//! What the steps of a plan take, found by small bakes from the middle of a map, each in a
//! process of its own: memory at its peak is that of a process.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use super::cost::{Cost, Costs, round_up};
use super::job::{Plan, PlannedMap};

/// Bytes of a stored map that are copied in a second, at the least.
const COPY_RATE: f64 = 100e6;
/// Memory of a merge beside 64 bytes a tile and the files' own pages.
const MERGE_BASE: f64 = 64e6;
/// Seconds to start a program on a farm's file system.
const START: f64 = 1.0;

/// What a small bake told of itself.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Told {
    scene_s: f64,
    bake_s: f64,
    bytes: u64,
    peak_bytes: Option<u64>,
}

/// A trial: what one tile, and what a block of tiles took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial {
    one: Told,
    block: Told,
    tiles: u64,
    /// Seconds and bytes of the smaller levels of the block.
    mip: Option<(f64, u64)>,
    verify_s: f64,
}

impl Trial {
    /// Bakes the tile in the middle of a map, and a block of up to `side` × `side` tiles around
    /// it, with the plan's own switches.
    pub(crate) fn run(plan: &Plan, map: &PlannedMap, side: u32) -> Result<Self> {
        let folder = tempfile::tempdir().context("cannot make a folder for a trial")?;
        let path = |name: &str| folder.path().join(name);
        let (first, _) = middle(plan, 1);
        let one = bake(plan, map, first, &path("one.dsm"))?;
        let (edges, tiles) = middle(plan, side);
        let block = bake(plan, map, edges, &path("block.dsm"))?;
        let mip = if plan.mip {
            // Levels are of whole maps: of one as large as the block.
            let small = small(plan, edges);
            let whole = [0, 0, small.resolution[0], small.resolution[1]];
            bake(&small, map, whole, &path("small.dsm"))?;
            Some(mip(plan, &path("small.dsm"), &path("mip.dsm"))?)
        } else {
            None
        };
        let started = Instant::now();
        super::found::verify(&path("block.dsm"))?;
        Ok(Self { one, block, tiles, mip, verify_s: started.elapsed().as_secs_f64() })
    }

    /// Seconds of a bake of so many tiles.
    fn seconds(&self, tiles: u64) -> f64 {
        self.block.scene_s + START + self.a_tile() * tiles as f64
    }

    fn a_tile(&self) -> f64 {
        self.block.bake_s / self.tiles as f64
    }

    /// Bytes that each tile adds to a process.
    fn memory_slope(&self) -> f64 {
        let (one, block) = (self.one.peak_bytes.unwrap_or(0), self.block.peak_bytes.unwrap_or(0));
        block.saturating_sub(one) as f64 / self.tiles.saturating_sub(1).max(1) as f64
    }

    /// Memory of a bake of so many tiles. `is_flat` says that all that is held of a map is a few
    /// tiles a thread, and 64 bytes of each other.
    fn memory(&self, tiles: u64, is_flat: bool) -> f64 {
        let slope = if is_flat { 64.0 } else { self.memory_slope() };
        let more = tiles.saturating_sub(self.tiles) as f64 * slope;
        self.block.peak_bytes.unwrap_or(0) as f64 + more
    }

    /// The tiles of a part that takes no more than this; at least one.
    ///
    /// # Errors
    ///
    /// If one tile takes more.
    pub(crate) fn tiles_within(
        &self,
        memory: Option<u64>,
        seconds: Option<f64>,
        is_flat: bool,
    ) -> Result<u64> {
        let mut most = u64::MAX;
        if let Some(seconds) = seconds {
            let least = self.seconds(1);
            if seconds < least {
                bail!("--time: one tile takes {least:.1} s with the scene that it is in");
            }
            most = ((seconds - self.seconds(0)) / self.a_tile().max(1e-9)) as u64;
        }
        if let Some(memory) = memory {
            let one = self.one.peak_bytes.context("--memory: this system does not tell memory")?;
            if memory < one {
                bail!(
                    "--memory: a bake of one tile takes {one} bytes, of which most is the scene: \
                     fewer --threads take less"
                );
            }
            let slope = if is_flat { 64.0 } else { self.memory_slope() };
            most = most.min(1 + ((memory - one) as f64 / slope.max(1.0)) as u64);
        }
        Ok(most.max(1))
    }

    /// What the plan's steps take, of parts of up to `part` tiles and maps of `map`.
    pub(crate) fn costs(&self, part: u64, map: u64, is_flat: bool) -> Costs {
        let cost = |memory: f64, seconds: f64| Cost {
            memory: round_up(memory),
            seconds: round_up(seconds),
        };
        let share = map as f64 / self.tiles as f64;
        let bytes = self.block.bytes as f64 * share;
        let of_tiles = 64.0 * map as f64;
        let merge = cost(MERGE_BASE + 2.0 * of_tiles, START + bytes / COPY_RATE);
        let mip = self
            .mip
            .map(|(seconds, memory)| cost(memory as f64 + 2.0 * of_tiles, START + seconds * share));
        let verify = cost(MERGE_BASE + of_tiles, START + self.verify_s * share);
        let bake = cost(self.memory(part, is_flat), self.seconds(part));
        Costs { bake, merge, mip, verify }
    }
}

/// The plan of maps of the size of a part.
fn small(plan: &Plan, [left, top, right, bottom]: [u32; 4]) -> Plan {
    let resolution = [right - left, bottom - top];
    let mut bake = Vec::new();
    let mut words = plan.bake.iter();
    while let Some(word) = words.next() {
        match word.split_once('=') {
            Some(("--resolution", _)) => {}
            _ if word == "--resolution" => drop(words.next()),
            _ => bake.push(word.clone()),
        }
    }
    bake.extend(["--resolution".to_owned(), format!("{}x{}", resolution[0], resolution[1])]);
    Plan { resolution, bake, ..plan.clone() }
}

/// The edges of up to `side` × `side` tiles in the middle of the map, and how many they are.
fn middle(plan: &Plan, side: u32) -> ([u32; 4], u64) {
    let axis = |axis: usize| {
        let tiles = plan.resolution[axis].div_ceil(plan.tile);
        let count = side.min(tiles);
        let first = (tiles - count) / 2;
        let edge = |tile: u32| tile.saturating_mul(plan.tile).min(plan.resolution[axis]);
        (edge(first), edge(first + count), count)
    };
    let ((left, right, columns), (top, bottom, rows)) = (axis(0), axis(1));
    ([left, top, right, bottom], u64::from(columns) * u64::from(rows))
}

/// Runs this program, and gives what it prints.
fn run(arguments: impl IntoIterator<Item = OsString>) -> Result<Vec<u8>> {
    let program = std::env::current_exe().context("cannot find this program")?;
    let run = Command::new(program).args(arguments).stdin(Stdio::null()).output();
    let run = run.context("cannot start a trial")?;
    if run.status.success() {
        return Ok(run.stdout);
    }
    let said = String::from_utf8_lossy(&run.stderr);
    let said = said.trim().lines().last().unwrap_or("it was killed");
    bail!("a trial failed: {}", said.trim_start_matches("error: "))
}

fn bake(plan: &Plan, map: &PlannedMap, edges: [u32; 4], output: &Path) -> Result<Told> {
    let whole = [0, 0, plan.resolution[0], plan.resolution[1]];
    let crop = (edges != whole).then_some(edges);
    let mut arguments = super::job::bake_arguments(plan, map, crop, output);
    arguments.push("--json".into());
    let told = run(arguments.into_iter().skip(1))?;
    serde_json::from_slice(&told).context("a trial told nothing")
}

/// Seconds, and bytes of memory at the peak.
fn mip(plan: &Plan, input: &Path, output: &Path) -> Result<(f64, u64)> {
    #[derive(Deserialize)]
    struct Peak {
        peak_bytes: Option<u64>,
    }
    let started = Instant::now();
    let threads = plan.threads.to_string();
    let told = run([
        "mip".into(),
        input.as_os_str().to_owned(),
        "-o".into(),
        output.as_os_str().to_owned(),
        "--threads".into(),
        threads.into(),
        "--json".into(),
        "--quiet".into(),
    ])?;
    let seconds = started.elapsed().as_secs_f64();
    let told: Peak = serde_json::from_slice(&told).context("a trial told nothing")?;
    Ok((seconds, told.peak_bytes.unwrap_or(0)))
}
