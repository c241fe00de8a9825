//! A map baked in crops, as machines of a farm do, and put together again: the same
//! bytes as one bake.
//!
//! `cargo run -p deepshadow --example crop_farm`

#![expect(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::fs;
use std::ops::ControlFlow;

use deepshadow::files::{Limits, MapReader, merge};
use deepshadow::scene::builtin_scene;
use deepshadow::visibility::Progress;
use deepshadow::{Bake, ShadowMap, bake};

/// Width and height of the map and of a tile, in pixels; crops end at tiles.
const SIZE: u32 = 192;
const TILE: u32 = 64;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = builtin_scene("spinning-sphere")?;
    let folder = tempfile::tempdir()?;
    let at = |name: &str| folder.path().join(name);
    let mut settings = Bake::new([SIZE, SIZE])?;
    settings.tile_size = TILE;
    let go_on = |_| ControlFlow::Continue(());

    // Each would run on a machine of its own.
    let mut parts = Vec::new();
    for (number, left) in (0..SIZE).step_by(TILE as usize).enumerate() {
        let mut part = settings.clone();
        part.crop = Some([left, 0, left + TILE, SIZE]);
        let path = at(&format!("part-{number}.dsm"));
        bake(&scene, &scene.light, &part, &path, go_on)?;
        parts.push(MapReader::open(&path, &Limits::default())?);
    }
    merge(&parts, &at("merged.dsm"), None, Progress::ignore)?;

    bake(&scene, &scene.light, &settings, &at("whole.dsm"), go_on)?;
    let same = fs::read(at("merged.dsm"))? == fs::read(at("whole.dsm"))?;
    println!("{} crops, the same bytes as one bake: {same}", parts.len());
    assert!(same && ShadowMap::open(at("merged.dsm"))?.verify().is_empty());
    Ok(())
}
