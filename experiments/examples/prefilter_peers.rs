//! Looks up a prefiltered map of a scene, compares the shadow factors with a reference,
//! and tells how fast it was.
//!
//! ```text
//! cargo run --release -p dsm-experiments --example prefilter_peers -- FOLDER REFERENCE
//!     [--resolution N] [--layers N] [--widths E] [--interval S] [--accumulate add|multiply|max]
//!     [--mip] [--stack N] [--max-level N] [--mean-depth] [--bias B] [--splits N] [--normals]
//!     [--hybrid RAYS] [--reach TEXELS] [--light SCALE] [--every N] [--runs N] [--paper]
//! ```

#![expect(clippy::print_stdout, reason = "it prints what it measured")]

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use dsm_experiments::prefilter::peer::PeerScene;
use dsm_experiments::prefilter::run::{Setup, run};
use shadow_maps::detail::{Accumulate, Epsilon, MergedDepth, PrefilterSettings};

fn main() -> Result<()> {
    let mut setup = Setup::default();
    let (mut every, mut runs, mut light) = (1, 1, 1.0);
    let mut names = Vec::new();
    let mut reach = 2.0;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut text = || arguments.next().context("a value is missing");
        match argument.as_str() {
            "--resolution" => setup.resolution = text()?.parse()?,
            "--layers" => setup.layers = Some(text()?.parse()?),
            "--widths" => setup.filtering.epsilon = Epsilon::Widths(text()?.parse()?),
            "--interval" => setup.filtering.epsilon = Epsilon::Interval(text()?.parse()?),
            "--accumulate" => {
                let mode = Accumulate::named(&text()?).context("no such mode")?;
                setup.accumulate = mode;
                setup.filtering.accumulate = mode;
            }
            "--mip" => setup.filtering.stack_size = None,
            "--stack" => setup.filtering.stack_size = Some(text()?.parse()?),
            "--max-level" => setup.filtering.max_level = Some(text()?.parse()?),
            "--mean-depth" => setup.filtering.depth = MergedDepth::Mean,
            "--paper" => {
                setup.filtering = PrefilterSettings::paper();
                setup.accumulate = Accumulate::Add;
            }
            "--bias" => setup.bias = Some(text()?.parse()?),
            "--splits" => setup.splits = text()?.parse()?,
            "--normals" => setup.normals = true,
            "--hybrid" => setup.hybrid = Some((text()?.parse()?, reach)),
            "--reach" => reach = text()?.parse()?,
            "--light" => light = text()?.parse()?,
            "--every" => every = text()?.parse()?,
            "--runs" => runs = text()?.parse()?,
            _ => names.push(argument),
        }
    }
    let [folder, reference]: [String; 2] =
        names.try_into().map_err(|_| anyhow!("FOLDER REFERENCE"))?;
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    setup.hybrid = setup.hybrid.map(|(rays, _)| (rays, reach));
    let mut peer = PeerScene::open(Path::new(&folder), &reference, every)?;
    if light != 1.0 {
        peer = peer.with_light(light, 1024)?;
    }
    let found = run(&peer, &setup, runs)?;
    let [ground, object, all] = found.differences;
    println!(
        "{}: RMSE ground {:.4} object {:.4} all {:.4}, mean {:+.4}; {:.2} + {:.2} us; build {:.2?} s; \
         fragments {:?}",
        peer.name,
        ground.rmse,
        object.rmse,
        all.rmse,
        all.mean,
        found.micros[0],
        found.micros[1],
        found.seconds,
        found.fragments
    );
    Ok(())
}
