//! Traced shadows of thin surfaces, from either side and far behind them.

use serde_json::Value;

use crate::maps::Folder;
use crate::run;

/// A square sheet at height 0 under a light at (0, 4, 0) or beside it.
fn sheet(folder: &Folder, light: &str, opacity: f32) -> std::path::PathBuf {
    folder.write("sheet.obj", "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 2 3 4\n");
    let scene = format!(
        "[camera]\neye = [0, -3, 0.1]\ntarget = [0, 1, 0]\nup = [0, 0, 1]\nfov = 20.0\n\
         resolution = [16, 16]\n\
         [light]\neye = {light}\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov = 40.0\n\
         shape = \"rectangle\"\nsize = [0.5, 0.5]\n\
         [[object]]\nmesh = \"sheet.obj\"\nopacity = {opacity}\n"
    );
    folder.write("scene.toml", scene)
}

fn lookups(map: &std::path::Path, points: &std::path::Path, far: &str) -> Vec<f32> {
    let told = run!("lookup", map, "--points", points, "--far-table", far).stdout();
    told.lines().skip(1).map(|line| line.parse().unwrap()).collect()
}

#[test]
fn the_far_side_of_a_leaf_is_dark_in_every_kind_of_map() {
    let folder = Folder::new();
    let scene = sheet(&folder, "[0, 6, 0]", 1.0);
    let reference = folder.path("reference.exr");
    run!("render", scene, "-o", reference, "--method", "reference", "--factor").stdout();
    for kind in ["fragments", "layers", "mtsm"] {
        let (map, image) = (folder.path("map.dsm"), folder.path("image.exr"));
        run!("bake", scene, "-o", map, "--kind", kind, "--resolution", "64").stdout();
        let told = run!(
            "render",
            scene,
            "--map",
            map,
            "-o",
            image,
            "--method",
            "trace",
            "--factor",
            "--compare",
            reference,
            "--json"
        );
        let told: Value = serde_json::from_str(&told.stdout()).unwrap();
        assert_eq!(told["compare"]["max"], 0.0, "{kind}");
    }
}

#[test]
fn one_pane_takes_its_opacity_at_any_distance_and_resolution() {
    for (light, opacity) in [("[0, 4, 0]", 0.9), ("[1.3, 4, 0.7]", 1.0)] {
        let folder = Folder::new();
        let scene = sheet(&folder, light, opacity);
        // A hundredth to two below it, where its shadow is.
        let points = folder.write("below.csv", "x,y,z\n0.1,-1e-2,0.1\n0,-1,0\n-0.1,-2,-0.1\n");
        for resolution in ["64", "300", "512"] {
            let map = folder.path("map.dsm");
            run!("bake", scene, "-o", map, "--kind", "fragments", "--resolution", resolution)
                .stdout();
            for far in ["auto", "on", "off"] {
                for light in lookups(&map, &points, far) {
                    assert!((light - (1.0 - opacity)).abs() < 1e-5, "{resolution} {far}: {light}");
                }
            }
        }
    }
}

#[test]
fn what_a_bound_of_layers_folds_is_told_and_dark_behind() {
    let folder = Folder::new();
    let mut panes = String::new();
    for pane in 0..24 {
        let y = 0.5 + 0.02 * f64::from(pane);
        panes += &format!("v -1 {y} -1\nv 1 {y} -1\nv 1 {y} 1\nv -1 {y} 1\n");
        panes +=
            &format!("f {} {} {} {}\n", 4 * pane + 1, 4 * pane + 2, 4 * pane + 3, 4 * pane + 4);
    }
    let scene = sheet(&folder, "[0, 4, 0]", 0.05);
    folder.write("sheet.obj", panes);
    let points = folder.write("below.csv", "x,y,z\n0,-0.5,0\n");
    let map = folder.path("map.dsm");
    let told = run!(
        "bake",
        scene,
        "-o",
        map,
        "--kind",
        "fragments",
        "--resolution",
        "64",
        "--layers",
        "6",
        "--json"
    );
    let told: Value = serde_json::from_str(&told.stdout()).unwrap();
    // Five panes stay before one that stands for the other nineteen.
    let gained = told["gained"][0].as_f64().unwrap();
    let expected = 0.95_f64.powi(5) - 0.95_f64.powi(23);
    assert!((gained - expected).abs() < 1e-5, "{gained}");
    let shown: Value = serde_json::from_str(&run!("inspect", map, "--json").stdout()).unwrap();
    assert_eq!(shown["folded"]["pixels"], told["cut_pixels"]);
    assert!((shown["folded"]["max"].as_f64().unwrap() - expected).abs() < 1e-5);
    let below = lookups(&map, &points, "off")[0];
    assert!((f64::from(below) - 0.95_f64.powi(24)).abs() < 1e-4, "{below}");
}
