//! The switches of `step`.

use std::path::PathBuf;

use clap::Args;

use crate::plan::job::Step;

const EXAMPLES: &str = "\
Examples:
  dsm-tools step plan.json bake 17
  dsm-tools step plan.json merge 0
  dsm-tools step plan.json";

/// Does one task of a plan, or all of them
///
/// What is there and sound is not made again. Paths of the plan are relative to its folder.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct StepFlags {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// The step [default: all of them]
    #[arg(value_name = "STEP", value_enum)]
    step: Option<Step>,
    /// The task of the step, from 0 [default: all of them]
    #[arg(value_name = "INDEX")]
    index: Option<u32>,
    /// Print nothing
    #[arg(long)]
    quiet: bool,
}

/// A checked `step`.
#[derive(Debug)]
pub(crate) struct StepRequest {
    pub(crate) plan: PathBuf,
    pub(crate) step: Option<Step>,
    pub(crate) index: Option<u32>,
    pub(crate) quiet: bool,
}

impl From<StepFlags> for StepRequest {
    fn from(flags: StepFlags) -> Self {
        let StepFlags { plan, step, index, quiet } = flags;
        Self { plan, step, index, quiet }
    }
}
