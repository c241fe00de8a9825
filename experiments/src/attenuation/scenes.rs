//! Scenes like the paper's plant, flower and dragon, and a box as in its figure 11.

use std::f64::consts::TAU;

use anyhow::Result;
use dsm_core::View;
use dsm_core::detail::random::{next_bits, unit};
use dsm_scene::detail::Camera;
use dsm_scene::{Curves, Object, Scene, Shape, TriangleMesh, builtin_scene};
use glam::{DVec3, Vec3};

/// Where the built-in scenes have their middle, which their light looks at.
const MIDDLE: DVec3 = DVec3::new(0.0, 1.1, 0.0);

/// Stems of the flower's head, and the points of each.
const STEMS: u32 = 12_000;
const POINTS: u32 = 9;

/// Rings around the knot, and corners of a ring.
const RINGS: u32 = 1200;
const CORNERS: u32 = 128;

/// The three scenes, each lit and seen as the built-in ones are.
///
/// # Errors
///
/// None: they are always the same.
pub(crate) fn scenes() -> Result<[(&'static str, Scene); 3]> {
    Ok([("foliage", builtin_scene("foliage")?), ("flower", flower()?), ("knot", knot()?)])
}

/// With a light and a camera of a built-in scene, over a floor.
fn stage(objects: Vec<Object>) -> Result<Scene> {
    let corner = |x, z| Vec3::new(x, 0.0, z) * 8.0;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = corners.map(|(x, z)| corner(x, z)).to_vec();
    let floor = TriangleMesh::new(corners, vec![[0, 2, 1], [0, 3, 2]])?;
    let objects = objects.into_iter().chain([Object::new(Shape::Mesh(floor))]).collect();
    Ok(builtin_scene("foliage")?.with_objects(objects))
}

/// Even in [−1, 1).
fn signed(state: &mut u64) -> f64 {
    2.0 * unit(next_bits(state)) - 1.0
}

/// A direction, evenly over the sphere.
fn direction(state: &mut u64) -> DVec3 {
    let (high, turn) = (signed(state), TAU * unit(next_bits(state)));
    let wide = (1.0 - high * high).max(0.0).sqrt();
    DVec3::new(wide * turn.cos(), high, wide * turn.sin())
}

/// A head of opaque stems, each far thinner than a pixel of a shadow map, on a stalk.
fn flower() -> Result<Scene> {
    let mut state = 0x0f10_3e57;
    let mut points: Vec<Vec3> = Vec::with_capacity((STEMS * POINTS) as usize);
    for _ in 0..STEMS {
        let out = direction(&mut state);
        let bend = direction(&mut state) * 0.1;
        let length = 0.6 + 0.2 * signed(&mut state);
        for point in 0..POINTS {
            let along = f64::from(point) / f64::from(POINTS - 1);
            let grown = out * (0.12 + length * along) + bend * (along * along);
            points.push((MIDDLE + grown).as_vec3());
        }
    }
    let radii = vec![1.0 / 1024.0; points.len()];
    let head = Curves::new(points, radii, (0..STEMS).map(|_| POINTS))?;
    let foot = MIDDLE.with_y(0.0).as_vec3();
    let stalk = Curves::new(vec![foot, MIDDLE.as_vec3()], vec![0.03; 2], [2])?;
    stage([head, stalk].map(|curves| Object::new(Shape::Curves(curves))).to_vec())
}

/// A tube along a (2, 3) torus knot, of 307,200 triangles.
fn knot() -> Result<Scene> {
    let spine = |share: f64| {
        let turn = TAU * share;
        let wide = 2.0 + (3.0 * turn).cos();
        let place =
            DVec3::new(wide * (2.0 * turn).cos(), wide * (2.0 * turn).sin(), (3.0 * turn).sin());
        MIDDLE + 0.26 * place
    };
    let mut positions = Vec::with_capacity((RINGS * CORNERS) as usize);
    let mut triangles = Vec::with_capacity((2 * RINGS * CORNERS) as usize);
    for ring in 0..RINGS {
        let share = f64::from(ring) / f64::from(RINGS);
        let along = (spine(share + 1e-4) - spine(share - 1e-4)).normalize();
        // The spine never runs towards the middle.
        let right = along.cross(spine(share) - MIDDLE).normalize();
        let up = along.cross(right);
        for corner in 0..CORNERS {
            let (sin, cos) = (TAU * f64::from(corner) / f64::from(CORNERS)).sin_cos();
            positions.push((spine(share) + (right * cos + up * sin) * 0.15).as_vec3());
            let (next, beside) = ((ring + 1) % RINGS, (corner + 1) % CORNERS);
            let at = |ring: u32, corner: u32| ring * CORNERS + corner;
            let [a, b] = [at(ring, corner), at(ring, beside)];
            let [c, d] = [at(next, corner), at(next, beside)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    stage(vec![Object::new(Shape::Mesh(TriangleMesh::new(positions, triangles)?))])
}

/// A tall box whose sides the light hardly sees, and a card over the floor (figure 11): the
/// scene, and a camera close to the floor where the card's shadow ends.
///
/// # Errors
///
/// None: it is always the same.
pub(super) fn boxes() -> Result<(Scene, Camera)> {
    let corner = |index: u32| {
        let side = |bit: u32, low: f32, high: f32| if index >> bit & 1 > 0 { high } else { low };
        Vec3::new(side(0, -0.3, 0.3), side(1, 0.0, 1.6), side(2, -0.3, 0.3))
    };
    let faces =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let halves = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let solid = TriangleMesh::new((0..8).map(corner).collect(), halves.collect())?;
    let card = [[-1.2, -0.4], [-0.7, -0.4], [-0.7, 0.4], [-1.2, 0.4]];
    let card = card.map(|[x, z]: [f32; 2]| Vec3::new(x, 0.5, z)).to_vec();
    let card = TriangleMesh::new(card, vec![[0, 1, 2], [0, 2, 3]])?;
    let scene = stage([solid, card].map(|mesh| Object::new(Shape::Mesh(mesh))).to_vec())?;
    let mut scene = scene;
    // Steep, so that sides are seen at grazing angles.
    let eye = DVec3::new(0.4, 6.0, 0.3);
    scene.light.view = View { eye, target: DVec3::new(-0.2, 0.8, 0.0), ..scene.light.view };
    let view =
        View { eye: DVec3::new(-1.9, 1.6, 2.2), target: DVec3::new(-1.0, 0.0, 0.5), up: DVec3::Y };
    let close = Camera { view, fov: 7.0, ..scene.camera };
    Ok((scene, close))
}
