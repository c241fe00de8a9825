//! Measures coherent sampling: `coherence OUT [FOLDER…] [--every N] [--small]` writes
//! `results/coherence.md` and its picture in the folder OUT. Of scenes of other programs, each a
//! folder, every Nth point is asked.

use anyhow::Result;
use dsm_experiments::arguments::Arguments;
use dsm_experiments::coherence::{Effort, page};

fn main() -> Result<()> {
    // This thread alone, so that its time is all there is.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let Arguments { output, compared, is_small } = Arguments::of("coherence")?;
    let effort = if is_small { Effort::small() } else { Effort::full() };
    page(&effort, &compared)?.write(&output)
}
