//! A window that colours the light.

use dsm_core::{LightExtent, Rgb};
use glam::{DVec3, Vec3};

use super::random::Random;
use super::solid::{camera, floor, light};
use crate::error::Result;
use crate::mesh::TriangleMesh;
use crate::scene::{Object, Scene, Shape};

const COLUMNS: u32 = 6;
const ROWS: u32 = 9;
/// Half the width of the lead between two panes.
const LEAD: f64 = 0.012;

/// The fractions of red, green and blue light that each colour of glass keeps.
const COLOURS: [[f32; 3]; 6] = [
    [0.85, 0.10, 0.08],
    [0.95, 0.65, 0.10],
    [0.15, 0.55, 0.20],
    [0.08, 0.20, 0.75],
    [0.55, 0.15, 0.60],
    [0.90, 0.90, 0.80],
];

/// Panes in rows whose corners are shifted, each of one colour, in opaque lead.
pub(super) fn stained_glass() -> Result<Scene> {
    let mut random = Random::new(0x474c_4153);
    let mut corner = Vec::new();
    for row in 0..=ROWS {
        for column in 0..=COLUMNS {
            let edge = |at, last| at == 0 || at == last;
            let shift = |fixed: bool, by: f64| if fixed { 0.0 } else { 0.35 * by };
            let x = f64::from(column) + shift(edge(column, COLUMNS), random.signed());
            let y = f64::from(row) + shift(edge(row, ROWS), random.signed());
            corner.push(DVec3::new(x / 3.0 - 1.0, 0.2 + y / 3.0, 0.0));
        }
    }
    let mut panes: Vec<Vec<[DVec3; 4]>> = vec![Vec::new(); COLOURS.len()];
    let mut lead = Vec::new();
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let near = (row * (COLUMNS + 1) + column) as usize;
            let far = near + COLUMNS as usize + 1;
            let quad = [corner[near], corner[near + 1], corner[far + 1], corner[far]];
            let middle = quad.iter().copied().sum::<DVec3>() / 4.0;
            // The pane is the quad, shrunk by the lead around it.
            let inner = quad.map(|corner| {
                let out = corner - middle;
                corner - out * (LEAD * 1.5 / out.length())
            });
            for side in 0..4 {
                let next = (side + 1) % 4;
                lead.push([quad[side], quad[next], inner[next], inner[side]]);
            }
            panes[random.below(COLOURS.len())].push(inner);
        }
    }
    let mut objects = vec![Object::new(quads(&lead)?)];
    for (quad, kept) in panes.iter().zip(COLOURS) {
        let [red, green, blue] = kept.map(|part| 1.0 - part);
        objects.push(Object::new(quads(quad)?).with_opacity(Rgb::new(red, green, blue)));
    }
    objects.push(floor(6.0)?);
    let target = DVec3::new(0.0, 1.5, 0.0);
    let extent = LightExtent::disk(0.08);
    Ok(Scene {
        light: light(DVec3::new(1.2, 4.2, -4.5), target, 46.0, extent),
        camera: camera(DVec3::new(1.8, 2.6, 6.4), DVec3::new(-0.2, 1.3, 0.6), 42.0),
        ..Scene::of_objects(objects)
    })
}

fn quads(quads: &[[DVec3; 4]]) -> Result<Shape> {
    let positions: Vec<Vec3> = quads.iter().flatten().map(|corner| corner.as_vec3()).collect();
    let first = (0..quads.len() as u32).map(|quad| 4 * quad);
    let triangles = first.flat_map(|a| [[a, a + 1, a + 2], [a, a + 2, a + 3]]).collect();
    Ok(Shape::Mesh(TriangleMesh::new(positions, triangles)?))
}
