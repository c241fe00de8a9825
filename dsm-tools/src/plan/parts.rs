//! The files that a merge is given, held to what a plan expects.

use std::path::PathBuf;

use anyhow::{Result, bail};

use super::found::FoundPart;
use super::job::{Plan, PlannedMap};

/// Names of files or parts that a message shows before it only counts.
const SHOWN: usize = 8;

/// The map of the plan that most of these files are parts of, or that is asked for by its
/// output's name.
pub(crate) fn expected_map<'a>(
    plan: &'a Plan,
    output: &str,
    found: &[(PathBuf, FoundPart)],
) -> &'a PlannedMap {
    let of = |map: &PlannedMap| {
        let own = found.iter().filter(|(_, part)| part.foreign(plan, map).is_none()).count();
        (own, map.output == output)
    };
    // The first of those that fit best.
    let best = plan.maps.iter().rev().max_by_key(|map| of(map));
    best.unwrap_or(&plan.maps[0])
}

/// Refuses files that are not the parts of a map of the plan, each once, and names those that
/// are missing, doubled or foreign.
pub(crate) fn check(plan: &Plan, map: &PlannedMap, found: &[(PathBuf, FoundPart)]) -> Result<()> {
    let mut holders: Vec<Vec<&PathBuf>> = vec![Vec::new(); plan.parts.len()];
    let mut foreign = Vec::new();
    for (path, part) in found {
        match (part.foreign(plan, map), part.part(plan)) {
            (None, Some(index)) => holders[index].push(path),
            (reason, _) => {
                let reason = reason.unwrap_or_default();
                foreign.push(format!("{} {reason}", path.display()));
            }
        }
    }
    let name = |index: usize| {
        let [left, top, right, bottom] = plan.parts[index];
        format!("{}/{} ({left},{top},{right},{bottom})", index + 1, plan.parts.len())
    };
    let indices = || (0..holders.len()).zip(&holders);
    let missing: Vec<_> =
        indices().filter(|(_, held)| held.is_empty()).map(|(index, _)| name(index)).collect();
    let doubled: Vec<_> = indices()
        .filter(|(_, held)| held.len() > 1)
        .map(|(index, held)| {
            let held: Vec<_> = held.iter().map(|path| path.display().to_string()).collect();
            format!("{} in {}", name(index), held.join(" and "))
        })
        .collect();
    let kinds = [("missing", missing), ("doubled", doubled), ("foreign", foreign)];
    let wrong: Vec<_> = kinds
        .into_iter()
        .filter(|(_, all)| !all.is_empty())
        .map(|(kind, all)| format!("{kind}: {}", listed(&all)))
        .collect();
    if wrong.is_empty() {
        return Ok(());
    }
    bail!("not the parts of {}: {}", map.title(), wrong.join("; "))
}

fn listed(all: &[String]) -> String {
    let shown = all[..all.len().min(SHOWN)].join(", ");
    match all.len() - all.len().min(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
