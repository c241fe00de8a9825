//! The surface that a receiver lies on, as a map shows it.

use dsm_core::Transmittance;

use super::apex::Apex;
use super::near_planes::nearest_in_cell;
use super::near_planes::{CELL, Candidate, MOST_NEAR, NearPlane, Nearest, cells_around};
use super::packed::PackedFragments;

/// The cosine below which planes are seen from their edge: others that no sample met may
/// lie between what a cell shows of them. Fitted: receivers that graze a knot of 19,200
/// triangles, at 512 × 512 pixels, are too dark by 0.019 in the mean without it, and by
/// 0.0003 with it.
const EDGE_ON: f32 = 0.1;

/// How far a plane may be from a receiver, in sides of a pixel, that others end at: the
/// far side of a body that is seen from its edge lies a part of a pixel behind. Fitted on
/// the same receivers: 0.030 too dark in the mean with a cell, 0.019 with this.
const MEETING: f32 = 0.5;

/// How much the planes of one surface may turn from cell to cell: one less the cosine.
const MOST_TURN: f32 = 0.3;

/// Which planes near a receiver are its surface, and which end before it.
///
/// Outlines are only known to a cell of coverage, so that within a cell of the receiver
/// planes decide: two that meet in an edge end there, on the side on which their cells
/// are not. Those that end before the receiver shade nothing within a cell; the one that
/// it lies on shades by the side that the receiver is on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// By how much w may differ at the receiver's place: at least, and for each unit of
    /// a plane's slope.
    pub(crate) room: f32,
    pub(crate) per_slope: f32,
    /// By how much w of another near plane may differ for each unit by which its slope
    /// does.
    pub(crate) per_turn: f32,
    /// The surface, or what is likest to it.
    pub(crate) plane: NearPlane,
    /// That the receiver stands off it, on a side of its own.
    pub(crate) has_side: bool,
    /// Planes that shade nothing within a cell by their coverage.
    settled: [NearPlane; MOST_NEAR],
    count: usize,
}

impl Surface {
    /// The planes within this room, and no others.
    pub(crate) const fn passing(room: f32, per_slope: f32) -> Self {
        Self {
            room,
            per_slope,
            per_turn: 0.0,
            plane: NearPlane { off: 0.0, slope: [0.0; 2] },
            has_side: false,
            settled: [NearPlane::NONE; MOST_NEAR],
            count: 0,
        }
    }

    /// The room of planes of this slope.
    fn room(&self, [along_x, along_y]: [f32; 2]) -> f32 {
        self.room + self.per_slope * (along_x.abs() + along_y.abs())
    }

    /// Whether a plane shades nothing within a cell by its coverage: the surface, and what
    /// ends before the receiver.
    pub(crate) fn is_settled(&self, plane: NearPlane) -> bool {
        let room = self.room(plane.slope);
        self.settled[..self.count].iter().any(|one| one.apart(&plane) <= room)
    }

    fn settle(&mut self, plane: NearPlane) {
        self.settled[self.count] = plane;
        self.count += 1;
    }
}

impl Apex {
    /// The same on the surface that the map shows there, and the surface's opacity where
    /// the receiver has a known side of it. O(fragments of the pixels around).
    pub(crate) fn on_surface<T: Transmittance>(
        mut self,
        fragments: &PackedFragments,
    ) -> (Self, Option<T>) {
        let is_known = self.slope.is_some();
        let mut found = self.search::<T>(fragments, CELL);
        if is_known && !found.planes().iter().any(|one| self.may_be_surface(one)) {
            // Seen from its edge: no sample met it here.
            found = self.search(fragments, 1.0);
        }
        let found = found.planes();
        let apex = self;
        let ends = |one: &Candidate<T>| found.iter().any(|other| apex.ends_before(one, other));
        let own = found.iter().find(|one| apex.may_be_surface(one) && !ends(one));
        let Some(likest) = own.or(found.first()) else { return (self, None) };
        let surface = &mut self.surface;
        surface.plane = likest.plane;
        surface.per_turn = 2.0 * CELL;
        for one in found.iter().filter(|one| ends(one)) {
            surface.settle(one.plane);
        }
        let Some(own) = own else { return (self, None) };
        let is_on = is_known || own.is_exact;
        let shows = own.covers() || apex.cosine(own.plane.slope) > EDGE_ON;
        if is_known {
            // What it is known to lie on counts by its side, and not once more.
            surface.room = surface.room.max(own.plane.off.abs());
        }
        surface.has_side = !is_on && shows;
        if is_on || shows {
            surface.settle(own.plane);
        }
        if is_on {
            let stand_in = if own.covers() { None } else { nearest_in_cell(found) };
            for one in found.iter().filter(|one| **one != *own && !ends(one)) {
                // What goes on beside it, and what stands for it in the receiver's cell.
                let room = surface.room(one.plane.slope) + one.plane.turned(&own.plane) * CELL;
                let goes_on = one.plane.off.abs() <= room && !one.covers();
                if goes_on || stand_in == Some(one.plane) {
                    surface.settle(one.plane);
                }
            }
        }
        let has_side = is_known || surface.has_side;
        (self, has_side.then_some(own.opacity))
    }

    /// Whether a plane is near enough, and of one side with what the receiver is known to
    /// lie on.
    fn may_be_surface<T>(&self, one: &Candidate<T>) -> bool {
        one.is_exact
            || self.distance_to(one.plane.slope, one.plane.off) <= CELL
                && self.turned(one.plane.slope) <= MOST_TURN
    }

    /// Whether a plane ends before the receiver, where it meets another: all of its cells
    /// are on the other side of that edge.
    fn ends_before<T>(&self, one: &Candidate<T>, other: &Candidate<T>) -> bool {
        if one.cells == 0 || one.plane == other.plane {
            return false;
        }
        let above = |place: [f32; 2]| one.plane.at(place) > other.plane.at(place);
        let here = above([0.0; 2]);
        let corner = self.within.map(|at| (at / CELL).floor() * CELL - at);
        let mut cells = (0..9_u32).filter(|cell| one.cells >> cell & 1 == 1);
        cells.all(|cell| {
            let step = [cell % 3, cell / 3].map(|at| at as f32 - 0.5);
            above([0, 1].map(|axis| corner[axis] + step[axis] * CELL)) != here
        })
    }

    /// The planes that are nearest to the receiver, of fragments in the pixels within
    /// `reach`.
    fn search<T: Transmittance>(&self, fragments: &PackedFragments, reach: f32) -> Nearest<T> {
        let mut found = Nearest::new();
        let span = |axis: usize| {
            let at = |off: f32| self.corner[axis] as i64 + (self.within[axis] + off).floor() as i64;
            at(-reach)..=at(reach)
        };
        let pixels = span(1).flat_map(|y| span(0).map(move |x| [x, y]));
        for pixel in pixels.filter(|pixel| pixel.iter().all(|at| u32::try_from(*at).is_ok())) {
            let beyond =
                [0, 1].map(|axis| (self.corner[axis] - pixel[axis] as f32) + self.within[axis]);
            for fragment in fragments.pixel::<T>(pixel.map(|at| at as u32)) {
                let Some(slope) = fragment.gradient else { continue };
                let cells = cells_around(fragment.coverage, beyond);
                if reach < 1.0 && cells == 0 {
                    continue;
                }
                let [along_x, along_y] = slope;
                let off = (fragment.w - self.w)
                    + (along_x * (beyond[0] - 0.5) + along_y * (beyond[1] - 0.5));
                let is_exact = off.abs() <= self.surface.room(slope);
                let distance = self.distance_to(slope, off);
                if is_exact || distance <= MEETING {
                    let (plane, opacity) = (NearPlane { off, slope }, fragment.opacity);
                    let apart = distance + self.turned(slope);
                    let one = Candidate { plane, apart, opacity, is_exact, cells };
                    found.push(one, self.surface.room(slope));
                }
            }
        }
        found
    }

    /// How much a slope is turned from what the receiver is known to lie on.
    fn turned(&self, slope: [f32; 2]) -> f32 {
        self.slope.map_or(0.0, |own| turn(self.steep(slope), self.steep(own)))
    }

    /// How far from the apex a plane lies, in sides of a pixel: at right angles to it,
    /// `off` along the view.
    fn distance_to(&self, slope: [f32; 2], off: f32) -> f32 {
        off.abs() / (self.footprint * self.w) * self.cosine(slope)
    }

    /// The cosine between the view and the normal of a plane, or nearly so.
    fn cosine(&self, slope: [f32; 2]) -> f32 {
        let [x, y] = self.steep(slope);
        (1.0 + x * x + y * y).sqrt().recip()
    }

    /// A slope in the frame's own unit: a side of a pixel in depth for one across.
    fn steep(&self, slope: [f32; 2]) -> [f32; 2] {
        slope.map(|along| along / (self.footprint * self.w))
    }
}

/// One less the cosine between the normals of planes of these slopes, whose unit is a
/// side of a pixel in depth for one across.
fn turn(a: [f32; 2], b: [f32; 2]) -> f32 {
    let dot = |a: [f32; 2], b: [f32; 2]| 1.0 + a[0] * b[0] + a[1] * b[1];
    1.0 - dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}
