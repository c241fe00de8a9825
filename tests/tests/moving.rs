//! Layered maps of what moves, against rays through the scene at times all over the shutter.

#![expect(clippy::unwrap_used, reason = "a test may stop where a scene or a file is refused")]
#![expect(clippy::print_stdout, reason = "what was measured")]

use std::ops::ControlFlow;
use std::sync::Arc;

use deepshadow::detail::Result;
use deepshadow::{Bake, Kind, PcfMethod, Query, Shadow, ShadowMap, TraceMethod, bake};
use dsm_core::{LightExtent, Projection, View};
use dsm_scene::{Light, Motion, Object, Scene, Shape, TracedScene, Transform, TriangleMesh};
use glam::{DVec3, Vec3};

const GROUND: f32 = 4.0;

fn rectangle(half: [f32; 2], height: f32) -> Shape {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corners = corners.map(|[x, z]| Vec3::new(x * half[0], height, z * half[1]));
    Shape::Mesh(TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap())
}

/// Cards that fly over a ground, each its own way and in the light of others.
fn flying(shift: f64) -> Scene {
    let mut objects = vec![Object::new(rectangle([GROUND, GROUND], 0.0))];
    for number in 0..5_u8 {
        let turn = 2.1 * f64::from(number);
        let way = DVec3::new(turn.cos(), 0.3 * turn.sin(), turn.sin()) * shift;
        let at = DVec3::new(0.6 * turn.sin(), 1.0 + 0.2 * f64::from(number), 0.8 * turn.cos());
        let place = |translate, rotate| Transform { translate, rotate, ..Transform::default() };
        let mut card = Object::new(rectangle([0.5, 0.3], 0.0));
        let (first, last) = (DVec3::new(0.0, 30.0, 0.0), DVec3::new(20.0, 50.0, 0.0));
        let last = if shift > 0.0 { last } else { first };
        card.motion.push(Motion { open: place(at - way, first), close: place(at + way, last) });
        objects.push(card);
    }
    let light = Light {
        view: View { eye: DVec3::new(1.0, 6.0, 1.5), target: DVec3::ZERO, up: DVec3::Z },
        projection: Projection::Perspective { fov: 50.0 },
        extent: LightExtent::rectangle([0.8, 0.8]),
    };
    Scene::of_objects(objects).with_light(light)
}

/// Places on the ground.
fn receivers() -> Vec<DVec3> {
    let along = |at: u32| -1.9 + 3.8 * f64::from(at) / 39.0;
    (0..1600).map(|at| DVec3::new(along(at % 40), 0.0, along(at / 40))).collect()
}

fn settings(kind: &str, samples: Option<u32>) -> Bake {
    let settings = Bake::new([256; 2]).unwrap().with_kind(Kind::named(kind).unwrap());
    if let Some(samples) = samples { settings.with_samples(samples) } else { settings }
}

fn from_file(scene: &Scene, settings: &Bake, query: &Query) -> Result<Shadow> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    bake(scene, &scene.light, settings, &path, |_| ControlFlow::Continue(()))?;
    ShadowMap::open(&path)?.shadow(query)
}

/// The root of the mean square of what a map's answers are off by, and their mean.
fn off(scene: &Scene, kind: &str, samples: Option<u32>) -> [f64; 2] {
    let traced = Arc::new(TracedScene::new(scene).unwrap());
    let truth = Shadow::reference(traced, scene, 1024).unwrap().query(&receivers()).unwrap();
    let query = Query::new().with_method(TraceMethod::new(256));
    let shadow = from_file(scene, &settings(kind, samples), &query).unwrap();
    let found = shadow.query(&receivers()).unwrap();
    let count = receivers().len();
    let off = |at: usize| f64::from(found.rgb(at)[0] - truth.rgb(at)[0]);
    let mean =
        |of: &dyn Fn(f64) -> f64| (0..count).map(|at| of(off(at))).sum::<f64>() / count as f64;
    let found = [mean(&|off| off * off).sqrt(), mean(&|off| off)];
    println!("{kind}, samples {samples:?}: RMSE {:.4}, mean {:+.4}", found[0], found[1]);
    found
}

#[test]
fn traced_maps_over_time_are_close_to_rays_at_all_times() {
    // A place of a map of fragments has a time of its own, so that a ray through two places
    // meets things at two times: what several of them stop together is off by more. Layers
    // of a pixel are what all its times leave behind each other.
    let scene = flying(0.6);
    for (kind, times, most) in
        [("fragments", 64, 0.085), ("fragments", 16, 0.09), ("layers", 32, 0.015)]
    {
        let [still, _] = off(&scene, kind, None);
        let [over_time, mean] = off(&scene, kind, Some(times));
        assert!(over_time < most && mean.abs() < 0.03, "{kind}: {over_time} {mean}");
        assert!(over_time < 0.5 * still, "{kind}: {still} {over_time}");
    }
}

#[test]
fn what_stands_still_does_not_change_with_times() {
    let scene = flying(0.0);
    let trace = Query::new().with_method(TraceMethod::new(64));
    let filter = Query::new().with_method(PcfMethod::new(64));
    for (kind, query) in [("fragments", &trace), ("layers", &trace), ("layers", &filter)] {
        let answers = |samples| {
            let shadow = from_file(&scene, &settings(kind, samples), query).unwrap();
            let values = shadow.query(&receivers()).unwrap();
            (0..receivers().len()).map(|at| values.rgb(at)).collect::<Vec<_>>()
        };
        let one = answers(None);
        assert!(one.iter().any(|value| value[0] < 1.0), "{kind}");
        assert_eq!(one, answers(Some(9)), "{kind}");
    }
}

#[test]
fn times_are_no_more_than_places() {
    let scene = flying(0.1);
    let query = Query::new();
    for (kind, coverage, samples) in
        [("fragments", Some(2), 5), ("fragments", None, 65), ("layers", None, 5000)]
    {
        let mut settings = settings(kind, Some(samples));
        settings.coverage = coverage;
        assert!(from_file(&scene, &settings, &query).is_err(), "{kind} {samples}");
    }
    let mut settings = settings("fragments", Some(4));
    settings.coverage = Some(2);
    assert!(from_file(&scene, &settings, &query).is_ok());
}
