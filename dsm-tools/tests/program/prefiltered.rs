//! Prefiltered maps: `bake --kind prefiltered`, and what the other commands do with them.

use serde_json::{Value, json};

use crate::layers::{lights, points, scene};
use crate::maps::Folder;
use crate::run;

const SMALL: [&str; 4] = ["--kind", "prefiltered", "--resolution", "128"];

#[test]
fn prefiltered_maps_are_baked_shown_and_looked_up() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "1"), points(&folder));
    let map = folder.path("map.dsm");
    let [kind, name, size, pixels] = SMALL;
    let told = run!("bake", scene, "-o", map, kind, name, size, pixels).stdout();
    assert!(told.contains("16384 samples met"), "{told}");
    run!("verify", map).stdout();
    let told: Value = serde_json::from_str(&run!("inspect", map, "--json").stdout()).unwrap();
    assert_eq!(told["kind"], json!("prefiltered"));
    assert_eq!(told["levels"].as_array().unwrap().len(), 8);
    assert!(told["contents"]["fragments"].as_u64().unwrap() > 10_000);
    let pixel = run!("inspect", map, "--json", "--pixel", "64,64").stdout();
    let pixel: Value = serde_json::from_str(&pixel).unwrap();
    let fragments = pixel["fragments"].as_array().unwrap();
    assert_eq!(fragments.len(), 2, "{fragments:?}");
    // The pane hides the light from half a unit over the floor's middle, not from its side;
    // what lies under the floor is dark, and what is as high as the light lit.
    let found = lights(&run!("lookup", map, "--points", points).warned("(NaN)"));
    assert!(found[0] < 0.02 && found[1] > 0.98 && found[2] < 0.02, "{found:?}");
    assert_eq!(found[3..], [1.0, 1.0], "{found:?}");
    // Neither threads nor tiles change an answer.
    let fine = folder.path("fine.dsm");
    run!("bake", scene, "-o", fine, kind, name, size, pixels, "--tile", "16", "--block", "none")
        .stdout();
    let one = run!("lookup", fine, "--points", points, "--threads", "1").warned("(NaN)");
    assert_eq!(lights(&one), found);
}

#[test]
fn soft_shadows_are_those_of_traced_rays() {
    let folder = Folder::new();
    let scene = scene(&folder, "0.5");
    let (map, planes) = (folder.path("map.dsm"), folder.path("planes.dsm"));
    let [kind, name, size, _] = SMALL;
    run!("bake", scene, "-o", map, kind, name, size, "256").stdout();
    run!("bake", scene, "-o", planes, "--kind", "fragments", "--resolution", "256").stdout();
    let line = |step: u32| format!("{},0.01,{}\n", f64::from(step) * 0.02 - 1.0, 0.1);
    let rows: String = (0..100).map(line).collect();
    let points = folder.write("line.csv", format!("x,y,z\n{rows}"));
    let traced = lights(&run!("lookup", planes, "--points", points, "--rays", "1024").stdout());
    assert!(traced.iter().any(|left| (0.6..0.9).contains(left)), "{traced:?}");
    let off = |found: &[f64]| {
        let squares = found.iter().zip(&traced).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / traced.len() as f64).sqrt()
    };
    let found = lights(&run!("lookup", map, "--points", points).stdout());
    assert!(off(&found) < 0.03, "{}", off(&found));
    // A point light has hard shadows, which are far off.
    let sharp = lights(&run!("lookup", map, "--points", points, "--light-size", "0x0").stdout());
    assert!(off(&sharp) > 2.0 * off(&found) && sharp.iter().all(|left| [0.5, 1.0].contains(left)));
    for mode in ["add", "multiply", "max"] {
        let found = run!("lookup", map, "--points", points, "--accumulate", mode).stdout();
        assert!(off(&lights(&found)) < 0.03, "{mode}");
    }
    let near = run!("lookup", map, "--points", points, "--method", "hybrid", "--near", planes);
    assert!(off(&lights(&near.stdout())) < 0.03);
    // As published: fewer, coarser levels.
    let paper = folder.path("paper.dsm");
    let told = ["--preset", "paper", "--max-level", "5"];
    run!("bake", scene, "-o", paper, kind, name, size, "256", told[0], told[1], told[2], told[3])
        .stdout();
    let shown: Value = serde_json::from_str(&run!("inspect", paper, "--json").stdout()).unwrap();
    assert_eq!(shown["levels"].as_array().unwrap().len(), 6);
    assert_eq!(shown["levels"][5]["width"], json!(8));
}

#[test]
fn pictures_have_prefiltered_shadows() {
    let folder = Folder::new();
    let scene = scene(&folder, "1");
    let truth = folder.path("truth.exr");
    let small = ["--resolution", "48x36", "--samples", "4", "--factor", "--quiet"];
    let draw = |method: &str, output: &std::path::Path, more: &[&str]| {
        let scene = scene.to_str().unwrap();
        let start = ["render", scene, "-o", output.to_str().unwrap(), "--method", method];
        run::run(start.iter().chain(&small).chain(more)).stdout()
    };
    draw("reference", &truth, &["--rays", "256"]);
    for method in ["prefilter", "hybrid"] {
        let output = folder.path("picture.exr");
        let told = draw(method, &output, &["--json", "--compare", truth.to_str().unwrap()]);
        let told: Value = serde_json::from_str(&told).unwrap();
        assert_eq!(told["method"], json!(method));
        let rmse = told["compare"]["rmse"].as_f64().unwrap();
        assert!(rmse < 0.06, "{method}: {rmse}");
    }
}

#[test]
fn maps_are_made_of_maps_and_images() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "1"), points(&folder));
    let [kind, name, size, pixels] = SMALL;
    for source in ["fragments", "layers", "deep"] {
        let (map, made) = (folder.path("source.dsm"), folder.path("made.dsm"));
        run!("bake", scene, "-o", map, "--kind", source, size, pixels).stdout();
        run!("bake", map, "-o", made, kind, name).stdout();
        run!("verify", made).stdout();
        let found = lights(&run!("lookup", made, "--points", points).warned("(NaN)"));
        assert!(found[0] < 0.05 && found[1] > 0.95 && found[2] < 0.02, "{source}: {found:?}");
    }
    let (deep, image) = (folder.path("source.dsm"), folder.path("deep.exr"));
    run!("convert", deep, image).stdout();
    let made = folder.path("of_image.dsm");
    run!("bake", image, "-o", made, kind, name).stdout();
    let found = run!("lookup", made, "--points", points, "--light-size", "1x0.5").warned("(NaN)");
    let found = lights(&found);
    assert!(found[0] < 0.05 && found[1] > 0.95, "{found:?}");
    let runs = folder.path("runs.dsm");
    run!("bake", scene, "-o", runs, "--kind", "mtsm", "--resolution", "16").stdout();
    let refused = run!("bake", runs, "-o", made, kind, name);
    assert!(refused.refusal().contains("does not tell what a pixel's middle shows"));
    let misty = folder.path("misty.dsm");
    run!("bake", "builtin:smoke", "-o", misty, "--kind", "fragments", "--resolution", "16")
        .stdout();
    let refused = run!("bake", misty, "-o", made, kind, name);
    assert!(refused.refusal().contains("it has media"));
    run!("bake", deep, "-o", made, "--kind", "layers").is_wrong_usage("prefiltered alone");
    run!("bake", deep, "-o", made, kind, name, size, pixels).is_wrong_usage("--resolution");
}

#[test]
fn what_is_not_for_prefiltered_maps_is_refused() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "1"), points(&folder));
    let map = folder.path("map.dsm");
    let [kind, name, size, _] = SMALL;
    run!("bake", scene, "-o", map, kind, name, size, "16").stdout();
    for (switch, value) in [
        ("--coverage", "2"),
        ("--resets", "2"),
        ("--tolerance", "0.1"),
        ("--samples", "4"),
        ("--codec", "quantized"),
        ("--crop", "0,0,16,16"),
    ] {
        let other = folder.path("other.dsm");
        let refused = run!("bake", scene, "-o", other, kind, name, size, "16", switch, value);
        refused.is_wrong_usage("kind");
    }
    run!("bake", scene, "-o", map, "--epsilon", "2").is_wrong_usage("kind prefiltered");
    run!("bake", scene, "-o", map, kind, name, "--epsilon", "-2").is_wrong_usage("--epsilon");
    run!("bake", scene, "-o", map, kind, name, "--levels", "y:0").is_wrong_usage("--levels");
    let refused = run!("bake", scene, "-o", map, kind, name, size, "16", "--max-level", "9");
    assert!(refused.refusal().contains("wider than the map"));
    for method in ["trace", "filter", "pcf"] {
        let refused = run!("lookup", map, "--points", points, "--method", method);
        assert!(refused.refusal().contains("--method prefilter reads it"), "{method}");
    }
    run!("lookup", map, "--points", points, "--method", "prefilter", "--rays", "4")
        .is_wrong_usage("--rays");
    run!("lookup", map, "--points", points, "--method", "hybrid").is_wrong_usage("--near");
    let hybrid = run!("lookup", map, "--points", points, "--method", "hybrid", "--near", map);
    assert!(hybrid.refusal().contains("kind fragments"));
    let layers = folder.path("layers.dsm");
    run!("bake", scene, "-o", layers, "--kind", "layers", size, "16").stdout();
    let refused = run!("lookup", layers, "--points", points, "--method", "prefilter");
    assert!(refused.refusal().contains("no levels of wider filters"));
    run!("lookup", layers, "--points", points, "--method", "trace", "--accumulate", "max")
        .is_wrong_usage("--accumulate");
}
