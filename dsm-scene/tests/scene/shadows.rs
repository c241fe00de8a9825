//! Shadow factors against answers that are known.

use std::sync::Arc;

use dsm_core::{AreaLight, LightVisibility, OcclusionTracer, Rgb};
use dsm_scene::detail::SceneReference;
use dsm_scene::{
    Motion, Object, Scene, Shape, TracedScene, Transform, TriangleMesh, builtin_scene,
};
use glam::{DVec3, Vec3};

/// The half plane x < 0 at height 1.
fn half_plane(opacity: Rgb) -> Object {
    let corner = |x, z| Vec3::new(x, 1.0, z);
    let corners = vec![
        corner(-100.0, -100.0),
        corner(0.0, -100.0),
        corner(0.0, 100.0),
        corner(-100.0, 100.0),
    ];
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    Object::new(Shape::Mesh(mesh)).with_opacity(opacity)
}

fn grey(opacity: f32) -> Rgb {
    Rgb::new(opacity, opacity, opacity)
}

#[test]
fn a_half_plane_has_a_linear_penumbra() {
    let scene = Scene::of_objects(vec![half_plane(grey(0.8))]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let reference = SceneReference::<f32>::new(Arc::clone(&traced)).with_rays(1024);
    // A light 2 wide at height 2: its middle is hidden from x = 0, and all of
    // it from x = −1.
    let light = AreaLight::rectangle(DVec3::Y * 2.0, DVec3::X, DVec3::Z * 0.5);
    for step in -6..=6 {
        let x = f64::from(step) / 4.0;
        let Ok(visible) = reference.visibility(DVec3::new(x, 0.0, 0.1), &light, 5);
        let hidden = ((1.0 - x) / 2.0).clamp(0.0, 1.0);
        let expected = 1.0 - 0.8 * hidden;
        assert!((f64::from(visible) - expected).abs() < 2e-3, "{x}: {visible} {expected}");
    }
}

#[test]
fn a_disk_and_a_sphere_are_hidden_by_area() {
    let scene = Scene::of_objects(vec![half_plane(grey(1.0))]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let reference = SceneReference::<f32>::new(Arc::clone(&traced)).with_rays(4096);
    let disk = AreaLight::disk(DVec3::Y * 2.0, DVec3::X, DVec3::Z);
    let sphere = AreaLight::sphere(DVec3::Y * 2.0, 1.0);
    for light in [disk, sphere] {
        let Ok(half) = reference.visibility(DVec3::ZERO, &light, 1);
        assert!((half - 0.5).abs() < 3e-3, "{half}");
    }
    // From x = ½ light beyond x = −½ is hidden: a segment of the disk.
    let Ok(visible) = reference.visibility(DVec3::X * 0.5, &disk, 1);
    let segment = (0.5_f64.acos() - 0.5 * 0.75_f64.sqrt()) / std::f64::consts::PI;
    assert!((f64::from(visible) - (1.0 - segment)).abs() < 3e-3, "{visible} {segment}");
}

#[test]
fn a_point_light_is_one_ray() {
    let scene = Scene::of_objects(vec![half_plane(Rgb::new(1.0, 0.5, 0.25))]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let reference = SceneReference::<Rgb>::new(Arc::clone(&traced));
    let light = AreaLight::point(DVec3::Y * 2.0);
    let Ok(value) = reference.visibility(DVec3::new(-0.5, 0.0, 0.0), &light, 9);
    assert_eq!(value, Rgb::new(0.0, 0.5, 0.75));
    let Ok(value) = reference.transmittance(DVec3::new(0.5, 0.0, 0.0), light.centre(), 0.0);
    assert_eq!(value, Rgb::new(1.0, 1.0, 1.0));
    // What hides the light lies between: not behind it, not at the receiver.
    let Ok(value) =
        reference.transmittance(DVec3::new(-0.5, 0.0, 0.0), DVec3::new(-0.5, 0.9, 0.0), 0.0);
    assert_eq!(value.red, 1.0);
    let Ok(value) = reference.transmittance(DVec3::new(-0.5, 1.0, 0.0), light.centre(), 0.0);
    assert_eq!(value.red, 1.0);
    let reference = reference.with_start(0.0);
    let Ok(value) = reference.transmittance(DVec3::new(-0.5, 1.0, 0.0), light.centre(), 0.0);
    assert_eq!(value.red, 0.0);
}

#[test]
fn a_moving_blocker_hides_for_a_while() {
    let at = |x| Transform { translate: DVec3::new(x, 0.0, 0.0), ..Transform::default() };
    let motion = vec![Motion { open: at(-0.6), close: at(0.4) }];
    let scene = Scene::of_objects(vec![Object { motion, ..half_plane(grey(1.0)) }]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let reference = SceneReference::<f32>::new(Arc::clone(&traced)).with_rays(1000);
    // Its edge passes x = 0 at time 0.6.
    let Ok(value) = reference.visibility(DVec3::ZERO, &AreaLight::point(DVec3::Y * 2.0), 3);
    assert!((value - 0.6).abs() < 3e-3, "{value}");
}

#[test]
fn the_product_needs_no_order() {
    let scene = builtin_scene("hairball").unwrap();
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let mut tracer = traced.tracer();
    let raster = scene.light.raster([40, 40]).unwrap();
    for index in 0..40 {
        let ray = raster.ray(f64::from(index) + 0.3, 39.7 - f64::from(index), 0.0);
        // Up to above the floor.
        let ray = ray.within(0.0, 5.3);
        let mut hits = dsm_core::RayHits::<f32>::default();
        tracer.hits(&ray, &mut hits).unwrap();
        let expected: f64 =
            hits.surfaces().iter().map(|hit| 1.0 - f64::from(hit.opacity)).product();
        let left = f64::from(tracer.transmittance::<f32>(&ray));
        assert!((left - expected).abs() < 1e-6, "{left} {expected}");
    }
}
