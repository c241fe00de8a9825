//! Scenes whose soft shadows are known: panes, cards, lights of any size, and one scene
//! moved and scaled.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use dsm_core::LightVisibility;
use dsm_scene::detail::SceneReference;
use dsm_scene::{TracedScene, open_scene};
use glam::DVec3;
use serde_json::Value;

use crate::layers::lights;
use crate::maps::Folder;
use crate::run;

/// A file from beside the project, or `None` and a message.
fn given(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/cases/soft").join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

fn bake(folder: &Folder, scene: &Path, more: &[&str]) -> PathBuf {
    let map = folder.path("map.dsm");
    let base = ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap()];
    let same = ["--kind", "fragments", "--quiet"];
    run::run(base.iter().chain(&same).chain(more)).stdout();
    map
}

/// What the map of a scene answers at the points of a file.
fn answers(folder: &Folder, scene: &str, points: &str, more: [&[&str]; 2]) -> Option<Vec<f64>> {
    let (scene, points) = (given(scene)?, given(points)?);
    let map = bake(folder, &scene, more[0]);
    let base = ["lookup", map.to_str().unwrap(), "--points", points.to_str().unwrap()];
    Some(lights(&run::run(base.iter().chain(more[1])).stdout()))
}

#[test]
fn panes_let_through_what_all_of_them_do() {
    let folder = Folder::new();
    for (scene, points, want) in
        [("stack.toml", "p.csv", 0.95_f64.powi(64)), ("pane90.toml", "below.csv", 0.1)]
    {
        let more: [&[&str]; 2] = [&["--resolution", "256"], &[]];
        let Some(found) = answers(&folder, scene, points, more) else { return };
        assert!(!found.is_empty());
        for light in found {
            assert!((light - want).abs() < 1e-4, "{scene}: {light} and not {want}");
        }
    }
}

#[test]
fn a_tilted_card_lets_nothing_through() {
    let folder = Folder::new();
    let more: [&[&str]; 2] = [&["--resolution", "64"], &["--space", "raster"]];
    let Some(found) = answers(&folder, "tilted-opaque.toml", "raster_points.csv", more) else {
        return;
    };
    assert!(found.len() > 1000 && found.iter().all(|&light| light == 0.0), "{found:?}");
    for size in ["1e-30", "1e-20", "1e-10", "1e-5"] {
        let more: [&[&str]; 2] =
            [&["--resolution", "64"], &["--space", "raster", "--light-size", size]];
        let Some(found) = answers(&folder, "tiny-light.toml", "raster_points.csv", more) else {
            return;
        };
        let lit = found.iter().filter(|&&light| light > 0.0).count();
        assert_eq!(lit, 0, "{size}");
    }
}

/// An opaque card below a light that hangs over the border of four pixels.
const CARD: &str = r#"
[light]
eye = [0, 4, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov = 40.0
shape = "rectangle"
size = [0.5, 0.5]

[[object]]
mesh = "card.obj"
"#;

#[test]
fn rays_along_the_borders_of_pixels_pass_no_card() {
    let folder = Folder::new();
    folder.write("card.obj", "v -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 1 2 3 4\n");
    let scene = folder.write("card.toml", CARD);
    let places = (2..62).step_by(2).flat_map(|y| (2..62).step_by(2).map(move |x| (x, y)));
    let rows: String = places.map(|(x, y)| format!("{x},{y},20\n")).collect();
    let points = folder.write("p.csv", format!("x,y,z\n{rows}"));
    let map = bake(&folder, &scene, &["--resolution", "64"]);
    for size in ["0", "1e-30", "1e-20", "1e-10", "1e-5", "0.5"] {
        let base = ["lookup", map.to_str().unwrap(), "--points", points.to_str().unwrap()];
        let light = ["--space", "raster", "--light-size", size];
        let found = lights(&run::run(base.iter().chain(&light)).stdout());
        assert_eq!(found.len(), 900);
        let lit = found.iter().filter(|&&light| light > 0.0).count();
        assert_eq!(lit, 0, "{size}: {found:?}");
    }
}

/// Draws a scene, and compares the picture with another one if there is one.
fn draw(scene: &Path, image: &Path, more: &[&str]) -> Value {
    let base = ["render", scene.to_str().unwrap(), "-o", image.to_str().unwrap()];
    let few = ["--samples", "4", "--json", "--quiet"];
    run::run(base.iter().chain(&few).chain(more)).json()
}

fn rmse(told: &Value) -> f64 {
    told["compare"]["rmse"].as_f64().unwrap()
}

#[test]
fn the_lower_side_of_a_card_is_black() {
    let folder = Folder::new();
    let Some(scene) = given("leaf.toml") else { return };
    let (black, image) = (folder.path("black.exr"), folder.path("image.exr"));
    draw(&scene, &black, &["--method", "reference"]);
    let told = draw(&scene, &image, &["--method", "trace", "--compare", black.to_str().unwrap()]);
    assert_eq!(told["compare"]["max"], 0.0, "{told}");
    // The reference has no light there either, of which the factor is 0.
    let told = draw(&scene, &image, &["--method", "trace", "--factor"]);
    assert_eq!(told["warnings"], serde_json::json!([]));
    let white = folder.path("white.exr");
    draw(&scene, &white, &["--method", "reference", "--light-size", "0"]);
    let told = draw(&scene, &image, &["--method", "trace", "--compare", white.to_str().unwrap()]);
    assert_eq!(rmse(&told), 0.0, "{told}");
}

#[test]
fn shadows_of_cards_and_panes_are_the_references_at_every_resolution() {
    let folder = Folder::new();
    let (reference, image) = (folder.path("reference.exr"), folder.path("image.exr"));
    for (of_map, of_picture) in [("pane-ground.toml", "pane-ground.toml"), ("c.toml", "cg.toml")] {
        let (Some(of_map), Some(scene)) = (given(of_map), given(of_picture)) else { return };
        let few = ["--resolution", "48", "--factor", "--rays", "64"];
        let with = |more: &[&'static str]| -> Vec<&str> { [&few[..], more].concat() };
        draw(&scene, &reference, &with(&["--method", "reference"]));
        for resolution in ["64", "200", "512"] {
            let map = bake(&folder, &of_map, &["--resolution", resolution]);
            let mut more = with(&["--method", "trace"]);
            more.extend(["--map", map.to_str().unwrap()]);
            more.extend(["--compare", reference.to_str().unwrap()]);
            let told = draw(&scene, &image, &more);
            assert!(rmse(&told) < 0.003, "{of_picture} {resolution}: {told}");
        }
    }
}

#[test]
fn points_on_the_ground_below_a_pane_are_as_dark_as_it_is() {
    let folder = Folder::new();
    let Some(scene) = given("pane-ground.toml") else { return };
    let opened = open_scene(&scene).unwrap();
    let light = opened.light.area().unwrap();
    let traced = Arc::new(TracedScene::new(&opened).unwrap());
    let reference = SceneReference::<f32>::new(traced).with_rays(1024);
    let text = std::fs::read_to_string(given("g.csv").unwrap()).unwrap();
    let truth = text.lines().skip(1).map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let Ok(light) = reference.visibility(DVec3::from_slice(&numbers), &light, 1);
        f64::from(light)
    });
    let truth: Vec<f64> = truth.collect();
    for resolution in ["64", "200", "512"] {
        let more: [&[&str]; 2] = [&["--resolution", resolution], &["--rays", "1024"]];
        let found = answers(&folder, "pane-ground.toml", "g.csv", more).unwrap();
        assert_eq!(found.len(), 4);
        for (found, truth) in found.iter().zip(&truth) {
            assert!((found - truth).abs() < 0.01, "{resolution}: {found} and not {truth}");
        }
    }
}

#[test]
fn one_scene_moved_and_scaled_gives_one_picture() {
    let folder = Folder::new();
    let image = folder.path("image.exr");
    let few = ["--resolution", "48x27", "--factor", "--rays", "64"];
    let mut error = Vec::new();
    for scene in ["scale-1.toml", "scale-0.001.toml", "scale-50.toml", "shifted-150.toml"] {
        let Some(path) = given(scene) else { return };
        for method in ["reference", "trace"] {
            let mut more = [&few[..], &["--method", method]].concat();
            let compared = folder.path(&format!("{method}.exr"));
            if scene == "scale-1.toml" {
                draw(&path, &compared, &more);
                continue;
            }
            more.extend(["--compare", compared.to_str().unwrap()]);
            error.push((scene, method, rmse(&draw(&path, &image, &more))));
        }
    }
    assert!(error.len() == 6 && error.iter().all(|&(.., error)| error < 1e-6), "{error:?}");
}
