//! Filtered shadow lookups (Lokovic & Veach 2000, §3.4):
//! V(x, y, z) = Σ wᵢⱼ Vᵢⱼ(z) / Σ wᵢⱼ over the pixels that the filter reaches.

use crate::{Filter, FilterShape, Transmittance};

/// Something that has a visibility function in every pixel: a map in memory,
/// the tiles of a file, a layered map's first run.
pub trait VisibilityField {
    /// Mono or coloured.
    type Value: Transmittance;
    /// Why a pixel can't be had; [`std::convert::Infallible`] in memory.
    type Error;

    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// V(`depth`) of `pixel`, which lies inside the field.
    ///
    /// # Errors
    ///
    /// If the pixel can't be read.
    fn evaluate(&self, pixel: [u32; 2], depth: f32) -> Result<Self::Value, Self::Error>;
}

/// The pixels that a lookup averages, and how it weights them.
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
        /// How the weight falls off from the centre to the rim.
        shape: FilterShape,
        /// The two half-axes, in pixels.
        axes: [[f32; 2]; 2],
    },
}

/// Where to ask for shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Raster position: pixel (i, j) covers [i, i+1) × [j, j+1).
    pub position: [f32; 2],
    /// Depth, in scene units.
    pub depth: f32,
    /// Taken off the depth, in scene units (§4 on bias).
    pub bias: f32,
    /// How the receiver's depth changes per pixel in x and y: each pixel is
    /// asked at the depth of the receiver's plane there. Zero asks all pixels
    /// at one depth.
    pub depth_gradient: [f32; 2],
}

impl Receiver {
    /// A receiver without bias that faces the light.
    #[must_use]
    pub const fn new(position: [f32; 2], depth: f32) -> Self {
        Self { position, depth, bias: 0.0, depth_gradient: [0.0; 2] }
    }
}

/// The light that reaches `receiver`, averaged over `footprint`.
///
/// Pixels outside the field have no weight, and the rest are normalised. A
/// receiver outside the field, at a depth ≤ 0 or with a NaN is lit: 1.
/// O(p log n) for p pixels of n vertices; no allocation.
///
/// ```
/// use dsm_core::{
///     DeepMap, Filter, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Vertex,
///     filtered_lookup,
/// };
///
/// // The left pixel is blocked at depth 1, the right one is clear.
/// let mut pixels = PixelListsBuilder::new(2, 1);
/// pixels.push(Vertex::new(1.0, 1.0));
/// pixels.push(Vertex::new(1.0, 0.0));
/// pixels.finish_pixel()?;
/// pixels.finish_pixel()?;
/// let map = DeepMap::new(MapInfo::default(), pixels.finish()?);
///
/// let footprint = Footprint::Isotropic(Filter::new(FilterShape::Box, 2.0)?);
/// let light = filtered_lookup(&map, &Receiver::new([1.0, 0.5], 3.0), &footprint);
/// assert_eq!(light, Ok(0.5));
/// # Ok::<(), dsm_core::Error>(())
/// ```
///
/// # Errors
///
/// The first error of `field`.
pub fn filtered_lookup<F: VisibilityField>(
    field: &F,
    receiver: &Receiver,
    footprint: &Footprint,
) -> Result<F::Value, F::Error> {
    let [width, height] = field.size();
    let [x, y] = receiver.position.map(f64::from);
    let inside = x >= 0.0 && y >= 0.0 && x < f64::from(width) && y < f64::from(height);
    if !inside || receiver.depth <= 0.0 || receiver.depth.is_nan() {
        return Ok(F::Value::CLEAR);
    }
    let own = [x as u32, y as u32];
    let average = match *footprint {
        Footprint::Point => None,
        Footprint::Isotropic(filter) => {
            let scale = 2.0 / f64::from(filter.width());
            let shape = filter.shape();
            let reach = [0.5 * f64::from(filter.width()); 2];
            weighted_average(field, receiver, reach, |dy| {
                let row = shape.profile(dy * scale);
                move |dx| row * shape.profile(dx * scale)
            })?
        }
        Footprint::Elliptical { shape, axes } => {
            let ellipse = &Ellipse::new(shape, axes);
            weighted_average(field, receiver, ellipse.reach, |dy| move |dx| ellipse.weight(dx, dy))?
        }
    };
    match average {
        Some(average) => Ok(average),
        // A thin ellipse may miss every pixel centre.
        None => evaluate_at(field, receiver, own),
    }
}

/// One pixel's value at the depth of the receiver's plane over its centre.
#[inline(always)]
fn evaluate_at<F: VisibilityField>(
    field: &F,
    receiver: &Receiver,
    pixel: [u32; 2],
) -> Result<F::Value, F::Error> {
    let offset = |axis: usize| f64::from(pixel[axis]) + 0.5 - f64::from(receiver.position[axis]);
    let plane = f64::from(receiver.depth)
        + f64::from(receiver.depth_gradient[0]) * offset(0)
        + f64::from(receiver.depth_gradient[1]) * offset(1);
    let depth = (plane - f64::from(receiver.bias)) as f32;
    if depth > 0.0 { field.evaluate(pixel, depth) } else { Ok(F::Value::CLEAR) }
}

/// The weighted average over the pixels whose centres lie within `reach`, on
/// half-open intervals; `None` if all have weight 0. `row_weight` gives, for
/// the offset of a row, the weights along it.
fn weighted_average<F: VisibilityField, W: Fn(f64) -> f64>(
    field: &F,
    receiver: &Receiver,
    reach: [f64; 2],
    row_weight: impl Fn(f64) -> W,
) -> Result<Option<F::Value>, F::Error> {
    let size = field.size();
    let centre = receiver.position.map(f64::from);
    let pixels = |axis: usize| {
        let end = |edge: f64| ((edge - 0.5).floor() + 1.0).clamp(0.0, f64::from(size[axis]));
        end(centre[axis] - reach[axis]) as u32..end(centre[axis] + reach[axis]) as u32
    };
    let mut total = 0.0;
    let mut sum = F::Value::sum_from_channels(|_| 0.0);
    for row in pixels(1) {
        let weight = row_weight(f64::from(row) + 0.5 - centre[1]);
        for column in pixels(0) {
            let weight = weight(f64::from(column) + 0.5 - centre[0]);
            if weight > 0.0 {
                let value = evaluate_at(field, receiver, [column, row])?;
                total += weight;
                for (channel, sum) in sum.as_mut().iter_mut().enumerate() {
                    *sum += weight * f64::from(value.channel(channel));
                }
            }
        }
    }
    let average = |channel: usize| (sum.as_ref()[channel] / total) as f32;
    Ok((total > 0.0).then(|| F::Value::from_channels(average)))
}

/// An ellipse of at least the shape's minimum width, ready to weight offsets.
struct Ellipse {
    shape: FilterShape,
    /// Maps an offset to (u, v).
    inverse: [[f64; 2]; 2],
    /// Half extents of the bounding box.
    reach: [f64; 2],
}

impl Ellipse {
    fn new(shape: FilterShape, axes: [[f32; 2]; 2]) -> Self {
        let [a, b] = axes.map(|axis| axis.map(f64::from));
        // Principal axes: eigenvectors of A Aᵀ for A = [a b].
        let (xx, xy, yy) =
            (a[0] * a[0] + b[0] * b[0], a[0] * a[1] + b[0] * b[1], a[1] * a[1] + b[1] * b[1]);
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sin, cos) = angle.sin_cos();
        let middle = 0.5 * (xx + yy);
        let spread = (0.5 * (xx - yy)).hypot(xy);
        let least = 0.5 * f64::from(shape.minimum_width());
        let widened = |square: f64| square.max(0.0).sqrt().clamp(least, f64::from(f32::MAX));
        let (major, minor) = (widened(middle + spread), widened(middle - spread));
        Self {
            shape,
            inverse: [[cos / major, sin / major], [-sin / minor, cos / minor]],
            reach: [(major * cos).hypot(minor * sin), (major * sin).hypot(minor * cos)],
        }
    }

    fn weight(&self, dx: f64, dy: f64) -> f64 {
        let [u, v] = self.inverse.map(|row| row[0] * dx + row[1] * dy);
        self.shape.weight(u.hypot(v))
    }
}
