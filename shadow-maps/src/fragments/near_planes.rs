//! Planes as they pass a receiver.

use dsm_core::Transmittance;

/// The side of a cell of coverage, in pixels: as well as a map knows outlines.
pub(crate) const CELL: f32 = 0.125;

/// Planes near a receiver that are told apart.
pub(crate) const MOST_NEAR: usize = 8;

/// A plane as it passes a receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NearPlane {
    /// By how much more w it has at the receiver's place.
    pub(crate) off: f32,
    pub(crate) slope: [f32; 2],
}

impl NearPlane {
    pub(crate) const NONE: Self = Self { off: f32::NAN, slope: [0.0; 2] };

    /// By how much more w it has at `place`, in pixels from the receiver.
    pub(crate) fn at(&self, place: [f32; 2]) -> f32 {
        self.off + self.slope[0] * place[0] + self.slope[1] * place[1]
    }

    /// By how much more w it has than another.
    pub(crate) fn above(&self, other: &Self) -> Self {
        let slope = [0, 1].map(|axis| self.slope[axis] - other.slope[axis]);
        Self { off: self.off - other.off, slope }
    }

    /// By how much they differ within a cell.
    pub(crate) fn apart(&self, other: &Self) -> f32 {
        (self.off - other.off).abs() + self.turned(other) * CELL
    }

    pub(crate) fn turned(&self, other: &Self) -> f32 {
        (self.slope[0] - other.slope[0]).abs() + (self.slope[1] - other.slope[1]).abs()
    }
}

/// A plane that may be a receiver's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate<T> {
    pub(crate) plane: NearPlane,
    /// How far the nearest of it that is covered lies from the receiver, in sides of a pixel,
    /// and how much it is turned.
    pub(crate) apart: f32,
    pub(crate) opacity: T,
    /// Whether it passes through the receiver as far as numbers tell.
    pub(crate) is_exact: bool,
    /// Which of the nine cells around the receiver it covers.
    pub(crate) cells: u32,
}

impl<T> Candidate<T> {
    /// Whether it covers the receiver's own cell.
    pub(crate) const fn covers(&self) -> bool {
        self.cells >> 4 & 1 == 1
    }
}

/// The few planes that are nearest, the nearest first. Parts of one plane in several
/// fragments are one.
pub(crate) struct Nearest<T> {
    planes: [Candidate<T>; MOST_NEAR],
    count: usize,
}

impl<T: Transmittance> Nearest<T> {
    pub(crate) const fn new() -> Self {
        let plane = NearPlane::NONE;
        let none = Candidate { plane, apart: 0.0, opacity: T::BLOCKED, is_exact: false, cells: 0 };
        Self { planes: [none; MOST_NEAR], count: 0 }
    }

    pub(crate) fn planes(&self) -> &[Candidate<T>] {
        &self.planes[..self.count]
    }

    pub(crate) fn push(&mut self, one: Candidate<T>, room: f32) {
        let same = |have: &&mut Candidate<T>| have.plane.apart(&one.plane) <= room;
        if let Some(have) = self.planes[..self.count].iter_mut().find(same) {
            have.cells |= one.cells;
            if one.apart < have.apart {
                have.apart = one.apart;
                self.planes[..self.count].sort_by(|a, b| a.apart.total_cmp(&b.apart));
            }
            return;
        }
        let place = self.planes().partition_point(|have| have.apart <= one.apart);
        if place < MOST_NEAR {
            self.count = (self.count + 1).min(MOST_NEAR);
            self.planes[place..self.count].rotate_right(1);
            self.planes[place] = one;
        }
    }
}

/// How far, in pixels of the raster, the nearest of nine cells lies from a place within its
/// pixel: 0 in the cell itself, and of none.
pub(crate) fn gap(cells: u32, within: [f32; 2]) -> f32 {
    let within = within.map(|at| at / CELL - (at / CELL).floor());
    let along = |step: u32, at: f32| match step {
        0 => at,
        1 => 0.0,
        _ => 1.0 - at,
    };
    let gaps = (0..9_u32).filter(|cell| cells >> cell & 1 == 1).map(|cell| {
        let [x, y] = [along(cell % 3, within[0]), along(cell / 3, within[1])];
        (x * x + y * y).sqrt() * CELL
    });
    gaps.reduce(f32::min).unwrap_or(0.0)
}

/// The nearest along the view that covers the receiver's cell.
pub(crate) fn nearest_in_cell<T>(found: &[Candidate<T>]) -> Option<NearPlane> {
    let planes = found.iter().filter(|one| one.covers()).map(|one| one.plane);
    planes.min_by(|a, b| a.off.abs().total_cmp(&b.off.abs()))
}

/// Which of the nine cells around a place, in pixels from its own pixel, a mask covers: row
/// by row.
pub(crate) fn cells_around(coverage: u64, place: [f32; 2]) -> u32 {
    let [x, y] = place.map(|at| (at / CELL).floor() as i32 - 1);
    let is_set = |[x, y]: [i32; 2]| {
        (0..8).contains(&x) && (0..8).contains(&y) && coverage >> (8 * y + x) & 1 == 1
    };
    (0..9).fold(0, |cells, at| cells | u32::from(is_set([x + at % 3, y + at / 3])) << at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_those_to_the_nearest_cell() {
        let mut random = dsm_testkit::Random::new(3);
        for _ in 0..2000 {
            let cells = random.below(512) as u32;
            let within = [0, 1].map(|_| random.unit() as f32);
            // The nearest of many places in the covered cells.
            let mut nearest = f32::INFINITY;
            for cell in (0..9_u32).filter(|cell| cells >> cell & 1 == 1) {
                let first = [cell % 3, cell / 3]
                    .map(|at| (at as f32 - 1.0) * CELL)
                    .into_iter()
                    .zip(within)
                    .map(|(step, at)| (at / CELL).floor() * CELL + step);
                let off = first.zip(within).map(|(low, at)| at.clamp(low, low + CELL) - at);
                nearest = nearest.min(off.map(|off| off * off).sum::<f32>().sqrt());
            }
            let expected = if cells == 0 { 0.0 } else { nearest };
            assert!((gap(cells, within) - expected).abs() < 1e-6, "{cells:09b} {within:?}");
        }
    }
}
