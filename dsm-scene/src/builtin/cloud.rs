//! Media: a plume of smoke, and a cloud with pipes through it.

use dsm_core::LightExtent;
use glam::{DVec3, IVec3, UVec3};

use super::random::fractal_noise;
use super::solid::{camera, floor, light, pipe};
use crate::error::Result;
use crate::scene::{Object, Scene, Shape};
use crate::volume::Volume;

/// Smoke that rises, widens and tears.
pub(super) fn smoke() -> Result<Scene> {
    let size = UVec3::new(64, 128, 64);
    let voxel = 1.0 / 64.0;
    let start = DVec3::new(-0.5, 0.05, -0.5);
    let volume = Volume::from_fn(size, DVec3::splat(voxel), start, |index: IVec3| {
        let point = (index.as_dvec3() + 0.5) * voxel;
        let height = point.y / 2.0;
        let sway = DVec3::new(
            fractal_noise(DVec3::new(0.0, 3.0 * point.y, 1.5), 3) - 0.5,
            0.0,
            fractal_noise(DVec3::new(7.5, 3.0 * point.y, 0.0), 3) - 0.5,
        );
        let off = point - DVec3::new(0.5, point.y, 0.5) - sway * (0.7 * height);
        let width = 0.08 + 0.3 * height;
        let within = 1.0 - off.length_squared() / (width * width);
        let torn = fractal_noise(point * 7.0, 4) - 0.3 - 0.25 * height;
        let ends = (20.0 * height).min(12.0 * (1.0 - height)).min(1.0);
        (within.min(1.0) * (4.0 * torn).min(1.0) * ends).max(0.0) as f32
            * f32::from(within > 0.0 && torn > 0.0)
    })?;
    let medium = Object { density: 14.0, ..Object::new(Shape::Volume(volume)) };
    let target = DVec3::new(0.0, 1.0, 0.0);
    let extent = LightExtent::disk(0.3);
    Ok(Scene {
        light: light(DVec3::new(2.6, 3.6, 1.6), target, 40.0, extent),
        camera: camera(DVec3::new(0.8, 1.6, 4.2), DVec3::new(-0.2, 0.85, 0.0), 36.0),
        ..Scene::of_objects(vec![medium, floor(6.0)?])
    })
}

/// A cloud whose shadow falls on pipes inside it, and theirs on it.
pub(super) fn pipes() -> Result<Scene> {
    let size = UVec3::new(96, 64, 64);
    let voxel = 1.0 / 32.0;
    let start = DVec3::new(-1.5, 0.6, -1.0);
    let volume = Volume::from_fn(size, DVec3::splat(voxel), start, |index: IVec3| {
        let point = (index.as_dvec3() + 0.5) * voxel;
        let off = (point - DVec3::new(1.5, 1.0, 1.0)) / DVec3::new(1.4, 0.9, 0.9);
        let billow = 0.9 * (fractal_noise(point * 2.5, 4) - 0.5);
        let inside = 1.0 - off.length() + billow * 0.6;
        (3.0 * inside).clamp(0.0, 1.0) as f32 * f32::from(off.length_squared() < 0.95)
    })?;
    let mut objects = vec![Object { density: 2.2, ..Object::new(Shape::Volume(volume)) }];
    let middle = DVec3::new(0.0, 1.6, 0.0);
    for (lean, shift, radius) in [
        (DVec3::new(2.4, 0.5, 0.3), DVec3::new(0.0, 0.2, 0.35), 0.1),
        (DVec3::new(-1.9, 1.2, -0.6), DVec3::new(0.1, 0.0, -0.1), 0.13),
        (DVec3::new(0.5, -1.7, 1.5), DVec3::new(-0.5, 0.0, 0.0), 0.08),
    ] {
        let (from, to) = (middle + shift - lean, middle + shift + lean);
        objects.push(Object::new(Shape::Mesh(pipe(from, to, radius, 48)?)));
    }
    objects.push(floor(8.0)?);
    let extent = LightExtent::sphere(0.3);
    Ok(Scene {
        light: light(DVec3::new(1.5, 7.5, 2.5), middle, 40.0, extent),
        camera: camera(DVec3::new(0.5, 2.4, 6.5), DVec3::new(0.0, 1.3, 0.0), 36.0),
        ..Scene::of_objects(objects)
    })
}
