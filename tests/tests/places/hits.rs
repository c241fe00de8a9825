//! What shadow cameras see of placed scenes, and single rays through them.

use std::sync::Arc;

use dsm_core::{HitSource, OcclusionTracer, Projection, Rgb, TileHits, TileSamples, ViewRaster};
use dsm_scene::detail::{SceneHitSource, SceneReference};
use dsm_scene::{Error, Scene, SceneRasterizer, Shape, TracedScene};
use dsm_testkit::{Agreement, Trial, check_hit_source, check_occlusion_tracer};
use glam::DVec3;

use crate::scene::{RADIUS, misty, placed};

const SIZE: [u32; 2] = [40, 40];

/// A scene with its hierarchies, and what looks at it.
struct Owned {
    traced: Arc<TracedScene>,
    raster: ViewRaster,
}

impl HitSource<Rgb> for Owned {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<Rgb>) -> Result<(), Error> {
        SceneHitSource::new(Arc::clone(&self.traced), self.raster).hits(samples, hits)
    }
}

impl OcclusionTracer for Owned {
    type Value = Rgb;
    type Error = std::convert::Infallible;

    fn transmittance(&self, from: DVec3, to: DVec3, time: f64) -> Result<Rgb, Self::Error> {
        SceneReference::new(Arc::clone(&self.traced)).transmittance(from, to, time)
    }
}

fn scenes() -> [Scene; 2] {
    let perspective = misty();
    let mut orthographic = misty();
    orthographic.light.projection = Projection::Orthographic { extent: 5.0 };
    [perspective, orthographic]
}

/// The scene of a trial; parallel rays see as much more of a larger one.
fn placed_with_extent(scene: &Scene, trial: &Trial) -> Scene {
    let mut scene = placed(scene, &trial.placement);
    if let Projection::Orthographic { extent } = &mut scene.light.projection {
        *extent *= trial.placement.scale();
    }
    scene
}

fn owned(scene: &Scene, trial: &Trial) -> Owned {
    let scene = placed_with_extent(scene, trial);
    let raster = scene.light.raster(SIZE).unwrap();
    Owned { traced: Arc::new(TracedScene::new(&scene).unwrap()), raster }
}

#[test]
fn rays_meet_the_same_everywhere() {
    for scene in scenes() {
        let camera = scene.light.raster(SIZE).unwrap().shadow_camera();
        let agreement = Agreement::default();
        let make = |trial: &Trial| owned(&scene, trial);
        check_hit_source(make, RADIUS, &camera, SIZE, &agreement).unwrap();
        let rasterised = |trial: &Trial| {
            let scene = placed_with_extent(&scene, trial);
            let raster = scene.light.raster(SIZE).unwrap();
            SceneRasterizer::<Rgb>::new(&scene, raster).unwrap()
        };
        check_hit_source(rasterised, RADIUS, &camera, SIZE, &agreement).unwrap();
    }
}

#[test]
fn rays_from_things_leave_them_everywhere() {
    let [scene, _] = scenes();
    let light = DVec3::new(2.0, 6.0, 3.0);
    let mut rays = Vec::new();
    for object in &scene.objects {
        let Shape::Mesh(mesh) = &*object.shape else { continue };
        for (triangle, step) in
            (0..mesh.triangles().len()).flat_map(|n| (0..60_u32).map(move |s| (n, s)))
        {
            let share = |ratio: f64| (f64::from(step) * ratio).fract();
            let (u, v) = (share(0.754_877_67), share(0.569_840_29));
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let [a, b, c] = mesh.corners(triangle).map(|corner| corner.as_dvec3());
            rays.push((a + (b - a) * u + (c - a) * v, light, 0.0));
        }
    }
    let make = |trial: &Trial| owned(&scene, trial);
    check_occlusion_tracer(make, RADIUS, &rays, &Agreement::default()).unwrap();
    // Nothing else is so near that a thousand times as much changes anything.
    let first = owned(&scene, &Trial::FIRST);
    let later = SceneReference::<Rgb>::new(Arc::clone(&first.traced)).with_start(1e-9);
    for &(receiver, light, time) in &rays {
        let Ok(want) = later.transmittance(receiver, light, time);
        let Ok(have) = first.transmittance(receiver, light, time);
        assert_eq!(have, want, "{receiver}");
    }
}
