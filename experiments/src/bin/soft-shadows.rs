//! Repeats the experiments of Xie, Tabellion & Pearce 2007:
//! `soft-shadows table-1|table-2|table-3|figure-2|figure-4|cost|all [FOLDER]`, by default into `docs`.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use dsm_experiments::soft_shadows::{
    Cost, Effort, Figure4, Study, Table1, Table2, Table3, figure_2,
};

/// What can be asked for, in the order of `all`.
const EXPERIMENTS: [&str; 6] = ["table-1", "table-2", "table-3", "figure-4", "figure-2", "cost"];

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let which = arguments.next().unwrap_or_default();
    let folder = arguments.next().map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs")),
        PathBuf::from,
    );
    let asked = EXPERIMENTS.iter().filter(|&&name| which == "all" || which == name);
    let asked: Vec<_> = asked.collect();
    if asked.is_empty() {
        bail!("usage: soft-shadows {}|all [FOLDER]", EXPERIMENTS.join("|"));
    }
    let start = Instant::now();
    let mut study = Study::new(Effort::full())?;
    if !study.stages.iter().any(|stage| stage.name == "head") {
        writeln!(std::io::stderr(), "SKIPPED: the models of head are not there")?;
    }
    for &name in asked {
        let page = match name {
            "table-1" => Table1::measure(&mut study)?.page(),
            "table-2" => Table2::measure(&mut study)?.page(),
            "table-3" => Table3::measure(&mut study)?.page(),
            "figure-2" => figure_2(&mut study)?.1,
            "cost" => Cost::measure(&mut study)?.page()?,
            _ => Figure4::measure(&mut study)?.page()?,
        };
        page.write(&folder)?;
        writeln!(std::io::stderr(), "{name}: {:.0} s in", start.elapsed().as_secs_f64())?;
    }
    Ok(())
}
