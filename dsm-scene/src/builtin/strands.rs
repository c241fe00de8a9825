//! Hair and fur.

use dsm_core::{LightExtent, Rgb};
use glam::{DVec3, Vec3};

use super::random::{Random, across};
use super::solid::{TURN, camera, floor, light, sphere};
use crate::curves::Curves;
use crate::error::Result;
use crate::scene::{Object, Scene, Shape};

const HAIRS: u32 = 50_000;
const HAIR_POINTS: u32 = 17;
const FURS: u32 = 40_000;
const FUR_POINTS: u32 = 6;

fn grey(opacity: f32) -> Rgb {
    Rgb::new(opacity, opacity, opacity)
}

/// Curly hairs that grow out of a ball and droop.
pub(super) fn hairball() -> Result<Scene> {
    let centre = DVec3::new(0.0, 1.1, 0.0);
    let ball = 0.55;
    let mut random = Random::new(0x4841_4952);
    let mut points: Vec<Vec3> = Vec::with_capacity((HAIRS * HAIR_POINTS) as usize);
    for _ in 0..HAIRS {
        let out = random.direction();
        let [right, up] = across(out, &mut random);
        let length = random.between(0.33, 0.47);
        let curl = random.between(0.015, 0.06);
        let turns = random.between(0.3, 0.8);
        let start = random.unit();
        let droop = DVec3::new(0.14 * random.signed(), -0.16, 0.14 * random.signed());
        for point in 0..HAIR_POINTS {
            let along = f64::from(point) / f64::from(HAIR_POINTS - 1);
            let (sin, cos) = libm::sincos(TURN * (start + turns * along));
            let swing = (right * cos + up * sin) * (curl * along);
            let grown = out * (ball + length * along) + swing + droop * (along * along);
            points.push((centre + grown).as_vec3());
        }
    }
    let radii = vec![1.0 / 512.0; points.len()];
    let hairs = Curves::new(points, radii, (0..HAIRS).map(|_| HAIR_POINTS))?;
    let objects = vec![
        Object::new(Shape::Curves(hairs)).with_opacity(grey(0.3)),
        Object::new(Shape::Mesh(sphere(centre, ball, 96, 48, |_| true)?)),
        floor(8.0)?,
    ];
    let eye = centre + DVec3::new(2.24, 4.24, 1.5);
    let extent = LightExtent::rectangle([1.0, 1.0]);
    Ok(Scene {
        light: light(eye, centre, 32.0, extent),
        camera: camera(DVec3::new(3.4, 2.6, 3.2), DVec3::new(-0.2, 0.8, -0.1), 35.0),
        ..Scene::of_objects(objects)
    })
}

/// A square of fur whose hairs end in points.
pub(super) fn fur_plane() -> Result<Scene> {
    let mut random = Random::new(0x0046_5552);
    let count = (FURS * FUR_POINTS) as usize;
    let (mut points, mut radii) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for _ in 0..FURS {
        let root = DVec3::new(random.signed(), 0.0, random.signed());
        let lean = DVec3::new(0.06, 0.0, 0.02) + random.in_ball() * 0.05;
        let length = random.between(0.1, 0.2);
        for point in 0..FUR_POINTS {
            let along = f64::from(point) / f64::from(FUR_POINTS - 1);
            let grown = DVec3::Y * (length * along) + lean * (along * along);
            points.push((root + grown).as_vec3());
            radii.push((0.0016 * (1.0 - along)) as f32);
        }
    }
    let fur = Curves::new(points, radii, (0..FURS).map(|_| FUR_POINTS))?;
    let objects = vec![Object::new(Shape::Curves(fur)).with_opacity(grey(0.5)), floor(1.0)?];
    let extent = LightExtent::disk(0.25);
    Ok(Scene {
        light: light(DVec3::new(1.5, 3.0, 1.0), DVec3::new(0.0, 0.05, 0.0), 46.0, extent),
        camera: camera(DVec3::new(0.2, 1.2, 2.4), DVec3::new(0.0, 0.0, 0.1), 38.0),
        ..Scene::of_objects(objects)
    })
}
