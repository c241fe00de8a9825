//! Optical depth through volumes.

use dsm_core::{Ray, RayHits, Rgb};
use dsm_scene::{Motion, Object, Scene, Shape, TracedScene, Transform, Volume};
use glam::{DVec3, UVec3};
use proptest::prelude::*;

use crate::support::{config, real_file};

fn scene_of(volume: Volume, density: f32, motion: Vec<Motion>) -> Scene {
    Scene::of_objects(vec![Object { density, motion, ..Object::new(Shape::Volume(volume)) }])
}

/// −ln of what is left behind everything, from the hits.
fn optical_depth(scene: &Scene, ray: &Ray) -> f64 {
    let traced = TracedScene::new(scene).unwrap();
    let mut hits = RayHits::<f32>::default();
    traced.tracer().hits(ray, &mut hits).unwrap();
    let integral = |s: &dsm_core::detail::VolumeSegment<f32>| {
        0.5 * (s.near_extinction[0] + s.far_extinction[0]) * f64::from(s.far - s.near)
    };
    hits.segments().iter().map(integral).sum()
}

/// 12 × 10 × 8 voxels of density 2, half a unit apart.
fn homogeneous() -> Volume {
    let size = UVec3::new(12, 10, 8);
    Volume::from_fn(size, DVec3::splat(0.5), DVec3::ZERO, |_| 2.0).unwrap()
}

#[test]
fn a_homogeneous_box_has_the_optical_depth_of_its_length() {
    // Density ramps to 0 over one voxel at either face, so that a ray from face
    // to face sees as many voxels as there are.
    let scene = scene_of(homogeneous(), 0.75, Vec::new());
    for (direction, voxels) in [(DVec3::X, 12.0), (DVec3::NEG_Y, 10.0), (DVec3::Z, 8.0)] {
        let middle = DVec3::new(2.8, 2.3, 1.7);
        let ray = Ray::new(middle - direction * 30.0, direction);
        let expected = voxels * 0.5 * 2.0 * 0.75;
        assert!((optical_depth(&scene, &ray) - expected).abs() < 1e-4 * expected);
        // From the middle of a face to the other, leaning: as much longer.
        let lean = DVec3::new(0.3, 0.2, 0.1).reject_from_normalized(direction);
        let leaning = direction + lean * 0.3;
        let ray = Ray::new(middle - leaning * 30.0, leaning);
        let longer = expected * leaning.length();
        let depth = optical_depth(&scene, &ray);
        assert!((depth - longer).abs() < 1e-4 * longer, "{depth} {longer}");
        let left = TracedScene::new(&scene).unwrap().tracer().transmittance::<f32>(&ray);
        assert!((f64::from(left) - (-longer).exp()).abs() < 1e-6);
    }
}

#[test]
fn scale_lengthens_the_way_and_not_the_extinction() {
    let transform =
        Transform { scale: 3.0, rotate: DVec3::new(0.0, 90.0, 0.0), ..Transform::default() };
    let scene = scene_of(homogeneous(), 0.1, vec![Motion::still(transform)]);
    // x of the object is −z of the world.
    let ray = Ray::new(DVec3::new(1.7 * 3.0, 2.3 * 3.0, 50.0), DVec3::NEG_Z);
    let expected = 12.0 * 0.5 * 3.0 * 2.0 * 0.1;
    assert!((optical_depth(&scene, &ray) - expected).abs() < 1e-4);
}

#[test]
fn the_way_along_the_ray_counts_not_the_depth() {
    let scene = scene_of(homogeneous(), 1.0, Vec::new());
    let unit = Ray::new(DVec3::new(2.8, 2.3, 20.0), DVec3::NEG_Z);
    let double = Ray::new(unit.origin(), unit.direction() * 2.0);
    assert!((optical_depth(&scene, &unit) - optical_depth(&scene, &double)).abs() < 1e-4);
    let traced = TracedScene::new(&scene).unwrap();
    let mut hits = RayHits::<f32>::default();
    let short = Ray::new(unit.origin(), unit.direction() * 0.5);
    assert!(traced.tracer().hits(&short, &mut hits).is_err(), "t is no depth there");
}

#[test]
fn a_medium_can_have_a_colour() {
    let colour = Rgb::new(1.0, 0.5, 0.0);
    let object = Object::new(Shape::Volume(homogeneous())).with_opacity(colour);
    let scene = Scene::of_objects(vec![Object { density: 0.1, ..object }]);
    let traced = TracedScene::new(&scene).unwrap();
    let ray = Ray::new(DVec3::new(2.8, 2.3, 20.0), DVec3::NEG_Z);
    let left = traced.tracer().transmittance::<Rgb>(&ray);
    let red = (-0.8_f32).exp();
    assert!((left.red - red).abs() < 1e-6 && (left.green - red.sqrt()).abs() < 1e-6);
    assert_eq!(left.blue, 1.0);
}

/// ∫ density along the ray, by many small steps.
fn quadrature(volume: &Volume, ray: &Ray, steps: u32) -> f64 {
    let [near, far] = ray.range();
    let step = (far - near) / f64::from(steps);
    let density =
        |index: u32| f64::from(volume.density(ray.at(near + (f64::from(index) + 0.5) * step)));
    (0..steps).map(density).sum::<f64>() * step * ray.direction().length()
}

fn noisy(seed: u32) -> Volume {
    // Most voxels are empty, so that bricks are skipped.
    let value = |index: glam::IVec3| {
        let bits = (index.x as u32).wrapping_mul(73_856_093)
            ^ (index.y as u32).wrapping_mul(19_349_663)
            ^ (index.z as u32).wrapping_mul(83_492_791)
            ^ seed;
        let bits = bits.wrapping_mul(0x9e37_79b9) >> 16;
        if (index / 8).element_sum() % 3 == 0 { bits as f32 / 65_536.0 } else { 0.0 }
    };
    let size = DVec3::new(0.1, 0.08, 0.12);
    Volume::from_fn(UVec3::new(40, 33, 26), size, DVec3::new(-2.0, -1.0, -1.0), value).unwrap()
}

proptest! {
    #![proptest_config(config(0x5CE2))]

    #[test]
    fn optical_depth_is_the_integral_of_density(
        seed in 0..4_u32,
        from in [-4.0..4.0_f64, -4.0..4.0, -4.0..4.0],
        to in [-2.0..2.0_f64, -1.0..1.5, -1.0..2.0],
        axis in 0..6_usize,
    ) {
        let volume = noisy(seed);
        let (from, to) = (DVec3::from(from), DVec3::from(to));
        // Along an axis every other time: there cells are left one at a time.
        let direction = match axis {
            axis @ 0..3 => DVec3::AXES[axis] * if from.x > 0.0 { 1.0 } else { -1.0 },
            _ => (to - from).normalize(),
        };
        let ray = Ray::new(to - direction * 4.0, direction).within(0.5, 8.0);
        let expected = quadrature(&volume, &ray, 4000);
        let scene = scene_of(volume, 1.0, Vec::new());
        let depth = optical_depth(&scene, &ray);
        prop_assert!((depth - expected).abs() < 2e-3 * (1.0 + expected), "{depth} {expected}");
        let traced = TracedScene::new(&scene).unwrap();
        let left = f64::from(traced.tracer().transmittance::<f32>(&ray));
        prop_assert!((left - (-depth).exp()).abs() < 1e-6, "{left} {depth}");
    }
}

#[test]
fn smoke_from_a_file_has_the_integral_of_its_density() {
    let Some(path) = real_file("volume/smoke.vdb") else { return };
    let mut scene = dsm_scene::open_scene(&path).unwrap();
    scene.objects[0].density = 0.05;
    let Shape::Volume(volume) = &*scene.objects[0].shape else { panic!("no volume") };
    let centre = scene.bounds().centre();
    let mut most = 0.0_f64;
    for index in 0..12 {
        let angle = f64::from(index) * 0.5;
        let direction = DVec3::new(angle.cos(), 0.3 * angle.sin(), angle.sin()).normalize();
        let start = centre + DVec3::Y * f64::from(index - 6) * 5.0 - direction * 80.0;
        let ray = Ray::new(start, direction).within(0.0, 160.0);
        let expected = 0.05 * quadrature(volume, &ray, 20_000);
        let depth = optical_depth(&scene, &ray);
        assert!((depth - expected).abs() < 1e-3 * (1.0 + expected), "{depth} {expected}");
        most = most.max(depth);
    }
    assert!(most > 0.5, "{most}");
}

#[test]
fn straight_stretches_are_one_segment() {
    let scene = scene_of(homogeneous(), 0.05, Vec::new());
    let traced = TracedScene::new(&scene).unwrap();
    let mut hits = RayHits::<f32>::default();
    let ray = Ray::new(DVec3::new(2.8, 2.3, 20.0), DVec3::NEG_Z);
    traced.tracer().hits(&ray, &mut hits).unwrap();
    // Two ramps and the middle.
    assert_eq!(hits.segments().len(), 3);
}
