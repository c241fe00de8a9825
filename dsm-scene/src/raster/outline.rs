//! Outlines of primitives in the map.

use super::cells::CellArea;
use super::corner::Corner;
use super::rays::Rays;

/// Beyond so many pixels from the map's corner, `f32` can't place an outline.
const MAX_DISTANCE: f64 = 1e6;

/// Something that covers rows of cells.
pub(super) trait Rows: Copy + Send + Sync {
    /// Hands to `sink` a row and a half-open range of columns for every row of
    /// `area` in which the outline touches cells: all that it touches, few
    /// others. O(rows).
    fn for_rows(&self, area: &CellArea, sink: impl FnMut(i32, i32, i32));

    /// The corners of a box around the outline, in pixels; `None` if it isn't
    /// known where it is.
    fn bounds(&self) -> Option<[[f32; 2]; 2]>;
}

/// The convex hull of ellipses around `CORNERS` corners at each of `KEYS` times,
/// in pixels. What moves linearly in space stays in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline<const KEYS: usize, const CORNERS: usize> {
    corners: [[[f32; 2]; CORNERS]; KEYS],
    /// Half axes of the ellipses. Infinite: the outline isn't known.
    reach: [f32; 2],
}

impl<const KEYS: usize, const CORNERS: usize> Outline<KEYS, CORNERS> {
    /// The outline of these corners. `None` if all lie behind the camera, or
    /// one is not finite.
    pub(super) fn project(rays: &Rays, corners: &[[Corner; CORNERS]; KEYS]) -> Option<Self> {
        let all = corners.as_flattened();
        if !all.iter().all(Corner::is_finite)
            || all.iter().all(|corner| corner.depth <= -corner.radius)
        {
            return None;
        }
        let mut outline = Self { corners: [[[0.0; 2]; CORNERS]; KEYS], reach: [f32::INFINITY; 2] };
        let (mut thickness, mut longest, mut farthest) = (0.0_f64, 1.0_f64, 0.0_f64);
        let projected = outline.corners.as_flattened_mut();
        for (projected, corner) in projected.iter_mut().zip(all) {
            let (point, r) = (corner.point(rays), f64::from(corner.radius));
            let z = point.z;
            // Close to the camera, a ball may cover anything.
            if rays.is_perspective() && (z <= 2.0 * r || z <= 0.0) {
                return Some(outline);
            }
            let scale = if rays.is_perspective() { z.recip() } else { 1.0 };
            let ray = point.truncate() * scale;
            // In the plane of constant depth, a ray d that comes within r of
            // the point is at most r |d| away. In perspective that plane's
            // unit is 1/z, and |d| itself is off by that much. Between corners
            // neither factor is larger than at all of them.
            longest = longest.max((1.0 + rays.slope(ray).length_squared()).sqrt());
            thickness = thickness.max(if rays.is_perspective() { r / (z - r) } else { r });
            let raster = rays.raster(ray);
            farthest = farthest.max(raster.abs().max_element());
            *projected = raster.as_vec2().to_array();
        }
        let reach = rays.stretch().map(|stretch| {
            // As much again as rounding may move it.
            (thickness * longest * stretch * (1.0 + 1e-5) + 1e-4 + 4e-7 * farthest) as f32
        });
        if farthest < MAX_DISTANCE && f64::from(reach[0].max(reach[1])) < MAX_DISTANCE {
            outline.reach = reach;
        }
        Some(outline)
    }
}

/// A line of a hull, downwards.
#[derive(Clone, Copy)]
struct Edge {
    top: [f32; 2],
    bottom: [f32; 2],
    slope: f32,
}

impl Edge {
    #[inline(always)]
    fn new(a: [f32; 2], b: [f32; 2]) -> Self {
        let (top, bottom) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        Self { top, bottom, slope: (bottom[0] - top[0]) / (bottom[1] - top[1]) }
    }

    /// The x of the line at height `y`.
    #[inline(always)]
    fn at(&self, y: f32) -> f32 {
        self.top[0] + (y - self.top[1]) * self.slope
    }

    /// Extends a range by the part of the edge between two heights.
    #[inline(always)]
    fn extend(&self, from: f32, to: f32, range: &mut [f32; 2]) {
        if self.top[1] > to || self.bottom[1] < from {
            return;
        }
        let (low, high) = (self.top[0].min(self.bottom[0]), self.top[0].max(self.bottom[0]));
        let first = if from > self.top[1] { self.at(from).max(low).min(high) } else { self.top[0] };
        let last =
            if to < self.bottom[1] { self.at(to).max(low).min(high) } else { self.bottom[0] };
        range[0] = range[0].min(first.min(last));
        range[1] = range[1].max(first.max(last));
    }
}

impl<const KEYS: usize, const CORNERS: usize> Rows for Outline<KEYS, CORNERS> {
    #[inline(always)]
    fn for_rows(&self, area: &CellArea, mut sink: impl FnMut(i32, i32, i32)) {
        let Some([low, high]) = self.bounds() else {
            return (area.min[1]..area.max[1]).for_each(|row| sink(row, area.min[0], area.max[0]));
        };
        let side = area.side as f32;
        let per_cell = side.recip();
        let cell = |at: f32| (at * per_cell).floor() as i32;
        let first = cell(low[1]).max(area.min[1]);
        let end = cell(high[1]).saturating_add(1).min(area.max[1]);
        if cell(low[0]) >= area.max[0] || cell(high[0]) < area.min[0] {
            return;
        }
        let corners = self.corners.as_flattened();
        let lone = Edge::new(corners[0], corners[1]);
        // How far to either side of the edge's line ellipses on it reach.
        let beside = (self.reach[0].powi(2) + (lone.slope * self.reach[1]).powi(2)).sqrt();
        for row in first..end {
            let (from, to) = (row as f32 * side, (row + 1) as f32 * side);
            let mut range = [f32::INFINITY, f32::NEG_INFINITY];
            let (above, below) = (from - self.reach[1], to + self.reach[1]);
            if KEYS * CORNERS == 2 {
                lone.extend(above, below, &mut range);
                range = [range[0] - self.reach[0], range[1] + self.reach[0]];
                // NaN or infinite where the edge is level: no help.
                let (a, b) = (lone.at(from), lone.at(to));
                range = [range[0].max(a.min(b) - beside), range[1].min(a.max(b) + beside)];
            } else {
                for (index, &a) in corners.iter().enumerate() {
                    for &b in &corners[index + 1..] {
                        Edge::new(a, b).extend(above, below, &mut range);
                    }
                }
                range = [range[0] - self.reach[0], range[1] + self.reach[0]];
            }
            let columns = [cell(range[0]), cell(range[1]).saturating_add(1)];
            let columns = [columns[0].max(area.min[0]), columns[1].min(area.max[0])];
            if columns[0] < columns[1] {
                sink(row, columns[0], columns[1]);
            }
        }
    }

    #[inline(always)]
    fn bounds(&self) -> Option<[[f32; 2]; 2]> {
        if self.reach[0] == f32::INFINITY {
            return None;
        }
        let mut bounds = [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]];
        for corner in self.corners.as_flattened() {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(corner[axis]);
                bounds[1][axis] = bounds[1][axis].max(corner[axis]);
            }
        }
        let [low, high] = bounds;
        let [across, down] = self.reach;
        Some([[low[0] - across, low[1] - down], [high[0] + across, high[1] + down]])
    }
}
