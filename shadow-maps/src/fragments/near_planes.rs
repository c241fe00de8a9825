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
    /// How far it is from the receiver, in sides of a pixel, and how much it is turned.
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
