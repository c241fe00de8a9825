//! Pictures and shadow factors of placed scenes.

use std::ops::ControlFlow;

use deepshadow::detail::Result;
use dsm_scene::detail::{RenderSettings, Renderer};
use dsm_scene::{Scene, TracedScene};
use dsm_testkit::{Placement, Trial, check_answers, check_light_visibility};
use glam::DVec3;

use crate::methods::Method;
use crate::scene::{RADIUS, placed};

/// Width and height of a picture.
const PICTURE: [u32; 2] = [30, 20];

/// The shadow factors that the scene's camera sees.
fn picture(scene: &Scene, method: Method, trial: &Trial) -> Result<Vec<f64>> {
    let scene = placed(scene, &trial.placement);
    let traced = TracedScene::new(&scene)?;
    let settings = RenderSettings::new(2, 3)?.with_factor(true);
    let camera = scene.camera.raster(PICTURE)?;
    let renderer = Renderer::new(traced, camera, scene.light.area()?, settings);
    let shadow = method.make(&scene, trial)?;
    let image = renderer.render(&shadow, |_| ControlFlow::Continue(()))?;
    let pixels = image.map(|image| image.pixels().to_vec()).unwrap_or_default();
    Ok(pixels.as_flattened().iter().map(|&value| value.into()).collect())
}

#[test]
fn pictures_are_the_same_everywhere() {
    let mut failed = Vec::new();
    for method in Method::ALL {
        let scene = method.scene();
        let answers =
            |trial: &Trial| picture(&scene, method, trial).map_err(|error| format!("{error:#}"));
        let checked = check_answers(RADIUS, &method.agreement(), answers);
        failed.extend(checked.err().map(|error| format!("{method:?}: {error}\n")));
        let here = picture(&scene, method, &Trial::FIRST).unwrap();
        let dark = here.iter().filter(|&&factor| factor < 0.8).count();
        let lit = here.iter().filter(|&&factor| factor > 0.9).count();
        assert!(dark >= here.len() / 25 && lit > here.len() / 5, "{method:?}: {dark} {lit}");
    }
    assert!(failed.is_empty(), "{}", failed.concat());
}

#[test]
fn factors_are_the_same_everywhere() {
    let points: Vec<_> = (0..240_u32)
        .map(|index| {
            // Spread by the golden ratio and its like, in and on the scene.
            let share = |ratio: f64| (f64::from(index) * ratio).fract() - 0.5;
            let height = if index % 2 == 0 { 0.0 } else { 0.6 + 0.9 * share(0.819_172_51) };
            let position = DVec3::new(4.0 * share(0.754_877_67), height, 4.0 * share(0.569_840_29));
            Placement::receiver(position, index.into())
        })
        .collect();
    let mut failed = Vec::new();
    for method in Method::ALL {
        let scene = method.scene();
        let light = scene.light.area().unwrap();
        let make = |trial: &Trial| {
            method.make(&placed(&scene, &trial.placement), trial).unwrap_or_else(|error| {
                panic!("{method:?}: {error:#}");
            })
        };
        let checked = check_light_visibility(make, RADIUS, &points, &light, &method.agreement());
        failed.extend(checked.err().map(|error| format!("{method:?}: {error}\n")));
    }
    assert!(failed.is_empty(), "{}", failed.concat());
}
