//! Filtered lookups at points of the world: the query of a renderer.

use glam::DVec2;

use super::bias::{Bias, BiasSummary};
use super::footprint::Footprint;
use super::pyramid::{LevelChoice, Pyramid};
use super::receiver::Receiver;
use super::visibility_field::VisibilityField;
use crate::camera::map_info::MapInfo;
use crate::camera::projection::MapProjection;
use crate::error::Result;
use crate::shadow::{Facing, ShadedPoint};
use crate::transmittance::Transmittance;

/// The steepest surface that an automatic bias follows, in pixel sides of depth
/// a pixel: 86 degrees.
const STEEPEST: f64 = 16.0;

/// The steepest strand that an automatic bias follows, in pixel sides of depth a
/// pixel. Steeper ones fill less of a pixel, so that less of them is in their own
/// way, and others stand close.
const STEEPEST_STRAND: f64 = 1.5;

/// Pixel sides that are added to an automatic bias: the depth of surfaces that
/// are a little curved, and of strands beside their middle.
const SLACK: f64 = 0.25;

/// The query of a map for visibility at points of the world: projection, footprint,
/// level and depth bias.
///
/// ```
/// use dsm_core::detail::ShadowLookup;
/// use dsm_core::{Facing, MapInfo, Projection, ShadedPoint, View};
/// use glam::DVec3;
///
/// let view = View { eye: DVec3::Y * 5.0, target: DVec3::ZERO, up: DVec3::X };
/// let raster = view.raster(Projection::Perspective { fov: 90.0 }, [64, 64])?;
/// let info = MapInfo::new().with_camera(raster.shadow_camera());
/// let lookup = ShadowLookup::new(&info, [64, 64])?;
///
/// let point = ShadedPoint { position: DVec3::ZERO, facing: Facing::Light, seed: 0 };
/// let receiver = lookup.receiver(&point, 1).unwrap();
/// assert_eq!((receiver.position, receiver.depth), ([32.0, 32.0], 5.0));
/// // Behind the light there is no shadow.
/// let behind = ShadedPoint { position: DVec3::Y * 6.0, ..point };
/// assert_eq!(lookup.receiver(&behind, 1), None);
/// # Ok::<(), dsm_core::Error>(())
/// ```
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
    /// A lookup of the pixels that contain the points, in the finest level, with an
    /// automatic bias. The map has `size` pixels.
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

    /// Sets the footprint, in pixels of level 0.
    #[must_use]
    pub const fn with_footprint(self, footprint: Footprint) -> Self {
        Self { footprint, ..self }
    }

    /// Sets the level.
    #[must_use]
    pub const fn with_level(self, level: LevelChoice) -> Self {
        Self { level, ..self }
    }

    /// Sets the depth bias.
    #[must_use]
    pub const fn with_bias(self, bias: Bias) -> Self {
        Self { bias, ..self }
    }

    /// The level that is read.
    #[must_use]
    pub const fn level(&self) -> LevelChoice {
        self.level
    }

    /// The receiver of `point` in a map of `levels` levels; `None` behind the
    /// camera and where the projection is not finite: lit.
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
        let (gradient, steepest, faces) = match facing {
            Facing::Light => return (0.0, DVec2::ZERO),
            Facing::Surface(normal) => {
                let plane = self.projection.plane_gradient(position, normal);
                let (gradient, faces) = plane.unwrap_or((DVec2::NAN, true));
                (gradient, STEEPEST, faces)
            }
            Facing::Strand(along) => {
                let gradient = self.projection.line_gradient(position, along);
                (gradient.unwrap_or(DVec2::NAN), STEEPEST_STRAND, true)
            }
        };
        let side = self.projection.pixel_size(position);
        let slope = gradient.abs().element_sum();
        let (slope, gradient) = if slope <= steepest * side {
            (slope, gradient)
        } else {
            // Seen along its surface, nobody knows where it goes.
            let gradient = gradient * (steepest * side / slope);
            (steepest * side, if gradient.is_finite() { gradient } else { DVec2::ZERO })
        };
        // A strand does not go on beside itself.
        let is_strand = matches!(facing, Facing::Strand(_));
        let gradient = if is_strand { DVec2::ZERO } else { gradient };
        let bias = (slope + SLACK * side) * self.half_pixel * self.coarseness(levels);
        if !bias.is_finite() {
            return (0.0, DVec2::ZERO);
        }
        (if faces { bias } else { -bias }, gradient)
    }

    /// The side of the coarsest pixel that is read in a map of `levels` levels, in
    /// pixels of level 0.
    fn coarseness(&self, levels: usize) -> f64 {
        let level = match self.level {
            LevelChoice::Fixed(level) => level,
            LevelChoice::Auto => self.footprint.level(),
        };
        level.ceil().max(0.0).min(levels.saturating_sub(1) as f64).exp2()
    }

    /// Appends the visibility at every point to `lights`, in order: 1 outside the
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::baker::Baker;
    use crate::bake::settings::BakeSettings;
    use crate::camera::shadow_camera::ShadowCamera;
    use crate::error::Error;
    use crate::field::map::DeepMap;
    use crate::filter::{Filter, FilterShape};
    use crate::hits::hit::{RayHits, SurfaceHit};
    use crate::hits::hit_source::RaySource;
    use crate::hits::tile_samples::SamplePoint;
    use glam::{DMat4, DVec3, DVec4};

    const SIZE: u32 = 32;

    /// At the origin, looks down −z; at depth z the map is 2 z wide, or always
    /// 2.
    fn camera(perspective: bool) -> ShadowCamera {
        let (last, row_w) =
            if perspective { ([-0.5, -0.5], DVec4::NEG_Z) } else { ([0.0, 0.0], DVec4::W) };
        let shift = if perspective { 0.0 } else { 0.5 };
        let ndc = DMat4::from_rows(
            DVec4::new(0.5, 0.0, last[0], shift),
            DVec4::new(0.0, -0.5, last[1], shift),
            DVec4::NEG_Z,
            row_w,
        );
        ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(ndc) }
    }

    /// The depth of the plane through (0, 0, −4) along the ray of a raster
    /// point, and the direction of that ray per depth and its origin.
    fn meet(normal: DVec3, [x, y]: [f64; 2], perspective: bool) -> (f64, DVec3) {
        let half = f64::from(SIZE) / 2.0;
        let across = DVec2::new(x / half - 1.0, 1.0 - y / half);
        let (origin, direction) = if perspective {
            (DVec3::ZERO, across.extend(-1.0))
        } else {
            (across.extend(0.0), DVec3::NEG_Z)
        };
        let t = normal.dot(DVec3::new(0.0, 0.0, -4.0) - origin) / normal.dot(direction);
        (t, origin + direction * t)
    }

    /// The map of an opaque plane.
    fn plane(normal: DVec3, perspective: bool) -> FilteredMap {
        let hits = |point: SamplePoint, hits: &mut RayHits<f32>| {
            let (depth, _) = meet(normal, [point.x, point.y], perspective);
            if depth > 0.0 {
                hits.push_surface(SurfaceHit { depth: depth as f32, opacity: 1.0 })?;
            }
            Ok::<_, Error>(())
        };
        let mut settings = BakeSettings::new([SIZE; 2]).unwrap();
        settings.tile_size = SIZE;
        settings.camera = Some(camera(perspective));
        let baker = Baker::<f32, _>::new(RaySource(hits), settings).unwrap();
        let info = baker.info();
        let tile = baker.tile([0, 0]).unwrap();
        FilteredMap { map: DeepMap::new(info, tile.pixels().clone()) }
    }

    struct FilteredMap {
        map: DeepMap<f32>,
    }

    impl FilteredMap {
        fn light(&self, footprint: Footprint, bias: Bias, point: ShadedPoint) -> f32 {
            let lookup = ShadowLookup::new(self.map.info(), [SIZE; 2]).unwrap();
            let lookup = lookup.with_footprint(footprint).with_bias(bias);
            let pyramid = Pyramid::new(vec![&self.map]).unwrap();
            let mut lights = Vec::new();
            let Ok(biases) = lookup.lights(&pyramid, &[point], &mut lights);
            assert_eq!(biases.points, 1);
            lights[0]
        }
    }

    #[test]
    fn a_plane_does_not_shade_itself_and_shades_what_lies_behind() {
        let filter = |shape, width| Footprint::Isotropic(Filter::new(shape, width).unwrap());
        let footprints =
            [Footprint::Point, filter(FilterShape::Tent, 2.0), filter(FilterShape::Box, 4.0)];
        let mut shaded_without = 0;
        for perspective in [true, false] {
            for tilt in [[0.0, 0.0], [0.7, 0.2], [-0.3, 2.0], [1.5, -1.5]] {
                let normal = DVec3::new(tilt[0], tilt[1], 1.0).normalize();
                let map = plane(normal, perspective);
                for (step, footprint) in (0..60).flat_map(|step| footprints.map(|f| (step, f))) {
                    let at = [8.1 + 0.27 * f64::from(step), 23.9 - 0.26 * f64::from(step)];
                    let (depth, position) = meet(normal, at, perspective);
                    if !(0.5..6.0).contains(&depth) {
                        continue;
                    }
                    let point = |shift: f64, facing| ShadedPoint {
                        position: position - normal * shift,
                        facing,
                        seed: 0,
                    };
                    let lit = Facing::Surface(normal);
                    let light = |bias, point| map.light(footprint, bias, point);
                    assert_eq!(light(Bias::Auto, point(0.0, lit)), 1.0, "{tilt:?} {at:?}");
                    let dark = Facing::Surface(-normal);
                    // In perspective a steep plane's depth is not linear over
                    // the pixels of a wide filter.
                    let own = light(Bias::Auto, point(0.0, dark));
                    assert!(own < 0.25, "{tilt:?} {at:?} {own}");
                    // A few pixels further back it is dark whatever it faces.
                    let side = if perspective { depth / 16.0 } else { 1.0 / 16.0 };
                    assert_eq!(light(Bias::Auto, point(3.0 * side, lit)), 0.0, "{tilt:?}");
                    shaded_without +=
                        u32::from(light(Bias::Depth(0.0), point(0.0, Facing::Light)) < 0.9);
                }
            }
        }
        assert!(shaded_without > 500, "{shaded_without}");
    }

    #[test]
    fn strands_have_the_bias_of_their_slope() {
        let info = MapInfo::new().with_camera(camera(true));
        let lookup = ShadowLookup::new(&info, [SIZE; 2]).unwrap();
        let side = 4.0 / 16.0;
        let bias = |along: DVec3| {
            let position = DVec3::new(0.0, 0.0, -4.0);
            let facing = Facing::Strand(along.normalize());
            let receiver = lookup.receiver(&ShadedPoint { position, facing, seed: 0 }, 1).unwrap();
            f64::from(receiver.bias) / side
        };
        assert!((bias(DVec3::X) - 0.5 * SLACK).abs() < 1e-6);
        assert!((bias(DVec3::new(1.0, 0.0, -0.8)) - 0.5 * (0.8 + SLACK)).abs() < 1e-6);
        for steep in [DVec3::new(1.0, 0.0, -2.0), DVec3::NEG_Z] {
            assert!((bias(steep) - 0.5 * (STEEPEST_STRAND + SLACK)).abs() < 1e-6);
        }
        let free = ShadedPoint { position: DVec3::NEG_Z, facing: Facing::Light, seed: 0 };
        assert_eq!(lookup.receiver(&free, 1).unwrap().bias, 0.0);
        assert_eq!(lookup.receiver(&ShadedPoint { position: DVec3::Z, ..free }, 1), None);
        assert_eq!(lookup.receiver(&ShadedPoint { position: DVec3::NAN, ..free }, 1), None);
        let odd = ShadedPoint { facing: Facing::Surface(DVec3::NAN), ..free };
        assert!(lookup.receiver(&odd, 1).unwrap().bias.is_finite());
    }

    #[test]
    fn coarser_levels_have_larger_biases() {
        let info = MapInfo::new().with_camera(camera(true));
        let lookup = ShadowLookup::new(&info, [SIZE; 2]).unwrap();
        let point = ShadedPoint {
            position: DVec3::new(0.0, 0.0, -4.0),
            facing: Facing::Surface(DVec3::new(0.6, 0.0, 0.8)),
            seed: 0,
        };
        let bias = |level, levels| lookup.with_level(level).receiver(&point, levels).unwrap().bias;
        let finest = bias(LevelChoice::FINEST, 6);
        assert_eq!(bias(LevelChoice::Fixed(1.5), 6), 4.0 * finest);
        assert_eq!(bias(LevelChoice::Fixed(3.0), 2), 2.0 * finest);
        let wide = Footprint::Isotropic(Filter::new(FilterShape::Box, 8.0).unwrap());
        let lookup = lookup.with_footprint(wide).with_level(LevelChoice::Auto);
        assert_eq!(lookup.receiver(&point, 6).unwrap().bias, 4.0 * finest);
    }
}
