//! Attenuation maps: `bake --kind attenuation`, and what the other commands do with them.

use serde_json::{Value, json};

use crate::layers::{lights, points, scene};
use crate::maps::Folder;
use crate::run;

const SMALL: [&str; 6] = ["--kind", "attenuation", "--resolution", "128", "--light-samples", "16"];

#[test]
fn attenuation_maps_are_baked_shown_and_looked_up() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "1"), points(&folder));
    let map = folder.path("map.dsm");
    let [kind, name, size, pixels, many, count] = SMALL;
    let told = run!("bake", scene, "-o", map, kind, name, size, pixels, many, count).stdout();
    assert!(told.contains("262144 samples met"), "{told}");
    run!("verify", map).stdout();
    let told: Value = serde_json::from_str(&run!("inspect", map, "--json").stdout()).unwrap();
    assert_eq!(told["kind"], json!("attenuation"));
    assert_eq!(told["light_samples"], json!(16));
    assert!(told["contents"]["layers"].as_u64().unwrap() > 10_000);
    let pixel = run!("inspect", map, "--json", "--pixel", "64,64").stdout();
    let pixel: Value = serde_json::from_str(&pixel).unwrap();
    assert_eq!(pixel["layers"][0][1], json!(1.0), "{pixel}");
    // Lights of another size have other shadows.
    let refused = run!("lookup", map, "--points", points, "--light-size", "3x3");
    assert!(refused.refusal().contains("bake it again"), "{refused:?}");
    for method in ["trace", "filter", "pcf", "prefilter"] {
        let refused = run!("lookup", map, "--points", points, "--method", method);
        assert!(refused.refusal().contains("--method attenuation reads it"), "{refused:?}");
    }
    // Neither threads nor tiles change an answer.
    let found = lights(&run!("lookup", map, "--points", points).warned("(NaN)"));
    let fine = folder.path("fine.dsm");
    run!(
        "bake",
        scene,
        "-o",
        fine,
        kind,
        name,
        size,
        pixels,
        many,
        count,
        "--tile",
        "16",
        "--block",
        "none",
        "--threads",
        "1"
    )
    .stdout();
    let one = run!("lookup", fine, "--points", points, "--threads", "1").warned("(NaN)");
    assert_eq!(lights(&one), found);
}

#[test]
fn soft_shadows_are_those_of_traced_rays() {
    let folder = Folder::new();
    let scene = scene(&folder, "0.5");
    let (map, planes) = (folder.path("map.dsm"), folder.path("planes.dsm"));
    let [kind, name, size, _, many, _] = SMALL;
    run!("bake", scene, "-o", map, kind, name, size, "256", many, "64").stdout();
    run!("bake", scene, "-o", planes, "--kind", "fragments", "--resolution", "256").stdout();
    // On the floor, which the map holds.
    let line = |step: u32| format!("{},0,{}\n", f64::from(step) * 0.02 - 1.0, 0.1);
    let rows: String = (0..100).map(line).collect();
    let points = folder.write("line.csv", format!("x,y,z\n{rows}"));
    let traced = lights(&run!("lookup", planes, "--points", points, "--rays", "1024").stdout());
    assert!(traced.iter().any(|left| (0.6..0.9).contains(left)), "{traced:?}");
    let off = |found: &[f64]| {
        let squares = found.iter().zip(&traced).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / traced.len() as f64).sqrt()
    };
    let nearest = lights(&run!("lookup", map, "--points", points).stdout());
    assert!(off(&nearest) < 0.05, "{} {nearest:?} {traced:?}", off(&nearest));
    let four = lights(&run!("lookup", map, "--points", points, "--filter", "tent").stdout());
    assert!(off(&four) < 0.05, "{}", off(&four));
}

#[test]
fn switches_of_others_are_refused() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "1"), points(&folder));
    let map = folder.path("map.dsm");
    let [kind, name, size, pixels, many, count] = SMALL;
    for (name, switch, value, says) in [
        ("layers", many, count, "--light-samples is for maps of kind attenuation"),
        (name, "--layers", "3", "--layers is for"),
        (name, "--coverage", "4", "--coverage is for"),
        (name, "--samples", "4", "one sample a pixel"),
        (name, "--crop", "0,0,64,64", "bake it whole"),
        (name, many, "0", many),
    ] {
        let refused = run!("bake", scene, "-o", map, kind, name, size, pixels, switch, value);
        refused.is_wrong_usage(says);
    }
    run!("bake", scene, "-o", map, kind, name, size, pixels, many, "1").stdout();
    for (switch, value) in [("--filter", "box"), ("--rays", "4"), ("--level", "1")] {
        let refused = run!("lookup", map, "--points", points, switch, value);
        assert!(refused.refusal().contains(switch), "{refused:?}");
        run!("lookup", map, "--points", points, "--method", "attenuation", switch, value)
            .is_wrong_usage(switch);
    }
    let negative = run!("lookup", map, "--points", points, "--bias", "-1");
    assert!(negative.refusal().contains("bias"), "{negative:?}");
    let layers = folder.path("layers.dsm");
    run!("bake", scene, "-o", layers, "--kind", "layers", size, "16").stdout();
    let refused = run!("lookup", layers, "--points", points, "--method", "attenuation");
    assert!(refused.refusal().contains("a map of kind attenuation"), "{refused:?}");
}

#[test]
fn pictures_have_attenuated_shadows() {
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
    let (output, truth) = (folder.path("picture.exr"), truth.to_str().unwrap());
    for filter in ["point", "tent"] {
        let more = ["--filter", filter, "--json", "--compare", truth];
        let told: Value = serde_json::from_str(&draw("attenuation", &output, &more)).unwrap();
        assert_eq!(told["method"], json!("attenuation"));
        let rmse = told["compare"]["rmse"].as_f64().unwrap();
        assert!(rmse < 0.06, "{filter}: {rmse}");
    }
}
