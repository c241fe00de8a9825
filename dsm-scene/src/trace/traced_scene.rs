//! Acceleration structures of a scene.

use std::sync::Arc;

use dsm_core::{Ray, RayHits, Rgb, SurfaceHit, Transmittance, VolumeSample};
use glam::{DAffine3, DVec3};

use super::bvh::Bvh;
use super::intersection::{HitGeometry, Intersection};
use super::medium::{DensitySample, integral, march};
use super::segment::SegmentTest;
use super::triangle::TriangleTest;
use crate::bounds::Bounds;
use crate::error::Result;
use crate::scene::{Object, Scene, Shape};

/// The error that the optical depth of media may have within a cell of voxels.
const DEPTH_ERROR: f64 = 6e-6;

/// Extinctions above are cut off: they block everything.
const MAX_EXTINCTION: f64 = 1e30;

/// The distance of a computed hit from its surface, as a share of the lengths that
/// it was computed from: 1,024 roundings of `f64`, as slim triangles and slanting
/// rays take a few of them many times.
const ROUNDING: f64 = 512.0 * f64::EPSILON;

/// A scene prepared for ray tracing: a bounding volume hierarchy a shape, in its
/// own space. Objects that move are tested where they are at the ray's time,
/// without boxes around their whole way.
///
/// ```
/// use dsm_core::Ray;
/// use dsm_scene::{TracedScene, builtin_scene};
/// use glam::DVec3;
///
/// let traced = TracedScene::new(&builtin_scene("spinning-sphere")?)?;
/// assert!(traced.is_moving());
/// // Upwards from far above, there is nothing in the way.
/// let ray = Ray::new(DVec3::Y * 1e3, DVec3::Y);
/// assert_eq!(traced.tracer().transmittance::<f32>(&ray), 1.0);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
pub struct TracedScene {
    objects: Vec<TracedObject>,
    /// The largest of [`Object::reach`].
    reach: f64,
}

struct TracedObject {
    object: Object,
    bvh: Option<Arc<Bvh>>,
    /// World to object, for objects that stand still.
    inverse: Option<DAffine3>,
}

/// A surface or strand that a ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    t: f64,
    object: u32,
    primitive: u32,
    opacity: f32,
}

impl TracedScene {
    /// Builds the hierarchies: O(n log n) for n primitives, about 1 µs each.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Malformed`] for an object that [`Object::check`]
    /// refuses.
    pub fn new(scene: &Scene) -> Result<Self> {
        let reach = scene.objects.iter().map(Object::reach).fold(0.0, f64::max);
        let mut built: Vec<(*const Shape, Option<Arc<Bvh>>)> = Vec::new();
        let mut objects = Vec::new();
        for object in &scene.objects {
            let object = object.clone().check()?;
            let shape = Arc::as_ptr(&object.shape);
            let bvh = match built.iter().find(|(other, _)| std::ptr::eq(*other, shape)) {
                Some((_, bvh)) => bvh.clone(),
                None => {
                    let bvh = Bvh::new(&primitive_boxes(&object.shape))?.map(Arc::new);
                    built.push((shape, bvh.clone()));
                    bvh
                }
            };
            let inverse = (!object.is_moving()).then(|| object.to_world(0.0).inverse());
            objects.push(TracedObject { object, bvh, inverse });
        }
        Ok(Self { objects, reach })
    }

    /// The error of the position of a point from rounding alone, if it was computed
    /// in `f64` from `places` and from where things stand: in scene units. A ray
    /// that leaves the point passes over as much.
    pub(crate) fn rounding(&self, places: &[DVec3]) -> f64 {
        let farthest = places.iter().map(|place| place.abs().max_element());
        ROUNDING * farthest.fold(self.reach, f64::max)
    }

    /// A tracer for one thread.
    #[must_use]
    pub fn tracer(&self) -> Tracer<'_> {
        Tracer { scene: self, hits: Vec::new(), samples: Vec::new() }
    }

    /// True if anything moves while the shutter is open.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.objects.iter().any(|object| object.inverse.is_none())
    }

    /// True if there are volumes in it.
    pub(crate) fn has_media(&self) -> bool {
        self.objects.iter().any(|object| matches!(&*object.object.shape, Shape::Volume(_)))
    }

    /// True if any opacity has a colour.
    pub(crate) fn is_coloured(&self) -> bool {
        self.objects.iter().any(|object| !object.object.opacity.is_mono())
    }

    /// The objects that the ray may meet, each with the ray in its space.
    fn in_objects(&self, ray: &Ray) -> impl Iterator<Item = (usize, &TracedObject, Ray)> {
        let ray = *ray;
        let sound = ray.is_sound();
        self.objects.iter().enumerate().filter(move |_| sound).map(move |(index, object)| {
            let inverse =
                object.inverse.unwrap_or_else(|| object.object.to_world(ray.time()).inverse());
            let [near, far] = ray.range();
            let origin = inverse.transform_point3(ray.origin());
            let direction = inverse.transform_vector3(ray.direction());
            (index, object, Ray::new(origin, direction).within(near, far))
        })
    }
}

impl TracedObject {
    /// Calls `meet` with the primitive, t and own opacity of all the surfaces
    /// and strands that the ray meets, in any order, until it returns true.
    fn meet(&self, ray: &Ray, mut meet: impl FnMut(u32, f64, f32) -> bool) {
        let Some(bvh) = &self.bvh else { return };
        let [near, far] = ray.range();
        match &*self.object.shape {
            Shape::Mesh(mesh) => {
                let test = TriangleTest::new(ray);
                bvh.visit(ray, |index| {
                    let corners = mesh.corners(index).map(|corner| corner.as_dvec3());
                    test.crossing(corners).is_some_and(|hit| {
                        let within = near <= hit.t && hit.t < far;
                        within && {
                            let opacity = mesh.opacity(index, hit.u as f32, hit.v as f32);
                            opacity > 0.0 && meet(index as u32, hit.t, opacity)
                        }
                    })
                });
            }
            Shape::Curves(curves) => {
                let test = SegmentTest::new(ray);
                bvh.visit(ray, |index| {
                    let ends = curves.segment(index);
                    let ends = ends.map(|(end, radius)| (end.as_dvec3(), f64::from(radius)));
                    test.crossing(ends, curves.is_joined(index)).is_some_and(|hit| {
                        let within = near <= hit.t && hit.t < far;
                        within && {
                            let opacity = curves.opacity(index, hit.along as f32);
                            opacity > 0.0 && meet(index as u32, hit.t, opacity)
                        }
                    })
                });
            }
            Shape::Volume(_) => {}
        }
    }
}

/// A ray tracer; keeps its memory from one ray to the next. One a thread.
pub struct Tracer<'a> {
    scene: &'a TracedScene,
    hits: Vec<Hit>,
    samples: Vec<DensitySample>,
}

impl Tracer<'_> {
    /// Adds all hits of the ray to `hits`, with t as depth: surfaces and strands
    /// front to back, then media. O(log n + k) for k hits, and O(cells) in media.
    ///
    /// Each triangle that is crossed is a hit, from either side, and each
    /// segment of a curve that the ray passes within its radius. Media are
    /// sampled where the ray leaves cells of voxels, where the optical depth is
    /// exact up to rounding, and often enough between that no cell adds more
    /// than 6·10⁻⁶ to its error.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Core`] if the ray's direction is shorter than 1: t is no
    /// depth then.
    pub fn hits<T: Transmittance>(&mut self, ray: &Ray, hits: &mut RayHits<T>) -> Result<()> {
        self.surfaces(ray, |_, hit| Ok(hits.push_surface(hit)?))?;
        self.media(ray, |column, factor| Ok(hits.push_volume(column, factor)?))
    }

    /// Calls `push` with all surfaces and strands that the ray meets, front to
    /// back.
    pub(crate) fn surfaces<T: Transmittance>(
        &mut self,
        ray: &Ray,
        mut push: impl FnMut(&Hit, SurfaceHit<T>) -> Result<()>,
    ) -> Result<()> {
        self.find(ray);
        for hit in &self.hits {
            let depth = hit.t as f32;
            if depth.is_finite() {
                let object = &self.scene.objects[hit.object as usize].object;
                push(hit, SurfaceHit { depth, opacity: scaled(object.opacity, hit.opacity) })?;
            }
        }
        Ok(())
    }

    /// Finds all surfaces and strands that the ray meets, front to back.
    fn find(&mut self, ray: &Ray) {
        self.hits.clear();
        for (index, object, own) in self.scene.in_objects(ray) {
            object.meet(&own, |primitive, t, opacity| {
                self.hits.push(Hit { t, object: index as u32, primitive, opacity });
                false
            });
        }
        // Equal distances are ordered by what is met, not by how it was found.
        self.hits.sort_unstable_by(|a, b| {
            a.t.total_cmp(&b.t).then((a.object, a.primitive).cmp(&(b.object, b.primitive)))
        });
    }

    /// The first surface or strand behind which the transmittance, by the mean of its
    /// channels, is below `threshold`.
    pub(crate) fn first_below(&mut self, ray: &Ray, threshold: f64) -> Option<Intersection> {
        self.find(ray);
        let mut left = 1.0;
        self.hits.iter().find_map(|hit| {
            let object = &self.scene.objects[hit.object as usize].object;
            left *= 1.0 - f64::from(scaled::<f32>(object.opacity, hit.opacity));
            (left < threshold).then(|| Intersection {
                t: hit.t,
                opacity: scaled(object.opacity, hit.opacity),
                geometry: HitGeometry::of(object, hit.primitive, ray),
            })
        })
    }

    /// Calls `visit` with every object of a medium and the density along every
    /// stretch of the ray that may have any: object after object, each front
    /// to back. Their integral is exact where the ray leaves a cell.
    pub(crate) fn densities(
        &mut self,
        ray: &Ray,
        mut visit: impl FnMut(usize, &Object, &[DensitySample]),
    ) {
        for (index, object, own) in self.scene.in_objects(ray) {
            let Shape::Volume(volume) = &*object.object.shape else { continue };
            march(volume, &own, f64::INFINITY, &mut self.samples, |samples| {
                visit(index, &object.object, samples);
            });
        }
    }

    /// Calls `push` with the extinction along every stretch of the ray that may
    /// have any, and with the distance per unit of t.
    pub(crate) fn media<T: Transmittance>(
        &mut self,
        ray: &Ray,
        mut push: impl FnMut(&[VolumeSample<T>], f64) -> Result<()>,
    ) -> Result<()> {
        // Rounding may leave the length of a unit direction below 1.
        let length = ray.direction().length();
        let factor = if (length - 1.0).abs() < 1e-9 { 1.0 } else { length };
        let mut column: Vec<VolumeSample<T>> = Vec::new();
        for (_, object, own) in self.scene.in_objects(ray) {
            let Shape::Volume(volume) = &*object.object.shape else { continue };
            let mut result = Ok(());
            let within = DEPTH_ERROR / (f64::from(object.object.density) * factor);
            march(volume, &own, within, &mut self.samples, |samples| {
                column.clear();
                column.extend(samples.iter().filter(|s| s.t <= f64::from(f32::MAX)).map(|s| {
                    let extinction = f64::from(s.density) * f64::from(object.object.density);
                    let extinction = extinction.min(MAX_EXTINCTION) as f32;
                    let extinction = scaled::<T>(object.object.opacity, extinction);
                    VolumeSample { depth: s.t as f32, extinction }
                }));
                if result.is_ok() {
                    result = push(&column, factor);
                }
            });
            result?;
        }
        Ok(())
    }

    /// The normal in the world of the surface that was met; of a segment of a strand that
    /// of the ribbon which faces the ray.
    pub(crate) fn normal(&self, ray: &Ray, hit: &Hit) -> Option<DVec3> {
        let object = &self.scene.objects[hit.object as usize].object;
        if let Shape::Curves(curves) = &*object.shape {
            let to_world = object.to_world(ray.time());
            let ends = curves.segment(hit.primitive as usize);
            let [a, b] = ends.map(|(end, _)| to_world.transform_point3(end.as_dvec3()));
            let (along, away) = ((b - a).try_normalize()?, ray.direction().try_normalize()?);
            return (away - along * away.dot(along)).try_normalize();
        }
        match HitGeometry::of(object, hit.primitive, ray) {
            HitGeometry::Surface { normal } => normal,
            HitGeometry::Strand { .. } => None,
        }
    }

    /// The transmittance of the ray over its range. Needs no order, and ends where
    /// nothing is left.
    #[must_use]
    pub fn transmittance<T: Transmittance>(&mut self, ray: &Ray) -> T {
        let mut left = T::CLEAR.to_sum();
        let blocked = |left: &T::Sum| left.as_ref().iter().all(|&part| part == 0.0);
        for (_, object, own) in self.scene.in_objects(ray) {
            object.meet(&own, |_, _, opacity| {
                let opacity = scaled::<T>(object.object.opacity, opacity).to_sum();
                let kept = left.as_mut().iter_mut().zip(opacity.as_ref());
                kept.for_each(|(part, opacity)| *part *= 1.0 - opacity);
                blocked(&left)
            });
            if blocked(&left) {
                return T::BLOCKED;
            }
            let Shape::Volume(volume) = &*object.object.shape else { continue };
            let mut density = 0.0;
            march(volume, &own, f64::INFINITY, &mut self.samples, |samples| {
                density += integral(samples);
            });
            let depth = density * f64::from(object.object.density) * ray.direction().length();
            let colour = scaled::<T>(object.object.opacity, 1.0).to_sum();
            let kept = left.as_mut().iter_mut().zip(colour.as_ref());
            kept.for_each(|(part, colour)| *part *= (-depth * colour).exp());
        }
        T::from_sum(left)
    }
}

/// A scene's colour in a map's channels: the mean of three in one.
pub(crate) fn scaled<T: Transmittance>(colour: Rgb, factor: f32) -> T {
    if T::CHANNELS == Rgb::CHANNELS {
        T::from_channels(|channel| colour.channel(channel) * factor)
    } else if colour.is_mono() {
        T::splat(colour.red * factor)
    } else {
        let sum: f32 = (0..Rgb::CHANNELS).map(|channel| colour.channel(channel)).sum();
        T::splat((sum / Rgb::CHANNELS as f32).min(1.0) * factor)
    }
}

/// One box a primitive.
fn primitive_boxes(shape: &Shape) -> Vec<Bounds> {
    match shape {
        Shape::Mesh(mesh) => (0..mesh.triangles().len())
            .map(|index| Bounds::of_balls(mesh.corners(index).map(|corner| (corner, 0.0))))
            .collect(),
        Shape::Curves(curves) => (0..curves.segments().len())
            .map(|index| Bounds::of_balls(curves.segment(index)))
            .collect(),
        Shape::Volume(_) => Vec::new(),
    }
}
