//! A plan as a script that submits it to Slurm.

use std::fmt::Write;

use super::cost::Cost;
use super::job::{Plan, Step};

/// Tasks of one array: sites allow 1001 unless they say otherwise (`MaxArraySize`).
const ARRAY: u32 = 1000;
/// Times that a task may take what the trial took, on slower nodes and fuller parts.
const SLACK: u64 = 3;

const HEAD: &str = r#"#!/usr/bin/env bash
# Submits a plan of bakes to Slurm. Arguments go to each sbatch, as --partition does.
#
# Run it again after whatever went wrong: what is there and sound is not made again. That is
# better than `scontrol requeue`, which starts all elements of an array again. Steps wait for
# the end of those before them, well or not, and look for themselves whether all is there: a
# dependency on a job that the controller has forgotten counts as met. DSM_TOOLS names the
# program, DSM_AFTER jobs to wait for (numbers with colons).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
program=${DSM_TOOLS:-dsm-tools}
"#;

const SUBMIT: &str = r#"
after=${DSM_AFTER:+--dependency=afterany:$DSM_AFTER}
# step, number of tasks, tasks of an array, switches of sbatch
submit() {
    local step=$1 count=$2 size=$3 jobs= first last job
    shift 3
    for ((first = 0; first < count; first += size)); do
        last=$((first + size < count ? size - 1 : count - first - 1))
        job=$(sbatch --parsable --requeue --job-name="dsm-$step" --array="0-$last" $after "$@" <<JOB
#!/usr/bin/env bash
exec $(printf %q "$program") step $(printf %q "$plan") $step \$(($first + SLURM_ARRAY_TASK_ID))
JOB
        )
        jobs=$jobs:${job%%;*}
    done
    after=--dependency=afterany$jobs
    echo "$step: ${jobs#:}"
}
"#;

/// The script that submits a plan of this name, which lies in its own folder.
pub(crate) fn script(plan: &Plan, name: &str) -> String {
    let mut script = HEAD.to_owned();
    script += &format!("plan={}\n", quoted(name));
    script += SUBMIT;
    script.push('\n');
    for step in plan.steps() {
        let count = plan.task_count(step).unwrap_or(0);
        let threads = if step == Step::Verify { 1 } else { plan.threads };
        let mut line = format!("submit {} {count} {ARRAY} --cpus-per-task={threads}", step.name());
        if let Some(Cost { memory, seconds }) = plan.cost.and_then(|costs| costs.of(step)) {
            let mib = memory.div_ceil(1 << 20).max(1) * 5 / 4;
            let minutes = (seconds * SLACK).div_ceil(60).max(1);
            // Strings take any text.
            let _ = write!(line, " --mem={mib}M --time={minutes}");
        }
        script += &line;
        script += " \"$@\"\n";
    }
    script
}

/// A word of a shell, whatever it holds.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_shell_are_quoted() {
        assert_eq!(quoted("it's a plan.json"), r"'it'\''s a plan.json'");
    }
}
