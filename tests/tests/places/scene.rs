//! A small scene that can be placed anywhere.

use dsm_core::{LightExtent, Projection, Rgb, View};
use dsm_scene::detail::Camera;
use dsm_scene::{Curves, Light, Motion, Object, Scene, Shape, Transform, TriangleMesh, Volume};
use dsm_testkit::Placement;
use glam::{DVec3, IVec3, UVec3, Vec3};

/// Of a ball around all that is looked at.
pub(crate) const RADIUS: f64 = 3.0;

/// A floor, leaves above it of which one lets light through, and a tuft.
pub(crate) fn solid() -> Scene {
    let floor = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]];
    let floor = floor.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec();
    let floor = TriangleMesh::new(floor, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let leaf = |turn: f32, height: f32| {
        let (sin, cos) = turn.sin_cos();
        let corner = |along: f32, across: f32, up: f32| {
            Vec3::new(cos * along - sin * across, height + up, sin * along + cos * across)
        };
        [corner(0.1, -0.3, 0.0), corner(1.6, 0.1, 0.35), corner(0.3, 0.7, 0.15)]
    };
    let corners: Vec<Vec3> =
        (0..7_u8).flat_map(|n| leaf(0.9 * f32::from(n), 0.4 + 0.13 * f32::from(n))).collect();
    let triangle = |n: u32| [3 * n, 3 * n + 1, 3 * n + 2];
    let leaves = TriangleMesh::new(corners.clone(), (0..6).map(triangle).collect()).unwrap();
    let pane = TriangleMesh::new(corners, vec![triangle(6)]).unwrap();
    let (mut points, mut radii) = (Vec::new(), Vec::new());
    for strand in 0..30_u8 {
        let turn = f32::from(strand) * 2.399_963;
        let root = Vec3::new(turn.cos(), 0.0, turn.sin()) * (0.12 * f32::from(strand).sqrt());
        for step in 0..4_u8 {
            let up = f32::from(step) * 0.3;
            points.push(root * (1.0 + 0.6 * up) + Vec3::new(-1.3, up, 1.2));
            radii.push(0.02 - 0.004 * f32::from(step));
        }
    }
    let tuft = Curves::new(points, radii, [4; 30]).unwrap();
    let objects = vec![
        Object::new(Shape::Mesh(floor)),
        Object::new(Shape::Mesh(leaves)),
        Object::new(Shape::Mesh(pane)).with_opacity(Rgb::new(0.4, 0.4, 0.4)),
        Object::new(Shape::Curves(tuft)).with_opacity(Rgb::new(0.7, 0.7, 0.7)),
    ];
    let target = DVec3::new(0.1, 0.5, -0.2);
    let up = DVec3::Y;
    let light = Light {
        view: View { eye: DVec3::new(2.0, 6.0, 3.0), target, up },
        projection: Projection::Perspective { fov: 50.0 },
        extent: LightExtent::rectangle([0.9, 0.6]),
    };
    let camera = Camera {
        view: View { eye: DVec3::new(-3.0, 4.0, 5.0), target, up },
        fov: 40.0,
        resolution: [36, 24],
    };
    Scene::of_objects(objects).with_light(light).with_camera(camera)
}

/// [`solid`] in a mist.
pub(crate) fn misty() -> Scene {
    let mut scene = solid();
    let density = |at: IVec3| (at.x + 2 * at.y + at.z) as f32 / 20.0;
    let corner = DVec3::new(-1.0, 0.2, -1.3);
    let mist = Volume::from_fn(UVec3::splat(6), DVec3::splat(0.35), corner, density).unwrap();
    let mist = Object::new(Shape::Volume(mist)).with_opacity(Rgb::new(0.9, 0.9, 0.9));
    scene.objects.push(Object { density: 0.5, ..mist });
    scene
}

/// The scene elsewhere, with its light and its camera: a similarity leaves the picture.
pub(crate) fn placed(scene: &Scene, placement: &Placement) -> Scene {
    let mut scene = scene.clone();
    let (scale, translate) = (placement.scale(), placement.shift());
    let transform = Transform { translate, scale, ..Transform::default() };
    for object in &mut scene.objects {
        object.motion.push(Motion::still(transform));
        // Extinctions count per unit of the world.
        object.density = (f64::from(object.density) / scale) as f32;
    }
    for view in [&mut scene.light.view, &mut scene.camera.view] {
        view.eye = placement.point(view.eye);
        view.target = placement.point(view.target);
    }
    let larger = scene.light.extent.size().map(|side| side * scale);
    scene.light = scene.light.with_size(larger).unwrap();
    scene
}
