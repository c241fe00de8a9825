//! Measures figures of Lokovic & Veach 2000 and writes a page and a plot of
//! each: `paper-figures 7|8|9|all [FOLDER]`, by default into `docs/results`.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use dsm_experiments::figures::{Bakes, Effort, Figure7, Figure8, Figure9, Report, Stage};

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let which = arguments.next().unwrap_or_default();
    let folder = arguments.next().map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/results")),
        PathBuf::from,
    );
    let figures: &[u32] = match which.as_str() {
        "7" => &[7],
        "8" => &[8],
        "9" => &[9],
        "all" => &[7, 8, 9],
        _ => bail!("usage: paper-figures 7|8|9|all [FOLDER]"),
    };
    let start = Instant::now();
    let stage = Stage::new(Effort::full())?;
    let mut bakes = Bakes::new()?;
    for figure in figures {
        let report: Report = match figure {
            7 => Figure7::measure(&stage, &mut bakes)?.report()?,
            8 => Figure8::measure(&stage, &mut bakes)?.report()?,
            _ => Figure9::measure(&stage, &mut bakes)?.report()?,
        };
        report.write(&folder)?;
        let seconds = start.elapsed().as_secs_f64();
        writeln!(std::io::stderr(), "figure {figure}: {seconds:.0} s in")?;
    }
    Ok(())
}
