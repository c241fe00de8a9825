//! Hits against oracles that look at every primitive.

use std::sync::Arc;

use dsm_core::{
    HitSource, LightExtent, PixelSampling, Projection, Ray, RayHits, Rgb, TileHits, TileSamples,
    View,
};
use dsm_scene::detail::SceneHitSource;
use dsm_scene::{
    Curves, Light, Motion, Object, Scene, Shape, TracedScene, Transform, TriangleMesh,
    builtin_scene,
};
use glam::{DMat3, DVec3, Vec3};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::support::{config, real_file};

/// Where the line crosses the triangle, by Cramer's rule; `None` too where it
/// passes an edge so closely that rounding decides.
fn triangle_oracle(ray: &Ray, corners: [DVec3; 3]) -> (Option<f64>, bool) {
    let [a, b, c] = corners;
    let matrix = DMat3::from_cols(b - a, c - a, -ray.direction());
    let determinant = matrix.determinant();
    let size = (b - a).length() * (c - a).length() * ray.direction().length();
    if determinant.abs() < 1e-9 * size {
        return (None, true);
    }
    let solution = matrix.inverse() * (ray.origin() - a);
    let least = solution.x.min(solution.y).min(1.0 - solution.x - solution.y);
    ((least > 0.0).then_some(solution.z), least.abs() < 1e-7)
}

/// Where the ray meets a strand: for each stretch within its radius of the line one
/// depth, found by walking along the strand in a basis that looks along the ray.
/// A flag tells depths that rounding decides, or that may not be there.
fn strand_oracle(ray: &Ray, points: &[(DVec3, f64)]) -> Vec<(f64, bool)> {
    let direction = ray.direction().normalize();
    let (x, y) = direction.any_orthonormal_pair();
    let basis = DMat3::from_cols(x, y, direction).transpose();
    let seen: Vec<_> = points.iter().map(|&(p, r)| (basis * (p - ray.origin()), r)).collect();
    let margin = |place: DVec3, radius: f64| {
        if radius > 0.0 { radius - place.truncate().length() } else { f64::NEG_INFINITY }
    };
    let mut met = Vec::new();
    let mut within = false;
    for ends in seen.windows(2) {
        let [(a, a_radius), (b, b_radius)] = [ends[0], ends[1]];
        let (from, step) = (a.truncate(), (b - a).truncate());
        let approach = if step.length_squared() < 1e-24 {
            0.0
        } else {
            (-from.dot(step) / step.length_squared()).max(0.0)
        };
        let along = approach.min(1.0);
        let radius = a_radius + (b_radius - a_radius) * along;
        let (before, after) = (margin(a, a_radius), margin(b, b_radius));
        let reach = margin(a + (b - a) * along, radius).max(after);
        let beyond = if after >= 0.0 { (approach - along) * (b - a).z } else { 0.0 };
        let t = a.z + (b.z - a.z) * along + beyond.clamp(-radius, radius);
        let unsure = [reach, before, after].iter().any(|margin| margin.abs() < 1e-7);
        if (reach >= 0.0 && !within) || unsure {
            met.push((t / ray.direction().length(), unsure));
        }
        within = after >= 0.0;
    }
    met
}

/// All depths that the tracer finds, and whether they are those of an oracle
/// over every primitive, but for hits that rounding decides.
fn compare(scene: &Scene, ray: &Ray) -> Result<usize, TestCaseError> {
    let traced = Arc::new(TracedScene::new(scene).unwrap());
    compare_traced(scene, &traced, ray)
}

fn compare_traced(scene: &Scene, traced: &TracedScene, ray: &Ray) -> Result<usize, TestCaseError> {
    let mut hits = RayHits::<f32>::default();
    traced.tracer().hits(ray, &mut hits).unwrap();
    let found: Vec<f64> = hits.surfaces().iter().map(|hit| f64::from(hit.depth)).collect();
    prop_assert!(found.is_sorted(), "{found:?}");

    let [near, far] = ray.range();
    let (mut sure, mut unsure) = (Vec::new(), 0);
    for object in &scene.objects {
        let to_world = object.to_world(ray.time());
        let scale = to_world.matrix3.x_axis.length();
        let point = |point: Vec3| to_world.transform_point3(point.as_dvec3());
        let mut note = |(t, close): (Option<f64>, bool)| {
            let edge = t.is_some_and(|t| (t - near).abs() < 1e-9 || (t - far).abs() < 1e-9);
            if close || edge {
                unsure += 1;
            } else if let Some(t) = t.filter(|t| near <= *t && *t < far) {
                sure.push(t);
            }
        };
        match &*object.shape {
            Shape::Mesh(mesh) => (0..mesh.triangles().len())
                .for_each(|index| note(triangle_oracle(ray, mesh.corners(index).map(point)))),
            Shape::Curves(curves) => {
                let segments: Vec<usize> = (0..curves.segments().len()).collect();
                for strand in segments.chunk_by(|_, &next| curves.is_joined(next)) {
                    let ends = |&index: &usize| curves.segment(index);
                    let last = strand.last().map(|index| curves.segment(*index)[1]);
                    let points: Vec<_> = strand
                        .iter()
                        .map(|index| ends(index)[0])
                        .chain(last)
                        .map(|(p, r)| (point(p), f64::from(r) * scale))
                        .collect();
                    strand_oracle(ray, &points)
                        .into_iter()
                        .for_each(|(t, unsure)| note((Some(t), unsure)));
                }
            }
            Shape::Volume(_) => {}
        }
    }
    let tolerance = |t: f64| 1e-6 * t.abs().max(1.0);
    let mut left = found.clone();
    for t in &sure {
        let place = left.iter().position(|depth| (depth - t).abs() <= tolerance(*t));
        prop_assert!(place.is_some(), "missed {t}: {found:?}");
        left.swap_remove(place.unwrap());
    }
    // What remains must be hits that rounding decides.
    prop_assert!(left.len() <= unsure, "extra {left:?}");
    Ok(found.len())
}

fn coordinate() -> BoxedStrategy<f32> {
    // Half of the time on a grid, so that edges and corners are hit.
    prop_oneof![(-4_i8..=4).prop_map(f32::from), -4.0_f32..4.0].boxed()
}

fn point() -> impl Strategy<Value = Vec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from)
}

fn transform() -> impl Strategy<Value = Transform> {
    (
        [-3.0..3.0, -3.0..3.0, -3.0..3.0_f64],
        [0.0..360.0, 0.0..90.0, -180.0..180.0_f64],
        0.2..4.0_f64,
    )
        .prop_map(|(translate, rotate, scale)| Transform {
            translate: translate.into(),
            rotate: rotate.into(),
            scale,
        })
}

fn motion() -> impl Strategy<Value = Motion> {
    prop_oneof![
        transform().prop_map(Motion::still),
        (transform(), transform()).prop_map(|(open, close)| Motion { open, close }),
    ]
}

fn mesh() -> impl Strategy<Value = Shape> {
    vec([point(), point(), point()], 0..40).prop_map(|corners| {
        let triangles = (0..corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Shape::Mesh(TriangleMesh::new(corners.concat(), triangles).unwrap())
    })
}

fn curves() -> impl Strategy<Value = Shape> {
    vec((vec((point(), 0.0_f32..0.5), 0..7), prop::bool::ANY), 0..8).prop_map(|strands| {
        let lengths: Vec<u32> = strands.iter().map(|(points, _)| points.len() as u32).collect();
        let points = strands.iter().flat_map(|(points, _)| points.iter().map(|point| point.0));
        let radii = strands.iter().flat_map(|(points, thin)| {
            points.iter().map(move |point| if *thin { 0.0 } else { point.1 })
        });
        Shape::Curves(Curves::new(points.collect(), radii.collect(), lengths).unwrap())
    })
}

fn scene() -> impl Strategy<Value = Scene> {
    let object = (prop_oneof![mesh(), curves()], vec(motion(), 0..3))
        .prop_map(|(shape, motion)| Object { motion, ..Object::new(shape) });
    vec(object, 0..4).prop_map(Scene::of_objects)
}

fn ray() -> impl Strategy<Value = Ray> {
    (point(), point(), 0.0..1.0_f64, prop_oneof![Just(1.0), Just(300.0)]).prop_map(
        |(origin, target, time, away)| {
            let (origin, target) = (origin.as_dvec3(), target.as_dvec3());
            let direction = (target - origin).try_normalize().unwrap_or(DVec3::Y);
            Ray::new(target - direction * 9.0 * away, direction).at_time(time)
        },
    )
}

proptest! {
    #![proptest_config(config(0x5CE1))]

    #[test]
    fn every_primitive_that_is_met_is_found(
        scene in scene(),
        rays in vec((ray(), prop::bool::ANY, 0.0..20.0_f64), 1..6),
    ) {
        for (ray, bounded, far) in rays {
            let ray = if bounded { ray.within(far / 3.0, far) } else { ray };
            compare(&scene, &ray)?;
        }
    }
}

#[test]
fn hits_in_large_scenes_are_those_of_a_search_through_all() {
    for name in ["hairball", "foliage"] {
        let scene = builtin_scene(name).unwrap();
        let traced = Arc::new(TracedScene::new(&scene).unwrap());
        let raster = scene.light.raster([64, 64]).unwrap();
        let mut met = 0;
        for index in 0..12 {
            let (x, y) = (20.0 + 2.1 * f64::from(index), 44.0 - 1.9 * f64::from(index));
            met += compare_traced(&scene, &traced, &raster.ray(x, y, 0.0)).unwrap();
        }
        assert!(met > 100, "{name}: {met}");
    }
}

#[test]
fn hits_in_real_models_are_those_of_a_search_through_all() {
    let Some(path) = real_file("hair/sintel.hair") else { return };
    let mut scene = dsm_scene::open_scene(&path).unwrap();
    let Some(path) = real_file("hair/sintel_head.obj") else { return };
    scene.objects.extend(dsm_scene::open_scene(&path).unwrap().objects);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let raster = scene.light.raster([64, 64]).unwrap();
    let mut met = 0;
    for index in 0..40 {
        let (x, y) = (20.0 + 0.6 * f64::from(index), 40.0 - 0.4 * f64::from(index));
        met += compare_traced(&scene, &traced, &raster.ray(x, y, 0.0)).unwrap();
    }
    assert!(met > 60, "{met}");
}

/// A square of half a unit around the origin, facing z.
fn square() -> Shape {
    let corner = |x, y| Vec3::new(x, y, 0.0);
    let corners = vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
    Shape::Mesh(TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap())
}

#[test]
fn a_direction_of_negative_zeros_is_one_of_zeros() {
    let scene = Scene::of_objects(vec![Object::new(square())]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    // The last is rounded to −0 only when it is an f32.
    for none in [0.0, -0.0, -1e-60] {
        let ray = Ray::new(DVec3::new(0.03, 0.1, 5.0), DVec3::new(none, none, -1.0));
        let mut hits = RayHits::<f32>::default();
        traced.tracer().hits(&ray, &mut hits).unwrap();
        assert_eq!(hits.surfaces().len(), 1, "{none:e}");
    }
}

#[test]
fn a_moving_object_is_where_it_is_at_the_rays_time() {
    let at = |x| Transform { translate: DVec3::new(x, 0.0, 0.0), ..Transform::default() };
    let motion = vec![Motion { open: at(0.0), close: at(8.0) }];
    let scene = Scene::of_objects(vec![Object { motion, ..Object::new(square()) }]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    for step in 0..=80 {
        let time = f64::from(step) / 80.0;
        let ray = Ray::new(DVec3::new(4.03, 0.1, 5.0), DVec3::NEG_Z).at_time(time);
        let mut hits = RayHits::<f32>::default();
        traced.tracer().hits(&ray, &mut hits).unwrap();
        let covered = (4.03 - 8.0 * time).abs() < 0.5;
        assert_eq!(hits.surfaces().len(), usize::from(covered), "{time}");
    }
}

#[test]
fn colours_and_alphas_multiply() {
    let colour = Rgb::new(0.25, 0.5, 1.0);
    let scene = Scene::of_objects(vec![Object::new(square()).with_opacity(colour)]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let ray = Ray::new(DVec3::new(0.1, 0.2, 5.0), DVec3::NEG_Z);
    let mut coloured = RayHits::<Rgb>::default();
    traced.tracer().hits(&ray, &mut coloured).unwrap();
    assert_eq!(coloured.surfaces()[0].opacity, colour);
    let mut mono = RayHits::<f32>::default();
    traced.tracer().hits(&ray, &mut mono).unwrap();
    assert!((mono.surfaces()[0].opacity - 1.75 / 3.0).abs() < 1e-6);
    let left = traced.tracer().transmittance::<Rgb>(&ray);
    assert_eq!(left, Rgb::new(0.75, 0.5, 0.0));
}

#[test]
fn rays_that_are_none_meet_nothing() {
    let scene = Scene::of_objects(vec![Object::new(square())]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let down = Ray::new(DVec3::new(0.1, 0.2, 5.0), DVec3::NEG_Z);
    for ray in [
        Ray::new(DVec3::NAN, DVec3::Z),
        Ray::new(DVec3::ZERO, DVec3::ZERO),
        Ray::new(DVec3::ZERO, DVec3::INFINITY),
        down.within(0.0, 5.0),
        down.within(5.1, 9.0),
        down.within(9.0, 1.0),
        down.within(f64::NAN, f64::NAN),
    ] {
        let mut hits = RayHits::<f32>::default();
        traced.tracer().hits(&ray, &mut hits).unwrap();
        assert!(hits.is_empty(), "{ray:?}");
        assert_eq!(traced.tracer().transmittance::<f32>(&ray), 1.0);
    }
    assert_eq!(traced.tracer().transmittance::<f32>(&down.within(5.0, 6.0)), 0.0);
}

#[test]
fn the_door_to_the_baker_gives_planar_depths_and_normals() {
    let tilted = Transform { translate: DVec3::X * 2.0, rotate: DVec3::X * 60.0, scale: 16.0 };
    let object = Object { motion: vec![Motion::still(tilted)], ..Object::new(square()) };
    let scene = Scene::of_objects(vec![object]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let view = View { eye: DVec3::new(0.0, 0.0, 10.0), target: DVec3::ZERO, up: DVec3::Y };
    let projection = Projection::Perspective { fov: 20.0 };
    let light = Light { view, projection, extent: LightExtent::POINT };
    let source = SceneHitSource::new(Arc::clone(&traced), light.raster([16, 16]).unwrap());
    let camera = source.raster().shadow_camera();
    let sampling = PixelSampling::new(4, 0).unwrap();
    let samples = TileSamples::new(&sampling, [0, 0], [16, 16], Some((&camera, [16, 16]))).unwrap();
    let mut hits = TileHits::<f32>::with_normals(samples.len());
    source.hits(&samples, &mut hits).unwrap();
    assert_eq!(hits.surface_count(), samples.len() as usize);
    for (sample, hit) in hits.surfaces() {
        // Plane through the origin, turned by 60 degrees about x: y = z / √3
        // as seen from z: depth from the pixel's slope.
        let point = samples.point(sample);
        let slope = (1.0 - point.y / 8.0) * 10.0_f64.to_radians().tan();
        let expected = 10.0 / (1.0 + slope * 3.0_f64.sqrt());
        assert!((f64::from(hit.depth) - expected).abs() < 1e-4, "{} {expected}", hit.depth);
    }
    for (_, normal) in hits.normals() {
        let expected = Vec3::new(0.0, -(60.0_f32.to_radians().sin()), 0.5);
        assert!((*normal - expected).length() < 1e-6, "{normal}");
    }
    assert_eq!(hits.normals().len(), hits.surface_count());
    let mut nothing = TileHits::<f32>::new(samples.len());
    let source = SceneHitSource::new(Arc::clone(&traced), *source.raster()).beyond(1e3);
    source.hits(&samples, &mut nothing).unwrap();
    assert!(nothing.is_empty());
}
