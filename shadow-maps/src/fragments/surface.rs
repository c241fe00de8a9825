//! The surface that a receiver lies on, as a map shows it.

use dsm_core::Transmittance;

use super::apex::Apex;
use super::packed::PackedFragments;

/// The side of a cell of coverage, in pixels: as well as a map knows outlines.
pub(crate) const CELL: f32 = 0.125;

/// How much the planes of one surface may turn from cell to cell: one less the cosine.
const MOST_TURN: f32 = 0.3;

/// Which planes are the surface that a receiver lies on.
///
/// Those that pass through it, as far as numbers tell; and in the cells of coverage
/// around it those of its neighbours, whose outlines are only known to a cell: a curved
/// surface would else shade itself where a neighbour's plane is drawn too far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// By how much w may differ at the receiver's place: at least, and for each unit of
    /// a plane's slope.
    pub(crate) room: f32,
    pub(crate) per_slope: f32,
    /// The slope of the surface.
    pub(crate) slope: [f32; 2],
    /// By how much w of a neighbour's plane may differ for each unit by which its slope
    /// does.
    pub(crate) per_turn: f32,
    /// The w of the fragment that stands for the surface in the receiver's own cell, if
    /// that is a neighbour; NaN for none.
    pub(crate) stand_in: f32,
}

/// A fragment that may be a receiver's surface.
struct Candidate<T> {
    /// How far it is from it, in sides of a pixel, and how much it is turned.
    apart: f32,
    /// How far in w.
    off: f32,
    slope: [f32; 2],
    opacity: T,
    /// Whether its plane passes through the receiver as far as numbers tell, and whether
    /// it covers the receiver's own cell.
    is_exact: bool,
    covers: bool,
}

impl Surface {
    /// The planes within this room, and no neighbours.
    pub(crate) const fn passing(room: f32, per_slope: f32) -> Self {
        Self { room, per_slope, slope: [0.0; 2], per_turn: 0.0, stand_in: f32::NAN }
    }
}

impl Apex {
    /// The same on the surface that the map shows there, and the surface's opacity where
    /// the receiver is known to lie on it. O(fragments of the pixels around).
    pub(crate) fn on_surface<T: Transmittance>(
        mut self,
        fragments: &PackedFragments,
    ) -> (Self, Option<T>) {
        let mut nearest: Option<(f32, f32)> = None;
        let mut best = self.search(fragments, CELL, |covers, off, w| {
            if covers && nearest.is_none_or(|(least, _)| off < least) {
                nearest = Some((off, w));
            }
        });
        if best.is_none() && self.slope.is_some() {
            // Seen from its edge: no sample met it here.
            best = self.search(fragments, 1.0, |_, _, _| ());
        }
        let Some(Candidate { off, slope, opacity, is_exact, covers, .. }) = best else {
            return (self, None);
        };
        self.surface.slope = self.slope.unwrap_or(slope);
        self.surface.per_turn = CELL;
        if self.slope.is_some() {
            // What it is known to lie on counts by its side, and not once more.
            self.surface.room = self.surface.room.max(off);
        }
        if let Some((_, w)) = nearest.filter(|_| !(is_exact && covers)) {
            self.surface.stand_in = w;
        }
        (self, self.slope.map(|_| opacity))
    }

    /// The fragment that is most likely the receiver's surface, of those in the pixels
    /// within `reach`. `see` is told of each whether it covers the receiver's cell, its
    /// difference in w, and its w.
    fn search<T: Transmittance>(
        &self,
        fragments: &PackedFragments,
        reach: f32,
        mut see: impl FnMut(bool, f32, f32),
    ) -> Option<Candidate<T>> {
        let mut best: Option<Candidate<T>> = None;
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
                if reach < 1.0 && !is_near(fragment.coverage, beyond) {
                    continue;
                }
                let [along_x, along_y] = slope;
                let off = (fragment.w - self.w)
                    + (along_x * (beyond[0] - 0.5) + along_y * (beyond[1] - 0.5));
                let covers = covers(fragment.coverage, beyond);
                see(covers, off.abs(), fragment.w);
                let Surface { room, per_slope, .. } = self.surface;
                let is_exact = off.abs() <= room + per_slope * (along_x.abs() + along_y.abs());
                let (turned, distance) = self.compare(slope, off);
                let is_surface = is_exact || (distance <= CELL && turned <= MOST_TURN);
                let apart = distance + turned;
                if is_surface && best.as_ref().is_none_or(|best| apart < best.apart) {
                    let opacity = fragment.opacity;
                    let off = off.abs();
                    best = Some(Candidate { apart, off, slope, opacity, is_exact, covers });
                }
            }
        }
        best
    }
}

/// One less the cosine between the normals of planes of these slopes, whose unit is a
/// side of a pixel in depth for one across.
pub(crate) fn turn(a: [f32; 2], b: [f32; 2]) -> f32 {
    let dot = |a: [f32; 2], b: [f32; 2]| 1.0 + a[0] * b[0] + a[1] * b[1];
    1.0 - dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

fn cell(place: [f32; 2]) -> [i32; 2] {
    place.map(|at| (at / CELL).floor() as i32)
}

fn is_set(coverage: u64, [x, y]: [i32; 2]) -> bool {
    (0..8).contains(&x) && (0..8).contains(&y) && coverage >> (8 * y + x) & 1 == 1
}

/// Whether a mask covers the cell of this place, in pixels from its own pixel.
pub(crate) fn covers(coverage: u64, place: [f32; 2]) -> bool {
    is_set(coverage, cell(place))
}

/// Whether it covers that cell or one beside it.
fn is_near(coverage: u64, place: [f32; 2]) -> bool {
    let [x, y] = cell(place);
    let around = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| [x, y]));
    around.into_iter().any(|cell| is_set(coverage, cell))
}
