//! Measures attenuation maps and several traced views: `attenuation OUT [FOLDER…] [--every N]
//! [--small]` writes `results/attenuation.md` and its pictures in the folder OUT. Of scenes of
//! other programs, each a folder, every Nth point is asked.

use anyhow::Result;
use dsm_experiments::arguments::Arguments;
use dsm_experiments::attenuation::{Effort, page};

fn main() -> Result<()> {
    let Arguments { output, compared, is_small } = Arguments::of("attenuation")?;
    let effort = if is_small { Effort::small() } else { Effort::full() };
    page(&effort, &compared)?.write(&output)
}
