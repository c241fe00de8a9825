//! A shadow ray through one depth image (Agrawala et al. 2000, §5.1.1, `Trace`).

use std::ops::ControlFlow;

use dsm_trace::ShadowRay;

use super::depth_view::DepthView;
use super::interval::{self, Interval};
use super::options::TraceOptions;

/// A walk along a ray.
pub(super) struct Walk<'a> {
    view: &'a DepthView,
    options: TraceOptions,
    /// The nearer column and row of each four.
    near: [u32; 2],
    /// Where the ray passes behind what the view sees, in w.
    pub(super) behind: &'a mut Vec<Interval>,
    /// Pixels and nodes that were looked at.
    pub(super) steps: u64,
    /// Where the ray is blocked, in w, if that is by a single pixel.
    pub(super) met: Option<f64>,
}

/// That the ray is blocked, or may go on.
pub(super) type Outcome = ControlFlow<()>;

const ON: Outcome = ControlFlow::Continue(());
const BLOCKED: Outcome = ControlFlow::Break(());

impl<'a> Walk<'a> {
    /// A walk that writes into `behind`, which it empties.
    pub(super) fn new(
        view: &'a DepthView,
        options: TraceOptions,
        behind: &'a mut Vec<Interval>,
    ) -> Self {
        behind.clear();
        Self { view, options, near: [0; 2], behind, steps: 0, met: None }
    }

    /// Walks a ray that lies within the raster.
    pub(super) fn run(&mut self, ray: &ShadowRay) -> Outcome {
        if !ray.is_sound() {
            return ON;
        }
        if !self.options.hierarchy {
            return self.step_by_step(ray);
        }
        self.near = ray.slope().map(|slope| u32::from(slope < 0.0));
        self.visit(ray, self.view.ranges.level_count() - 1, [0; 2])
    }

    fn visit(&mut self, ray: &ShadowRay, level: usize, node: [u32; 2]) -> Outcome {
        let size = self.view.frame().size();
        let min = node.map(|at| at << level);
        let max = [0, 1].map(|axis| (min[axis] + (1 << level)).min(size[axis]));
        let Some([enter, leave]) = ray.crossing(min, max) else { return ON };
        self.steps += 1;
        let Some(range) = self.view.ranges.node(level, node[0], node[1]) else { return ON };
        let [low, high] = range.map(f64::from);
        if high < enter {
            return ON;
        }
        if leave < low {
            interval::push(self.behind, [enter, leave]);
            return ON;
        }
        if level == 0 {
            return self.pixel(ray, node, [enter, leave]);
        }
        let is_through = enter <= low && high < leave;
        if self.options.connectedness
            && is_through
            && self.view.connected.node(level, node[0], node[1])
        {
            return BLOCKED;
        }
        let mut cut = *ray;
        if self.options.clipping {
            interval::push(self.behind, [enter, low.min(leave)]);
            // By depth alone, so that walls on the border of the node stay, and with what is
            // as near as the nearest.
            cut = ray.between([low, high.next_up()]);
        }
        // A line crosses one of the two in the middle at most.
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let below = [2 * node[0] + (self.near[0] ^ dx), 2 * node[1] + (self.near[1] ^ dy)];
            self.visit(&cut, level - 1, below)?;
        }
        ON
    }

    /// The floor of a pixel, and the wall where the ray leaves it.
    fn pixel(&mut self, ray: &ShadowRay, pixel: [u32; 2], [enter, leave]: Interval) -> Outcome {
        let own = f64::from(self.view.at(pixel));
        if enter <= own && own < leave {
            self.met = Some(own);
            return BLOCKED;
        }
        let is_behind = own >= leave;
        if is_behind {
            interval::push(self.behind, [enter, leave]);
        }
        let Some(next) = self.next(ray, pixel, leave) else { return ON };
        let other = f64::from(self.view.at(next));
        if (other >= leave) != is_behind && self.view.is_wall(pixel, next) {
            self.met = Some(leave);
            return BLOCKED;
        }
        ON
    }

    /// The pixel that a ray enters where it leaves another; none at its end or that of the
    /// raster.
    fn next(&self, ray: &ShadowRay, [x, y]: [u32; 2], leave: f64) -> Option<[u32; 2]> {
        let size = self.view.frame().size();
        let slope = ray.slope();
        let moved = |at: u32, axis: usize| {
            let next = if slope[axis] < 0.0 { at.checked_sub(1) } else { at.checked_add(1) };
            next.filter(|&next| next < size[axis])
        };
        let (across, down) = (moved(x, 0), moved(y, 1));
        let candidates =
            [across.map(|x| [x, y]), down.map(|y| [x, y]), across.zip(down).map(|(x, y)| [x, y])];
        candidates.into_iter().flatten().find(|&pixel| {
            ray.crossing(pixel, pixel.map(|at| at + 1)).is_some_and(|[enter, _]| enter == leave)
        })
    }

    /// From pixel to pixel, without the quadtrees.
    fn step_by_step(&mut self, ray: &ShadowRay) -> Outcome {
        let size = self.view.frame().size();
        let [start, end] = ray.range();
        let at = ray.at(start);
        // The first is the one that holds the start, or by rounding one beside it.
        let first =
            [0, 1].map(|axis| at[axis].floor().clamp(0.0, f64::from(size[axis] - 1)) as u32);
        let around = |axis: usize| first[axis].saturating_sub(1)..(first[axis] + 2).min(size[axis]);
        let found = around(1).flat_map(|y| around(0).map(move |x| [x, y])).find_map(|pixel| {
            let crossing = ray.crossing(pixel, pixel.map(|at| at + 1))?;
            (crossing[0] == start).then_some((pixel, crossing))
        });
        let Some((mut pixel, mut crossing)) = found else { return ON };
        loop {
            self.steps += 1;
            self.pixel(ray, pixel, crossing)?;
            let next = self.next(ray, pixel, crossing[1]).filter(|_| crossing[1] < end);
            let Some(next) = next else { return ON };
            let Some(entered) = ray.crossing(next, next.map(|at| at + 1)) else { return ON };
            (pixel, crossing) = (next, entered);
        }
    }
}
