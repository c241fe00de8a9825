//! A plan as a job template of Open Job Description, the form of render farms' managers.

use serde_json::{Value, json};

use super::job::{Plan, Step};

/// Times that a task may take what the trial took.
const SLACK: u64 = 3;

/// The template of a plan of this name, which lies in its own folder.
pub(crate) fn template(plan: &Plan, name: &str) -> Value {
    let mut before: Option<&str> = None;
    let mut steps = Vec::new();
    for step in plan.steps() {
        steps.push(step_of(plan, step, before));
        before = Some(step.name());
    }
    json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": format!("dsm-tools, {} maps of {}", plan.maps.len(), plan.kind),
        "parameterDefinitions": [
            {
                "name": "Plan",
                "type": "PATH",
                "objectType": "FILE",
                "dataFlow": "IN",
                "default": name,
                "description": "The plan; maps are written beside it",
            },
            {
                "name": "Program",
                "type": "STRING",
                "default": "dsm-tools",
                "description": "dsm-tools, by its name or path",
            },
        ],
        "steps": steps,
    })
}

fn step_of(plan: &Plan, step: Step, before: Option<&str>) -> Value {
    let last = plan.task_count(step).unwrap_or(1).saturating_sub(1);
    let threads = if step == Step::Verify { 1 } else { plan.threads };
    let mut run = json!({
        "command": "{{Param.Program}}",
        "args": ["step", "{{Param.Plan}}", step.name(), "{{Task.Param.Index}}"],
    });
    let mut amounts = vec![json!({ "name": "amount.worker.vcpu", "min": threads })];
    if let Some(cost) = plan.cost.and_then(|costs| costs.of(step)) {
        run["timeout"] = json!((cost.seconds * SLACK).max(60));
        let mib = cost.memory.div_ceil(1 << 20).max(1) * 5 / 4;
        amounts.push(json!({ "name": "amount.worker.memory", "min": mib }));
    }
    let mut value = json!({
        "name": step.name(),
        "parameterSpace": {
            "taskParameterDefinitions": [
                { "name": "Index", "type": "INT", "range": format!("0-{last}") },
            ],
        },
        "hostRequirements": { "amounts": amounts },
        "script": { "actions": { "onRun": run } },
    });
    if let Some(before) = before {
        value["dependencies"] = json!([{ "dependsOn": before }]);
    }
    value
}
