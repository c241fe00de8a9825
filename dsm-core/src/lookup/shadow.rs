//! Filtered lookups for points of the world: what a renderer asks.

use std::sync::{Mutex, PoisonError};

use glam::{DVec2, DVec3};

use super::footprint::Footprint;
use super::projection::MapProjection;
use super::pyramid::{LevelChoice, Pyramid};
use super::receiver::Receiver;
use crate::{
    AreaLight, Facing, LightVisibility, MapInfo, Result, ShadedPoint, Transmittance,
    VisibilityField,
};

/// The steepest surface or strand that an automatic bias follows, in pixel
/// sides of depth a pixel: 86 degrees.
const STEEPEST: f64 = 16.0;

/// Pixel sides that are added to an automatic bias: the depth of surfaces that
/// are a little curved, and of strands beside their middle.
const SLACK: f64 = 0.25;

/// What is taken off a point's depth before the map is asked, so that what
/// the point lies on does not shade it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bias {
    /// A depth in scene units, for all points. All pixels under the filter are
    /// asked at one depth.
    Depth(f32),
    /// What the slope of the point's surface or strand asks for: the pixels
    /// under the filter are asked at the depth of its plane in each, less half
    /// of what that changes over the samples of a pixel, and a quarter of a
    /// pixel's side. Steeper than 16 pixel sides a pixel counts as that. The
    /// bias is negative for a surface that is seen from the side that the light
    /// is not on: it shades itself. Points that lie on nothing have none.
    Auto,
}

/// The biases that points had, in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasSummary {
    /// The number of points in the map.
    pub points: u64,
    /// The least.
    pub least: f64,
    /// The sum.
    pub sum: f64,
    /// The most.
    pub most: f64,
}

impl Default for BiasSummary {
    fn default() -> Self {
        Self { points: 0, least: f64::INFINITY, sum: 0.0, most: f64::NEG_INFINITY }
    }
}

impl BiasSummary {
    fn add(&mut self, bias: f32) {
        let bias = f64::from(bias);
        self.merge(Self { points: 1, least: bias, sum: bias, most: bias });
    }

    /// Adds the biases of other points.
    pub fn merge(&mut self, other: Self) {
        self.points += other.points;
        self.least = self.least.min(other.least);
        self.sum += other.sum;
        self.most = self.most.max(other.most);
    }

    /// The mean; `None` if there are no points.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.points > 0).then(|| self.sum / self.points as f64)
    }
}

/// How a map is asked for the light at points of the world: where they lie in
/// it, what is averaged around them, in which level, with which bias.
#[derive(Clone, Copy, Debug)]
pub struct ShadowLookup {
    projection: MapProjection,
    footprint: Footprint,
    level: LevelChoice,
    bias: Bias,
    /// Half the width of the filter that pixels were sampled with.
    half_pixel: f64,
}

impl ShadowLookup {
    /// Looks up the pixels that contain the points, in the finest level, with
    /// an automatic bias. The map has `size` pixels.
    ///
    /// # Errors
    ///
    /// [`Error::Camera`](crate::Error::Camera) if the map has no camera.
    pub fn new(info: &MapInfo, size: [u32; 2]) -> Result<Self> {
        let width = info.filter.map_or(1.0, |filter| f64::from(filter.width()));
        Ok(Self {
            projection: MapProjection::new(info, size)?,
            footprint: Footprint::Point,
            level: LevelChoice::FINEST,
            bias: Bias::Auto,
            half_pixel: 0.5 * width,
        })
    }

    /// The same with another footprint, in pixels of level 0.
    #[must_use]
    pub const fn with_footprint(self, footprint: Footprint) -> Self {
        Self { footprint, ..self }
    }

    /// The same in another level.
    #[must_use]
    pub const fn with_level(self, level: LevelChoice) -> Self {
        Self { level, ..self }
    }

    /// The same with another bias.
    #[must_use]
    pub const fn with_bias(self, bias: Bias) -> Self {
        Self { bias, ..self }
    }

    /// The level that is asked.
    #[must_use]
    pub const fn level(&self) -> LevelChoice {
        self.level
    }

    /// Where a map of `levels` levels is asked for the light at `point`; `None`
    /// behind the camera and where the projection is not finite: lit.
    #[must_use]
    pub fn receiver(&self, point: &ShadedPoint, levels: usize) -> Option<Receiver> {
        let raster = self.projection.project(point.position)?;
        let [x, y, depth] = raster.to_array().map(|coordinate| coordinate as f32);
        let plain = Receiver::new([x, y], depth);
        Some(match self.bias {
            Bias::Depth(bias) => Receiver { bias, ..plain },
            Bias::Auto => {
                let (bias, gradient) = self.automatic(point, levels);
                let depth_gradient = gradient.to_array().map(|change| change as f32);
                Receiver { bias: bias as f32, depth_gradient, ..plain }
            }
        })
    }

    /// The bias for a point, and how its depth changes a pixel.
    fn automatic(&self, point: &ShadedPoint, levels: usize) -> (f64, DVec2) {
        let ShadedPoint { position, facing, .. } = *point;
        let (gradient, faces) = match facing {
            Facing::Light => return (0.0, DVec2::ZERO),
            Facing::Surface(normal) => {
                self.projection.plane_gradient(position, normal).unwrap_or((DVec2::NAN, true))
            }
            Facing::Strand(along) => {
                let gradient = self.projection.line_gradient(position, along);
                (gradient.unwrap_or(DVec2::NAN), true)
            }
        };
        let side = self.projection.pixel_size(position);
        let slope = gradient.abs().element_sum();
        let (slope, gradient) = if slope <= STEEPEST * side {
            (slope, gradient)
        } else {
            // Nobody knows where it goes.
            let steepest = gradient * (STEEPEST * side / slope);
            (STEEPEST * side, if steepest.is_finite() { steepest } else { DVec2::ZERO })
        };
        let bias = (slope + SLACK * side) * self.half_pixel * self.coarseness(levels);
        if !bias.is_finite() {
            return (0.0, DVec2::ZERO);
        }
        (if faces { bias } else { -bias }, gradient)
    }

    /// How many pixels of level 0 a side of the coarsest pixel that is read
    /// has, in a map of `levels` levels.
    fn coarseness(&self, levels: usize) -> f64 {
        let level = match self.level {
            LevelChoice::Fixed(level) => level,
            LevelChoice::Auto => self.footprint.level(),
        };
        level.ceil().max(0.0).min(levels.saturating_sub(1) as f64).exp2()
    }

    /// Appends the light at every point to `lights`, in order: 1 outside the
    /// map, behind the camera and for NaN. Returns the biases.
    ///
    /// # Errors
    ///
    /// The first error of a level; `lights` then holds what came before.
    pub fn lights<F: VisibilityField>(
        &self,
        pyramid: &Pyramid<F>,
        points: &[ShadedPoint],
        lights: &mut Vec<F::Value>,
    ) -> std::result::Result<BiasSummary, F::Error> {
        let mut biases = BiasSummary::default();
        lights.reserve(points.len());
        for point in points {
            let light = match self.receiver(point, pyramid.levels().len()) {
                Some(receiver) => {
                    biases.add(receiver.bias);
                    pyramid.lookup(&receiver, &self.footprint, self.level)?
                }
                None => F::Value::CLEAR,
            };
            lights.push(light);
        }
        Ok(biases)
    }
}

/// The shadows of one map that is whole in memory: filtered lookups as a
/// shadow method. The light's area is not looked at: a map holds what one point
/// sees.
///
/// ```
/// use dsm_core::{
///     AreaLight, DeepMap, FilteredShadow, LightVisibility, MapInfo, PixelListsBuilder, Pyramid,
///     ShadowCamera, ShadowLookup, Vertex,
/// };
/// use glam::{DVec3, Mat4, Vec4};
///
/// // A light at the origin that looks down −z onto one pixel, which is blocked
/// // at depth 2.
/// let ndc = Mat4::from_rows(
///     Vec4::new(0.5, 0.0, -0.5, 0.0),
///     Vec4::new(0.0, -0.5, -0.5, 0.0),
///     Vec4::NEG_Z,
///     Vec4::NEG_Z,
/// );
/// let camera = ShadowCamera { world_to_camera: Some(Mat4::IDENTITY), world_to_ndc: Some(ndc) };
/// let info = MapInfo { camera: Some(camera), ..MapInfo::default() };
/// let mut pixels = PixelListsBuilder::new(1, 1);
/// pixels.push(Vertex::new(2.0, 1.0));
/// pixels.push(Vertex::new(2.0, 0.25));
/// pixels.finish_pixel()?;
///
/// let lookup = ShadowLookup::new(&info, [1, 1])?;
/// let map = DeepMap::new(info, pixels.finish()?);
/// let shadow = FilteredShadow::new(Pyramid::new(vec![map])?, lookup);
/// let light = AreaLight::point(DVec3::ZERO);
/// assert_eq!(shadow.visibility(DVec3::new(0.2, 0.1, -1.0), &light, 0), Ok(1.0));
/// assert_eq!(shadow.visibility(DVec3::new(0.2, 0.1, -3.0), &light, 0), Ok(0.25));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Debug)]
pub struct FilteredShadow<F> {
    pyramid: Pyramid<F>,
    lookup: ShadowLookup,
    biases: Mutex<BiasSummary>,
}

impl<F: VisibilityField> FilteredShadow<F> {
    /// Asks the levels of `pyramid` as `lookup` says.
    #[must_use]
    pub fn new(pyramid: Pyramid<F>, lookup: ShadowLookup) -> Self {
        Self { pyramid, lookup, biases: Mutex::default() }
    }

    /// The biases of all points so far.
    #[must_use]
    pub fn biases(&self) -> BiasSummary {
        *self.biases.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<F: VisibilityField + Sync> LightVisibility for FilteredShadow<F> {
    type Value = F::Value;
    type Error = F::Error;

    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> std::result::Result<F::Value, F::Error> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        let mut values = Vec::with_capacity(1);
        self.visibilities(&[point], light, &mut values)?;
        Ok(values.pop().unwrap_or(F::Value::CLEAR))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        _: &AreaLight,
        values: &mut Vec<F::Value>,
    ) -> std::result::Result<(), F::Error> {
        let biases = self.lookup.lights(&self.pyramid, points, values)?;
        self.biases.lock().unwrap_or_else(PoisonError::into_inner).merge(biases);
        Ok(())
    }
}
