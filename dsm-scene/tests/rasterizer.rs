//! The rasteriser of a scene against its ray tracer.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::sync::Arc;

use dsm_core::{HitSource, PixelSampling, Projection, Rgb, TileHits, TileSamples, ViewRaster};
use dsm_scene::detail::{Alpha, AlphaMode, BUILTIN_SCENES, SceneHitSource};
use dsm_scene::{
    Curves, Motion, Object, Scene, SceneRasterizer, Shape, TracedScene, Transform, TriangleMesh,
    builtin_scene,
};
use glam::{DVec3, Vec3};

/// Depth and opacity of all hits, sample by sample, by depth.
fn hits<S: HitSource<Rgb>>(source: &S, samples: &TileSamples) -> Vec<Vec<(f32, Rgb)>>
where
    S::Error: std::fmt::Debug,
{
    let mut hits = TileHits::new(samples.len());
    source.hits(samples, &mut hits).unwrap();
    let mut all = vec![Vec::new(); samples.len() as usize];
    for (sample, hit) in hits.surfaces() {
        all[sample as usize].push((hit.depth, hit.opacity));
    }
    let by_depth =
        |a: &(f32, Rgb), b: &(f32, Rgb)| (a.0.total_cmp(&b.0)).then(a.1.red.total_cmp(&b.1.red));
    all.iter_mut().for_each(|hits| hits.sort_by(by_depth));
    all
}

/// Compares both, and returns how many hits they agree on.
fn check(scene: &Scene, view: ViewRaster, near: f32, name: &str) -> usize {
    let traced = Arc::new(TracedScene::new(scene).unwrap());
    let tracer = SceneHitSource::new(Arc::clone(&traced), view).beyond(near);
    let rasterizer = SceneRasterizer::<Rgb>::new(scene, view).unwrap().beyond(near);
    let camera = view.shadow_camera();
    let sampling = PixelSampling::new(5, 2).unwrap();
    let size = view.resolution();
    // One pixel more on every side.
    let block = size.map(|side| side + 2);
    let samples = TileSamples::new(&sampling, [-1, -1], block, Some((&camera, size))).unwrap();
    let (expected, found) = (hits(&tracer, &samples), hits(&rasterizer, &samples));
    let (mut equal, mut apart) = (0, 0);
    for (expected, found) in expected.iter().zip(&found) {
        let same = expected.len() == found.len()
            && expected
                .iter()
                .zip(found)
                .all(|(a, b)| (a.0 - b.0).abs() <= 1e-5 * a.0 && (a.1.red - b.1.red).abs() < 1e-6);
        if same {
            equal += expected.len();
        } else {
            apart += 1;
        }
    }
    // Rays that graze something.
    assert!(apart * 2000 <= samples.len() as usize, "{name}: {apart} of {} differ", samples.len());
    equal
}

#[test]
fn built_in_scenes_meet_the_same() {
    let mut met = BTreeMap::new();
    for &name in BUILTIN_SCENES {
        let mut scene = builtin_scene(name).unwrap();
        let view = scene.light.raster([40, 30]).unwrap();
        met.insert(name, check(&scene, view, 0.0, name));
        scene.light.projection = Projection::Orthographic { extent: 3.0 };
        let view = scene.light.raster([30, 40]).unwrap().moved_back(0.5);
        check(&scene, view, 2.5, name);
    }
    assert!(met["hairball"] > 1000, "{met:?}");
}

/// A strand and two triangles of two materials, twice as large, moving.
fn mixed(close: Transform) -> Scene {
    let points = vec![Vec3::ZERO, Vec3::new(0.5, 0.4, 0.1), Vec3::new(1.0, 0.0, 0.5)];
    let curves = Curves::new(points, vec![0.02, 0.05, 0.0], [3]).unwrap();
    let curves = curves.with_opacities(vec![0.5; 3]).unwrap();
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.3)];
    let half = Alpha { mode: AlphaMode::Blend, factor: 0.5, ..Alpha::default() };
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [2, 1, 3]])
        .unwrap()
        .with_alphas(vec![Alpha::default(), half], vec![1, 0])
        .unwrap();
    let open = Transform { scale: 2.0, ..Transform::default() };
    let objects = [Shape::Curves(curves), Shape::Mesh(mesh)].map(|shape| {
        let object = Object::new(shape).with_opacity(Rgb::new(0.5, 0.25, 1.0));
        Object { motion: vec![Motion { open, close }], ..object }
    });
    Scene::of_objects(objects.to_vec())
}

#[test]
fn what_moves_meets_the_same() {
    let shifted = Transform { translate: DVec3::new(0.4, -0.2, 0.3), ..Transform::default() };
    let turned = Transform { rotate: DVec3::new(0.0, 30.0, 0.0), ..shifted };
    for (close, name) in [(shifted, "shifted and shrunk"), (turned, "turned")] {
        let scene = mixed(close);
        let view = scene.light.raster([48, 48]).unwrap();
        let equal = check(&scene, view, 0.0, name);
        assert!(equal > 300, "{name}: {equal}");
    }
}

#[test]
fn normals_are_those_of_the_tracer() {
    // Perspective and parallel, still and moving: the same planes, hit for hit.
    let shifted = Transform { translate: DVec3::new(0.4, -0.2, 0.3), ..Transform::default() };
    for (close, angle) in [(Transform::default(), 40.0), (shifted, 40.0), (shifted, 0.0)] {
        let mut scene = mixed(close);
        if angle == 0.0 {
            scene.light.projection = Projection::Orthographic { extent: 3.0 };
        }
        let view = scene.light.raster([24, 24]).unwrap();
        let sampling = PixelSampling::new(4, 3).unwrap();
        let samples = TileSamples::new(&sampling, [0, 0], [24, 24], None).unwrap();
        let [mut rastered, mut traced] =
            [0, 1].map(|_| TileHits::<f32>::with_normals(samples.len()));
        SceneRasterizer::new(&scene, view).unwrap().hits(&samples, &mut rastered).unwrap();
        let tracer = Arc::new(TracedScene::new(&scene).unwrap());
        SceneHitSource::new(Arc::clone(&tracer), view).hits(&samples, &mut traced).unwrap();
        let planes = |hits: &TileHits<f32>| {
            let surfaces: Vec<_> = hits.surfaces().collect();
            let plane = |&(hit, normal): &(u32, Vec3)| {
                let (sample, hit) = surfaces[hit as usize];
                (sample, hit.depth, normal)
            };
            let mut planes: Vec<_> = hits.normals().iter().map(plane).collect();
            planes.sort_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap());
            planes
        };
        let (rastered, traced) = (planes(&rastered), planes(&traced));
        // Rays that graze an edge may miss.
        let mut same = 0;
        for have in &rastered {
            let near = |want: &&(u32, f32, Vec3)| {
                want.0 == have.0 && (have.1 - want.1).abs() < 1e-4 * want.1
            };
            if let Some(want) = traced.iter().find(near) {
                // To either side.
                assert!(have.2.cross(want.2).length() < 1e-4, "{have:?} {want:?}");
                same += 1;
            }
        }
        let counts = [same, rastered.len(), traced.len()];
        assert!(same > 50 && same + 3 >= rastered.len().max(traced.len()), "{counts:?}");
    }
}
