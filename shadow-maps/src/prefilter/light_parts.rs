//! An area light in parts that are about square, as a receiver sees them through a map.

use dsm_core::detail::LightShape;
use dsm_core::{AreaLight, LightExtent};
use dsm_trace::detail::LightFrame;
use glam::{DVec2, DVec3};

/// Most parts along a side: of longer lights they are longer than wide.
const MOST_PARTS: f64 = 8.0;

/// What of a shape's full width a square of the same variance is wide.
fn share(shape: LightShape) -> f64 {
    match shape {
        LightShape::Point => 0.0,
        LightShape::Rectangle => 1.0,
        _ => 0.75_f64.sqrt(),
    }
}

/// What a ratio of sides counts for: no light whose sides are in a ratio of small numbers
/// lies where rounding decides how many parts it has.
const RATIO: f64 = 0.95;

/// How many parts make each side of a light.
fn counts(sides: [f64; 2], splits: u32) -> [u32; 2] {
    let shorter = sides[0].min(sides[1]);
    sides.map(|side| {
        let ratio = if shorter > 0.0 { side / shorter } else { MOST_PARTS };
        let most = if side > 0.0 { MOST_PARTS } else { 1.0 };
        splits.max(1) * (ratio * RATIO).round().clamp(1.0, most) as u32
    })
}

/// How wide the square is that stands for one of so many parts.
fn square(sides: [f64; 2], counts: [u32; 2]) -> f64 {
    let [wide, high] = [0, 1].map(|axis| sides[axis] / f64::from(counts[axis]));
    ((wide.powi(2) + high.powi(2)) / 2.0).sqrt()
}

/// The width of the squares that lookups take a light in, in scene units; 0 for a point.
///
/// ```
/// use dsm_core::LightExtent;
/// use shadow_maps::detail::square_width;
///
/// assert_eq!(square_width(LightExtent::rectangle([1.0, 0.25])), 0.25);
/// assert_eq!(square_width(LightExtent::POINT), 0.0);
/// ```
#[must_use]
pub fn square_width(extent: LightExtent) -> f64 {
    let share = share(extent.shape());
    let sides = extent.size().map(|side| side * share);
    square(sides, counts(sides, 1))
}

/// The parts of a light, and their size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightParts {
    pub(super) counts: [u32; 2],
    /// How the width of a part, as a filter's in texels, grows per unit of w.
    pub(super) rate: f64,
}

/// How a ray from `receiver` to a point of the light moves per unit of w, and where it
/// ends; `None` where nothing of the map can lie between.
pub(super) fn slope(frame: &LightFrame, receiver: DVec3, light: DVec3) -> Option<[f64; 2]> {
    frame.ray(receiver, light, 0.0).map(|ray| ray.slope())
}

impl LightParts {
    /// One point.
    const POINT: Self = Self { counts: [1; 2], rate: 0.0 };

    /// The parts of a light: `splits` along its shorter side, as many along its longer
    /// one as make them square.
    ///
    /// A filter is a square. That of a rectangle's part has the variance of the part in
    /// the mean over both axes; a disk and a sphere, which a receiver sees as one, stand
    /// for a square of their own variance, whose side is √¾ of the diameter.
    pub(super) fn new(frame: &LightFrame, receiver: DVec3, light: &AreaLight, splits: u32) -> Self {
        if light.shape() == LightShape::Point {
            return Self::POINT;
        }
        let share = share(light.shape());
        let along = |u: f64, v: f64| slope(frame, receiver, light.at(receiver, u, v));
        // Of a light that reaches behind the receiver, what is nearer to its centre.
        let across = |axis: usize| {
            [1.0, 0.1, 0.001].into_iter().find_map(|scale| {
                let ends = [0.5 - scale / 2.0, 0.5 + scale / 2.0].map(|end| {
                    let [u, v] = if axis == 0 { [end, 0.5] } else { [0.5, end] };
                    along(u, v).map(DVec2::from)
                });
                let [from, to] = ends;
                Some((to? - from?).length() / scale)
            })
        };
        let [Some(wide), Some(high)] = [across(0), across(1)] else { return Self::POINT };
        // Of the light alone: all receivers see as many parts.
        let counts = counts(light.half_axes().map(DVec3::length), splits);
        let rate = square([wide * share, high * share], counts);
        Self { counts, rate: if rate.is_finite() { rate } else { 0.0 } }
    }

    /// The middle of each part, in [0, 1]² of the light.
    pub(super) fn middles(self) -> impl Iterator<Item = [f64; 2]> {
        let [columns, rows] = self.counts;
        let middle = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count);
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| [middle(column, columns), middle(row, rows)])
        })
    }
}
