//! Where the renderer asks for light: each place as often as its share.

#![cfg(test)]

use std::collections::HashSet;
use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

use dsm_core::{AreaLight, Facing, LightVisibility, Rgb, ShadedPoint, View};
use dsm_scene::detail::{Camera, Image, RenderSettings, Renderer};
use dsm_scene::{
    Curves, Motion, Object, Scene, Shape, TracedScene, Transform, TriangleMesh, Volume,
};
use glam::{DVec3, IVec3, UVec3, Vec3};

/// Keeps the points that it is asked for; the light is what `factor` says.
struct Spy<F>(Mutex<Vec<ShadedPoint>>, F);

impl<F: Fn(DVec3) -> f32 + Sync> LightVisibility for Spy<F> {
    type Value = f32;
    type Error = Infallible;

    fn visibility(&self, at: DVec3, _: &AreaLight, _: u64) -> Result<f32, Infallible> {
        Ok((self.1)(at))
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        _: &AreaLight,
        values: &mut Vec<f32>,
    ) -> Result<(), Infallible> {
        self.0.lock().unwrap().extend_from_slice(points);
        values.extend(points.iter().map(|point| (self.1)(point.position)));
        Ok(())
    }
}

/// Above the ground, 90 degrees wide and high: one unit of height is one of
/// width to either side.
fn look(
    objects: Vec<Object>,
    [height, side]: [u32; 2],
    settings: RenderSettings,
    factor: impl Fn(DVec3) -> f32 + Sync,
) -> (Image, Vec<ShadedPoint>) {
    let eye = DVec3::new(0.0, f64::from(height), 0.0);
    let view = View { eye, target: DVec3::ZERO, up: DVec3::NEG_Z };
    let camera = Camera { view, fov: 90.0, resolution: [side; 2] };
    let traced = Arc::new(TracedScene::new(&Scene::of_objects(objects)).unwrap());
    let light = AreaLight::point(DVec3::new(0.0, 50.0, 0.0));
    let camera = camera.raster(camera.resolution).unwrap();
    let renderer = Renderer::new(Arc::clone(&traced), camera, light, settings);
    let spy = Spy(Mutex::default(), factor);
    let Ok(image) = renderer.render(&spy, |_| ControlFlow::Continue(()));
    (image.unwrap(), spy.0.into_inner().unwrap())
}

fn settings(samples: u32) -> RenderSettings {
    RenderSettings::new(samples, 3).unwrap().with_factor(true)
}

/// A square at a height, so wide to either side of x.
fn square(x: f32, height: f32, half: f32) -> Object {
    let corner = |dx, dz| Vec3::new(x + dx * half, height, dz * half);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    Object::new(Shape::Mesh(mesh))
}

/// A medium of density 1 and an optical depth of `depth` straight down, in the
/// unit of height above `bottom`.
fn fog(bottom: f64, depth: f32) -> Object {
    let (size, voxel) = (UVec3::new(8, 16, 8), DVec3::new(50.0, 1.0 / 16.0, 50.0));
    let start = DVec3::new(-175.0, bottom + 1.0 / 32.0, -175.0);
    let volume = Volume::from_fn(size, voxel, start, |_: IVec3| 1.0_f32).unwrap();
    Object { density: depth, ..Object::new(Shape::Volume(volume)) }
}

/// The share of all rays that end between these heights.
fn share(points: &[ShadedPoint], rays: u32, heights: std::ops::Range<f64>) -> f64 {
    let ends = points.iter().filter(|point| heights.contains(&point.position.y)).count();
    ends as f64 / f64::from(rays)
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 0.02, "{found} {expected}");
}

#[test]
fn blocks_stand_where_they_belong() {
    // Three blocks a side, of which the last is cut.
    let (image, _) = look(vec![square(0.0, 0.0, 90.0)], [10, 40], settings(16), |at| {
        (0.5 + at.x / 64.0 + at.z / 640.0) as f32
    });
    for (index, pixel) in image.pixels().iter().enumerate() {
        let at = |side: usize| (side as f64 + 0.5) / 2.0 - 10.0;
        let expected = 0.5 + at(index % 40) / 64.0 + at(index / 40) / 640.0;
        assert!((f64::from(pixel[0]) - expected).abs() < 2e-3, "{index} {pixel:?} {expected}");
    }
}

#[test]
fn points_say_what_they_lie_on_and_have_numbers_of_their_own() {
    let strand = Curves::new(
        vec![Vec3::new(-20.0, 2.0, 0.0), Vec3::new(20.0, 2.0, 0.0)],
        vec![0.5, 0.5],
        [2],
    );
    let objects = vec![square(0.0, 0.0, 90.0), Object::new(Shape::Curves(strand.unwrap()))];
    let (_, points) = look(objects.clone(), [10, 20], settings(4), |_| 1.0);
    assert_eq!(points.len(), 1600);
    let (mut surfaces, mut strands) = (0, 0);
    for ShadedPoint { position, facing, .. } in &points {
        match facing {
            Facing::Surface(normal) => {
                surfaces += 1;
                assert!(normal.distance(DVec3::Y) < 1e-6);
                assert!((1e-12..1e-9).contains(&position.y), "{position}");
            }
            Facing::Strand(along) => {
                strands += 1;
                assert!(along.cross(DVec3::X).length() < 1e-6);
                // On the side of the light, half a unit from the middle.
                let middle = DVec3::new(position.x, 2.0, 0.0);
                let to_light = DVec3::new(position.x, 50.0, 0.0) - middle;
                assert!(to_light.normalize().y > 0.99);
                assert!((position.y - 2.5).abs() < 0.1, "{position}");
            }
            _ => panic!("{facing:?}"),
        }
    }
    assert!(surfaces > 1000 && strands > 50, "{surfaces} {strands}");
    let seeds: HashSet<_> = points.iter().map(|point| point.seed).collect();
    assert_eq!(seeds.len(), points.len());
    // The picture's seed changes them, at the same places.
    let other = settings(4).with_seed(9);
    let (_, others) = look(objects, [10, 20], other, |_| 1.0);
    assert!(others.iter().all(|point| !seeds.contains(&point.seed)));
    let places = |points: &[ShadedPoint]| -> HashSet<[u64; 3]> {
        points.iter().map(|point| point.position.to_array().map(f64::to_bits)).collect()
    };
    assert_eq!(places(&points), places(&others));
}

#[test]
fn what_moves_is_seen_at_all_times() {
    let far = Transform { translate: DVec3::new(0.0, -2.0, 0.0), ..Transform::default() };
    let motion = Motion { open: Transform::default(), close: far };
    let floor = Object { motion: vec![motion], ..square(0.0, 0.0, 90.0) };
    let (_, points) = look(vec![floor], [10, 4], settings(256), |_| 1.0);
    for quarter in 0..4 {
        let top = -0.5 * f64::from(quarter) + 1e-3;
        assert_near(share(&points, 16 * 256, top - 0.5..top), 0.25);
    }
}

#[test]
fn media_and_surfaces_are_seen_by_their_shares() {
    let rays = 4 * 1024;
    let see = |objects: Vec<Object>| look(objects, [10, 2], settings(1024), |_| 1.0).1;
    // The rays of these pixels are longer than their depth: a mean over all of
    // them of what an optical depth of so much straight down lets pass.
    let steps = 64;
    let passes = |depth: f64| {
        let at = |step: usize| (step as f64 + 0.5) / f64::from(steps) * 2.0 - 1.0;
        let all = (0..64).flat_map(|x| (0..64).map(move |y| (at(x), at(y))));
        all.map(|(x, y)| (-depth * (1.0 + x * x + y * y).sqrt()).exp()).sum::<f64>() / 4096.0
    };
    let half = Rgb::new(0.5, 0.5, 0.5);
    let floor = || square(0.0, -5.0, 500.0);
    // Two media one below the other, in either order of the scene.
    for flip in [false, true] {
        let mut objects = vec![fog(3.0, 0.7), fog(0.0, 0.4), floor()];
        if flip {
            objects.swap(0, 1);
        }
        let points = see(objects);
        assert_near(share(&points, rays, 2.9..4.1), 1.0 - passes(0.7));
        assert_near(share(&points, rays, -0.1..1.1), passes(0.7) - passes(1.1));
        assert_near(share(&points, rays, -5.1..-4.9), passes(1.1));
    }
    // A pane below a medium, and nothing of a medium behind what is opaque.
    let pane = square(0.0, 2.0, 500.0).with_opacity(half);
    let points = see(vec![pane, fog(3.0, 0.7), floor(), fog(-9.0, 2.0)]);
    assert_near(share(&points, rays, 2.9..4.1), 1.0 - passes(0.7));
    assert_near(share(&points, rays, 1.9..2.1), 0.5 * passes(0.7));
    assert_near(share(&points, rays, -5.1..-4.9), 0.5 * passes(0.7));
    assert_eq!(share(&points, rays, -20.0..-6.0), 0.0);
    // An object's opacity scales its extinction.
    let points = see(vec![fog(3.0, 1.4).with_opacity(half), floor()]);
    assert_near(share(&points, rays, 2.9..4.1), 1.0 - passes(0.7));
}
