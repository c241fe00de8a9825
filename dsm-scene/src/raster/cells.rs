//! Groups of neighbouring rays.

use dsm_core::TileSamples;
use fearless_simd::{Simd, SimdBase, f32x16, u32x16};
use glam::DVec2;

use super::rays::Rays;

/// Rays that are tested at once.
pub(super) const LANES: usize = 16;

/// 16 rays as vectors.
#[derive(Clone, Copy)]
pub(super) struct RayLanes<S: Simd> {
    /// The ray through the middle of the cell.
    pub(super) centre: [f32x16<S>; 2],
    /// Each ray relative to it.
    pub(super) ray: [f32x16<S>; 2],
    /// The sideways movement of the ray per unit of depth.
    pub(super) slope: [f32x16<S>; 2],
    /// 1 / |d|² of its direction (slope, 1).
    pub(super) shrink: f32x16<S>,
    pub(super) time: f32x16<S>,
    pub(super) sample: u32x16<S>,
}

/// 16 rays as columns; those that fill up a cell are NaN and meet nothing.
#[derive(Clone, Copy, Debug)]
struct LaneColumns {
    ray: [[f32; LANES]; 2],
    slope: [[f32; LANES]; 2],
    shrink: [f32; LANES],
    time: [f32; LANES],
    sample: [u32; LANES],
}

impl LaneColumns {
    const EMPTY: Self = Self {
        ray: [[f32::NAN; LANES]; 2],
        slope: [[f32::NAN; LANES]; 2],
        shrink: [f32::NAN; LANES],
        time: [f32::NAN; LANES],
        sample: [0; LANES],
    };
}

/// The rectangle of cells that a block of pixels touches. A cell is a square of
/// 1, 4 or 16 pixels, as many as it takes to fill 16 lanes, and lies where it
/// lies in the map, whatever the block.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellArea {
    pub(super) min: [i32; 2],
    /// Half-open.
    pub(super) max: [i32; 2],
    /// Pixels along the side of a cell.
    pub(super) side: i32,
}

impl CellArea {
    pub(super) fn new(samples: &TileSamples) -> Self {
        let side = match samples.samples_per_pixel() {
            0..=1 => 4,
            2..=4 => 2,
            _ => 1,
        };
        let (min, size) = (samples.min(), samples.size());
        // A block's last pixel is below i32::MAX.
        let end = |axis: usize| {
            let last = (i64::from(min[axis]) + i64::from(size[axis]) - 1).div_euclid(side.into());
            last as i32 + 1
        };
        Self { min: min.map(|pixel| pixel.div_euclid(side)), max: [end(0), end(1)], side }
    }

    pub(super) fn columns(&self) -> usize {
        (i64::from(self.max[0]) - i64::from(self.min[0])).max(0) as usize
    }

    pub(super) fn rows(&self) -> usize {
        (i64::from(self.max[1]) - i64::from(self.min[1])).max(0) as usize
    }
}

/// The rays of one cell. Keeps its memory from cell to cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    /// The ray through its middle.
    centre: DVec2,
    lanes: Vec<LaneColumns>,
}

impl Cell {
    /// Replaces the rays by those of the cell in column `x` and row `y`.
    #[inline(always)]
    pub(super) fn fill(&mut self, rays: &Rays, samples: &TileSamples, side: i32, x: i32, y: i32) {
        let middle = |cell: i32| (f64::from(cell) + 0.5) * f64::from(side);
        let centre = rays.through(DVec2::new(middle(x), middle(y)));
        // Rounded, so that its product with an `f32` is exact.
        self.centre = centre.as_vec2().as_dvec2();
        self.lanes.clear();
        let (min, size) = (samples.min(), samples.size());
        // The block's pixels in this cell, from its corner on.
        let pixels = |axis: usize, cell: i32| {
            let first = i64::from(cell) * i64::from(side) - i64::from(min[axis]);
            first.max(0)..(first + i64::from(side)).min(size[axis].into())
        };
        let mut lane = LANES;
        for row in pixels(1, y) {
            for column in pixels(0, x) {
                for sample in samples.pixel(column as u32, row as u32) {
                    if lane == LANES {
                        self.lanes.push(LaneColumns::EMPTY);
                        lane = 0;
                    }
                    if let Some(lanes) = self.lanes.last_mut() {
                        let at = sample as usize;
                        let ray = rays.through(DVec2::new(samples.x()[at], samples.y()[at]));
                        let slope = rays.slope(ray);
                        let from_centre = ray - self.centre;
                        lanes.ray[0][lane] = from_centre.x as f32;
                        lanes.ray[1][lane] = from_centre.y as f32;
                        lanes.slope[0][lane] = slope.x as f32;
                        lanes.slope[1][lane] = slope.y as f32;
                        lanes.shrink[lane] = (1.0 + slope.length_squared()).recip() as f32;
                        lanes.time[lane] = samples.times()[at];
                        lanes.sample[lane] = sample;
                    }
                    lane += 1;
                }
            }
        }
    }

    /// Number of vectors of lanes.
    pub(super) const fn len(&self) -> usize {
        self.lanes.len()
    }

    /// Vector `index` of lanes.
    #[inline(always)]
    pub(super) fn lanes<S: Simd>(&self, simd: S, index: usize) -> RayLanes<S> {
        let columns = &self.lanes[index];
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        let centre = self.centre.to_array();
        RayLanes {
            centre: centre.map(|centre| f32x16::splat(simd, centre as f32)),
            ray: [load(&columns.ray[0]), load(&columns.ray[1])],
            slope: [load(&columns.slope[0]), load(&columns.slope[1])],
            shrink: load(&columns.shrink),
            time: load(&columns.time),
            sample: u32x16::load_array_ref(simd, &columns.sample),
        }
    }
}
