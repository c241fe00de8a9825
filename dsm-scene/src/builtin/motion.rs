//! A scene that moves while the shutter is open.

use dsm_core::LightExtent;
use glam::DVec3;

use super::solid::{camera, floor, light, sphere};
use crate::error::Result;
use crate::scene::{Object, Scene, Shape};
use crate::transform::{Motion, Transform};

/// A sphere of which every other slice is missing. It flies past and turns, and
/// a twin of it stands still.
pub(super) fn spinning_sphere() -> Result<Scene> {
    let slices = |slice: u32| (slice / 8).is_multiple_of(2);
    let shape = Shape::Mesh(sphere(DVec3::ZERO, 0.5, 64, 32, slices)?);
    let at = |x| Transform { translate: DVec3::new(x, 0.8, 0.0), ..Transform::default() };
    let still = Object { motion: vec![Motion::still(at(-1.2))], ..Object::new(shape) };
    let open = at(0.3);
    let close = Transform { rotate: DVec3::new(0.0, 90.0, 20.0), ..at(1.1) };
    let moving = Object { motion: vec![Motion { open, close }], ..still.clone() };
    let target = DVec3::new(0.0, 0.5, 0.0);
    let extent = LightExtent::disk(0.1);
    Ok(Scene {
        light: light(DVec3::new(0.5, 5.0, 2.5), target, 46.0, extent),
        camera: camera(DVec3::new(0.0, 2.2, 5.2), target, 36.0),
        ..Scene::of_objects(vec![still, moving, floor(6.0)?])
    })
}
