//! A crown of leaves.

use dsm_core::LightExtent;
use glam::{DVec3, Vec3};

use super::random::{Random, across};
use super::solid::{camera, floor, light};
use crate::error::Result;
use crate::mesh::TriangleMesh;
use crate::scene::{Object, Scene, Shape};

const LEAVES: u32 = 300_000;
const CLUSTERS: usize = 600;

/// Opaque leaves, one triangle each, in clusters.
pub(super) fn foliage() -> Result<Scene> {
    let centre = DVec3::new(0.0, 1.1, 0.0);
    let mut random = Random::new(0x4c45_4146);
    let clusters: Vec<DVec3> = (0..CLUSTERS).map(|_| random.in_ball() * 0.85).collect();
    let mut positions: Vec<Vec3> = Vec::with_capacity(3 * LEAVES as usize);
    let mut triangles = Vec::with_capacity(LEAVES as usize);
    for leaf in 0..LEAVES {
        let middle = centre + clusters[random.below(CLUSTERS)] + random.normal() * 0.08;
        let facing = random.direction();
        let [along, aside] = across(facing, &mut random);
        let size = random.between(0.008, 0.016);
        let corners = [along, along * -0.5 + aside * 0.7, along * -0.5 - aside * 0.7];
        positions.extend(corners.map(|corner| (middle + corner * size).as_vec3()));
        triangles.push([3 * leaf, 3 * leaf + 1, 3 * leaf + 2]);
    }
    let leaves = TriangleMesh::new(positions, triangles)?;
    let objects = vec![Object::new(Shape::Mesh(leaves)), floor(8.0)?];
    let extent = LightExtent::rectangle([1.0, 1.0]);
    Ok(Scene {
        light: light(centre + DVec3::new(2.24, 4.24, 1.5), centre, 32.0, extent),
        camera: camera(DVec3::new(3.4, 2.6, 3.2), DVec3::new(-0.2, 0.8, -0.1), 35.0),
        ..Scene::of_objects(objects)
    })
}
