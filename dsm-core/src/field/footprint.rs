//! Footprints of lookups: the pixels that are averaged, and their weights.

use crate::filter::{Filter, FilterShape};

/// The pixels that a lookup averages, with their weights.
///
/// ```
/// use dsm_core::{
///     DeepMap, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Vertex,
///     filtered_lookup,
/// };
///
/// // The second of four pixels is blocked at depth 1.
/// let mut pixels = PixelListsBuilder::new(4, 1);
/// for value in [1.0, 0.0, 1.0, 1.0] {
///     pixels.push(Vertex::new(1.0, 1.0));
///     pixels.push(Vertex::new(1.0, value));
///     pixels.finish_pixel()?;
/// }
/// let map = DeepMap::new(MapInfo::default(), pixels.finish()?);
///
/// let receiver = Receiver::new([1.5, 0.5], 2.0);
/// assert_eq!(filtered_lookup(&map, &receiver, &Footprint::Point), Ok(0.0));
/// // Wider along the row than across it.
/// let axes = [[1.5, 0.0], [0.0, 0.5]];
/// let ellipse = Footprint::Elliptical { shape: FilterShape::Box, axes };
/// let light = filtered_lookup(&map, &receiver, &ellipse).unwrap();
/// assert!((light - 2.0 / 3.0).abs() < 1e-6);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footprint {
    /// The pixel that contains the point, alone.
    Point,
    /// A separable filter around the point.
    Isotropic(Filter),
    /// An ellipse around the point: {u a + v b : u² + v² ≤ 1} for the axes a
    /// and b, in pixels. The weight is the shape's at √(u² + v²). An ellipse
    /// thinner than the shape's minimum width is widened to it.
    Elliptical {
        /// The profile of the weight from the centre to the rim.
        shape: FilterShape,
        /// The two half-axes, in pixels.
        axes: [[f32; 2]; 2],
    },
}

/// The largest ratio of an ellipse's axes when it chooses its level: this bounds
/// the pixels it reaches there.
const LONGEST: f64 = 16.0;

impl Footprint {
    /// The level in which the footprint is as wide as two pixels; not clamped.
    pub(super) fn level(&self) -> f64 {
        match *self {
            Self::Point => 0.0,
            Self::Isotropic(filter) => (0.5 * f64::from(filter.width())).log2(),
            Self::Elliptical { axes, .. } => {
                let PrincipalAxes { major, minor, .. } = PrincipalAxes::of(axes);
                minor.max(major / LONGEST).log2()
            }
        }
    }

    /// This footprint where a pixel's side is `scale` times as many pixels.
    #[inline(always)]
    pub(super) fn scaled(self, scale: f32) -> Self {
        match self {
            Self::Point => Self::Point,
            Self::Isotropic(filter) => Self::Isotropic(filter.scaled(scale)),
            Self::Elliptical { shape, axes } => {
                Self::Elliptical { shape, axes: axes.map(|axis| axis.map(|part| part * scale)) }
            }
        }
    }
}

/// The half-axes of an ellipse that stand at right angles.
struct PrincipalAxes {
    major: f64,
    minor: f64,
    /// Sine and cosine of the major axis' angle.
    direction: (f64, f64),
}

impl PrincipalAxes {
    /// Eigenvectors of A Aᵀ for A = [a b].
    fn of(axes: [[f32; 2]; 2]) -> Self {
        let [a, b] = axes.map(|axis| axis.map(f64::from));
        let (xx, xy, yy) =
            (a[0] * a[0] + b[0] * b[0], a[0] * a[1] + b[0] * b[1], a[1] * a[1] + b[1] * b[1]);
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let middle = 0.5 * (xx + yy);
        let spread = (0.5 * (xx - yy)).hypot(xy);
        let length = |square: f64| square.max(0.0).sqrt();
        Self {
            major: length(middle + spread),
            minor: length(middle - spread),
            direction: angle.sin_cos(),
        }
    }
}

/// An ellipse of at least the shape's minimum width, ready to weight offsets.
pub(super) struct Ellipse {
    shape: FilterShape,
    /// Maps an offset to (u, v).
    inverse: [[f64; 2]; 2],
    /// Half extents of the bounding box.
    reach: [f64; 2],
    /// The shift in x of the middle of a row's chord per pixel in y.
    slant: f64,
    /// Half the longest chord of a row.
    widest: f64,
}

impl Ellipse {
    pub(super) fn new(shape: FilterShape, axes: [[f32; 2]; 2]) -> Self {
        let PrincipalAxes { major, minor, direction: (sin, cos) } = PrincipalAxes::of(axes);
        let least = 0.5 * f64::from(shape.minimum_width());
        let [major, minor] = [major, minor].map(|axis| axis.clamp(least, f64::from(f32::MAX)));
        let reach = [(major * cos).hypot(minor * sin), (major * sin).hypot(minor * cos)];
        Self {
            shape,
            inverse: [[cos / major, sin / major], [-sin / minor, cos / minor]],
            reach,
            slant: (major - minor) * (major + minor) * sin * cos / (reach[1] * reach[1]),
            widest: major * minor / reach[1],
        }
    }

    /// Half extents of the bounding box.
    pub(super) const fn reach(&self) -> [f64; 2] {
        self.reach
    }

    /// The offsets in x between which the ellipse has a weight in the row at
    /// `dy`, and a little more, for rounding.
    #[inline(always)]
    pub(super) fn chord(&self, dy: f64) -> [f64; 2] {
        let height = self.reach[1];
        let half = self.widest * (1.0 - (dy / height) * (dy / height)).max(0.0).sqrt();
        let (middle, margin) = (self.slant * dy, 1e-6 * self.reach[0]);
        [middle - half - margin, middle + half + margin]
    }

    /// The weight at an offset from the centre.
    #[inline(always)]
    pub(super) fn weight(&self, dx: f64, dy: f64) -> f64 {
        let [u, v] = self.inverse.map(|row| row[0] * dx + row[1] * dy);
        self.shape.weight(u.hypot(v))
    }
}
