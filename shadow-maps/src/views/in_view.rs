//! A shadow ray as one of several views has it.

use dsm_trace::ShadowRay;

use super::interval::{self, Interval};
use super::trace::Walk;

/// A ray in one view.
#[derive(Debug)]
pub(super) struct InView {
    pub(super) view: usize,
    pub(super) ray: ShadowRay,
    /// The part within the raster, in w.
    pub(super) inside: Option<Interval>,
    /// Depths of the receiver and of the light.
    pub(super) ends: [f64; 2],
    /// The length in pixels within the raster.
    pub(super) length: f64,
}

impl InView {
    /// How far along the ray from the receiver to the light w is, from 0 to 1.
    pub(super) fn share(&self, w: f64) -> f64 {
        ((self.ends[0] - w.recip()) / (self.ends[0] - self.ends[1])).clamp(0.0, 1.0)
    }

    /// The inverse of [`Self::share`].
    fn w(&self, share: f64) -> f64 {
        (self.ends[0] + share * (self.ends[1] - self.ends[0])).max(0.0).recip()
    }
}

/// How long a ray is within the raster, in pixels, up to the depth 1 / `nearest`: nearer to
/// the light the view shows nothing.
pub(super) fn length(ray: &ShadowRay, inside: Option<Interval>, nearest: f64) -> f64 {
    let Some([from, to]) = inside else { return 0.0 };
    let [a, b] = [from, to.min(nearest).max(from)].map(|w| ray.at(w));
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Traces a part of a ray; adds to `left` what the view does not see of it.
pub(super) fn trace_part(
    ray: &InView,
    part: Interval,
    walk: &mut Walk<'_>,
    (hidden, left): (&mut Vec<Interval>, &mut Vec<Interval>),
) -> bool {
    let Some(inside) = ray.inside else {
        interval::push(left, part);
        return false;
    };
    let [from, to] = part.map(|share| ray.w(share));
    let range = [from.max(inside[0]), to.min(inside[1])];
    if range[0] < range[1] && walk.run(&ray.ray.between(range)).is_break() {
        return true;
    }
    // What comes before the start is not the ray's, what lies outside is unknown.
    let [start, end] = ray.ray.range();
    hidden.clear();
    interval::push(hidden, [from.max(start), to.min(inside[0])]);
    walk.behind.iter().for_each(|&behind| interval::push(hidden, behind));
    interval::push(hidden, [from.max(inside[1]), to.min(end)]);
    for &[from, to] in hidden.iter() {
        interval::push(left, [ray.share(from).max(part[0]), ray.share(to).min(part[1])]);
    }
    false
}
