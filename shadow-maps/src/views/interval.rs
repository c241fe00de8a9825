//! Stretches of a shadow ray.

/// A stretch from `start` to `end`, of whatever a ray is measured in.
pub(super) type Interval = [f64; 2];

/// Adds a stretch that follows all that are there; those that touch become one.
pub(super) fn push(all: &mut Vec<Interval>, [start, end]: Interval) {
    if start >= end {
        return;
    }
    match all.last_mut() {
        Some(last) if start <= last[1] => last[1] = last[1].max(end),
        _ => all.push([start, end]),
    }
}
