//! Draws pictures after figures of Lokovic & Veach 2000, and compares rendered
//! shadows with traced ones: `pictures 6|10|11|12|strips|comparison|all [FOLDER]`.
//! Pictures go into `images` of the folder, by default `docs`, tables into
//! `results`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use dsm_experiments::pictures::{Comparison, STRIPS, strip};
use dsm_scene::detail::Image;

/// Parts of strips are so many times as high as the smallest.
const SCALE: u32 = 10;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let which = arguments.next().unwrap_or_default();
    let folder = arguments.next().map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs")),
        PathBuf::from,
    );
    let number = which.parse::<u32>().ok().filter(|number| STRIPS.contains(number));
    let (strips, comparison): (&[u32], bool) = match (which.as_str(), &number) {
        (_, Some(number)) => (std::slice::from_ref(number), false),
        ("strips", _) => (&STRIPS, false),
        ("comparison", _) => (&[], true),
        ("all", _) => (&STRIPS, true),
        _ => bail!("usage: pictures 6|10|11|12|strips|comparison|all [FOLDER]"),
    };
    let images = folder.join("images");
    for &number in strips {
        let started = Instant::now();
        let image = strip(number, SCALE)?;
        write_png(&images.join(format!("figure-{number}.png")), &image)?;
        let seconds = started.elapsed().as_secs_f64();
        writeln!(std::io::stderr(), "figure {number}: {seconds:.0} s")?;
    }
    if comparison {
        let (page, differences) = Comparison::full().page()?;
        write_png(&images.join("render-differences.png"), &differences)?;
        write(&folder.join("results/render.md"), page.as_bytes())?;
    }
    Ok(())
}

fn write_png(path: &Path, image: &Image) -> Result<()> {
    write(path, &image.to_png()?)
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
