//! Pictures against answers that are known.

#![cfg(test)]

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::Arc;

use dsm_core::{AreaLight, LightVisibility, Rgb, Transmittance, View};
use dsm_scene::detail::{Camera, Image, RenderSettings, Renderer, SceneReference};
use dsm_scene::{Object, Scene, Shape, TracedScene, TriangleMesh, Volume};
use glam::{DVec3, IVec3, UVec3, Vec3};

/// Looks down from height 10 onto 4 × 4 units of the ground.
const CAMERA: Camera = Camera {
    view: View { eye: DVec3::new(0.0, 10.0, 0.0), target: DVec3::ZERO, up: DVec3::NEG_Z },
    fov: 22.619_864_948_040_43,
    resolution: [16, 16],
};

/// A square at a height, around (x, z).
fn square(x: f32, z: f32, height: f32, half: f32) -> Object {
    let corner = |dx, dz| Vec3::new(x + dx * half, height, z + dz * half);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    Object::new(Shape::Mesh(mesh))
}

fn grey(opacity: f32) -> Rgb {
    Rgb::new(opacity, opacity, opacity)
}

fn render<T: Transmittance>(objects: Vec<Object>, light: DVec3, settings: RenderSettings) -> Image {
    let traced = Arc::new(TracedScene::new(&Scene::of_objects(objects)).unwrap());
    let camera = CAMERA.raster(CAMERA.resolution).unwrap();
    let renderer = Renderer::new(Arc::clone(&traced), camera, AreaLight::point(light), settings);
    let shadow = SceneReference::<T>::new(Arc::clone(&traced));
    let Ok(image) = renderer.render(&shadow, |_| ControlFlow::Continue(()));
    image.unwrap()
}

fn settings(samples: u32) -> RenderSettings {
    RenderSettings::new(samples, 5).unwrap()
}

#[track_caller]
fn assert_near(pixel: [f32; 3], expected: [f64; 3], margin: f64) {
    for (value, expected) in pixel.into_iter().zip(expected) {
        assert!((f64::from(value) - expected).abs() <= margin, "{pixel:?} {expected:?}");
    }
}

#[test]
fn a_lit_floor_follows_the_cosine() {
    let light = DVec3::new(-3.0, 2.0, 1.0);
    let image = render::<f32>(vec![square(0.0, 0.0, 0.0, 9.0)], light, settings(64));
    for (index, &pixel) in image.pixels().iter().enumerate() {
        let (x, z) = ((index % 16) as f64, (index / 16) as f64);
        let at = DVec3::new((x + 0.5) / 4.0 - 2.0, 0.0, (z + 0.5) / 4.0 - 2.0);
        assert_near(pixel, [0.8 * (light - at).normalize().y; 3], 4e-3);
    }
}

#[test]
fn factors_are_the_shadows_alone() {
    // The light stands over the middle: the shadow of x < 0 at height 1 ends
    // at x = 0.
    let mut sheet = square(-30.0, 0.0, 1.0, 30.0).with_opacity(grey(0.25));
    // Seen from above, the camera meets the sheet itself too, which is lit.
    let floor = square(0.0, 0.0, 0.0, 1.0);
    let factor = settings(256).with_factor(true);
    let light = DVec3::new(0.0, 2.0, 0.0);
    let image = render::<f32>(vec![sheet.clone(), floor.clone()], light, factor.clone());
    let pixel = |x: usize, y: usize| image.pixels()[y * 16 + x];
    // A quarter of the rays ends on the sheet; the floor keeps three quarters.
    assert_near(pixel(5, 8), [0.25 + 0.75 * 0.75; 3], 1e-2);
    assert_near(pixel(10, 8), [1.0; 3], 0.0);
    // Beyond the floor, only the sheet is met.
    assert_near(pixel(1, 1), [1.0; 3], 0.0);
    // From below the light, the sheet's upper side shades itself.
    sheet = square(0.0, 0.0, 3.0, 30.0);
    let image = render::<f32>(vec![sheet, floor], light, factor);
    assert_near(image.pixels()[0], [0.0; 3], 0.0);
}

#[test]
fn what_is_seen_through_coloured_panes_is_coloured() {
    let pane = square(0.0, 0.0, 1.0, 5.0).with_opacity(Rgb::new(0.1, 0.5, 0.9));
    let floor = square(0.0, 0.0, 0.0, 50.0);
    // The light is between the two: the floor is lit, the pane from below.
    let light = DVec3::new(0.0, 0.9, 0.0);
    let image = render::<Rgb>(vec![pane.clone(), floor.clone()], light, settings(1024));
    let lit = |at: DVec3| 0.8 * (light - at).normalize().y;
    let mean = |of: &dyn Fn(DVec3) -> f64| {
        let steps = (0..8).flat_map(|x| (0..8).map(move |z| (f64::from(x), f64::from(z))));
        steps
            .map(|(x, z)| of(DVec3::new(x / 32.0 + 1.0 / 64.0, 0.0, z / 32.0 + 1.0 / 64.0)))
            .sum::<f64>()
            / 64.0
    };
    let floor_light = mean(&lit);
    let pixel = image.pixels()[8 * 16 + 8];
    assert_near(pixel, [0.9, 0.5, 0.1].map(|kept| kept * floor_light), 8e-3);
    // Lit from above it scatters what it blocks in all channels, and its
    // shadow is coloured.
    let light = DVec3::new(0.0, 1000.0, 0.0);
    let image = render::<Rgb>(vec![pane, floor], light, settings(1024));
    let expected = [0.9, 0.5, 0.1].map(|kept: f64| 0.8 * (0.1 + kept * kept));
    assert_near(image.pixels()[8 * 16 + 8], expected, 1e-2);
}

#[test]
fn media_are_as_bright_as_they_are_dense() {
    // From height 0 to 1 on average, of density 1.
    let volume = |_: IVec3| 1.0_f32;
    let size = UVec3::new(40, 10, 40);
    let start = DVec3::new(-4.0, 0.05, -4.0);
    let volume = Volume::from_fn(size, DVec3::new(0.2, 0.1, 0.2), start, volume).unwrap();
    let medium = Object { density: 1.5, ..Object::new(Shape::Volume(volume)) };
    let light = DVec3::new(0.0, 1000.0, 0.0);
    let depth = 1.5;
    let shown = 1.0 - f64::exp(-depth);
    let unshadowed = settings(1024).with_self_shadowing(false);
    let image = render::<f32>(vec![medium.clone()], light, unshadowed);
    assert_near(image.pixels()[8 * 16 + 8], [0.8 * shown; 3], 4e-3);
    // In its own shadow: ∫ exp(−2 τ) dτ, for light and camera look the same
    // way.
    let image = render::<f32>(vec![medium.clone()], light, settings(1024));
    let shadowed = 0.5 * (1.0 - f64::exp(-2.0 * depth));
    assert_near(image.pixels()[8 * 16 + 8], [0.8 * shadowed; 3], 4e-3);
    // A floor behind it is as bright as what is left, twice.
    let image = render::<f32>(vec![medium, square(0.0, 0.0, -1.0, 50.0)], light, settings(1024));
    let floor = f64::exp(-2.0 * depth);
    assert_near(image.pixels()[8 * 16 + 8], [0.8 * (shadowed + floor); 3], 4e-3);
}

#[test]
fn threads_change_no_bit_and_seeds_do() {
    let scene = dsm_scene::builtin_scene("hairball").unwrap();
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let light = scene.light.area().unwrap();
    let render = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let camera = scene.camera.raster([45, 33]).unwrap();
        let settings = RenderSettings::new(2, seed).unwrap();
        let renderer = Renderer::new(Arc::clone(&traced), camera, light, settings);
        let shadow = SceneReference::<f32>::new(Arc::clone(&traced)).with_rays(2);
        let Ok(image) = pool.install(|| renderer.render(&shadow, |_| ControlFlow::Continue(())));
        image.unwrap()
    };
    let one = render(1, 0);
    assert_eq!(one, render(3, 0));
    assert_ne!(one, render(1, 1));
}

#[test]
fn a_picture_can_be_broken_off_and_a_shadow_can_fail() {
    struct Failing;
    impl LightVisibility for Failing {
        type Value = f32;
        type Error = &'static str;

        fn visibility(&self, _: DVec3, _: &AreaLight, _: u64) -> Result<f32, &'static str> {
            Err("no light")
        }
    }
    let scene = Scene::of_objects(vec![square(0.0, 0.0, 0.0, 9.0)]);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let camera = CAMERA.raster([40, 40]).unwrap();
    let light = AreaLight::point(DVec3::Y);
    let renderer = Renderer::new(Arc::clone(&traced), camera, light, settings(1));
    assert_eq!(renderer.render(&Failing, |_| ControlFlow::Continue(())), Err("no light"));
    let shadow = SceneReference::<f32>::new(Arc::clone(&traced));
    let stop = |progress: dsm_core::Progress| {
        assert_eq!(progress.total, 9);
        if progress.done > 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let broken: Result<_, Infallible> = renderer.render(&shadow, stop);
    assert_eq!(broken, Ok(None));
}
