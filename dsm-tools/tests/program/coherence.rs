//! Coherent sampling: `--method coherence` of `lookup` and `render`.

use std::path::Path;

use serde_json::json;

use crate::layers::{lights, points, scene};
use crate::maps::Folder;
use crate::run;

/// Points on the floor, close to each other, from shadow to light.
fn line(folder: &Folder) -> std::path::PathBuf {
    let row = |step: u32| format!("{},0,{}\n", f64::from(step) * 0.001 - 1.0, 0.1);
    let rows: String = (0..2000).map(row).collect();
    folder.write("line.csv", format!("x,y,z\n{rows}"))
}

#[test]
fn maps_are_traced_where_visibility_changes() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "1"), line(&folder));
    for kind in ["mtsm", "layers", "views"] {
        let map = folder.path(&format!("{kind}.dsm"));
        run!("bake", scene, "-o", map, "--kind", kind, "--resolution", "128", "--quiet").stdout();
        let traced = run!("lookup", map, "--points", points, "--method", "trace", "--rays", "1024");
        let traced = lights(&traced.stdout());
        assert!(traced.iter().any(|left| (0.3..0.7).contains(left)), "{kind} {traced:?}");
        let found = run!("lookup", map, "--points", points, "--method", "coherence", "--stats");
        let stats: serde_json::Value =
            serde_json::from_str(found.stderr.lines().last().unwrap()).unwrap();
        let rays = stats["rays"].as_u64().unwrap();
        assert!(rays < 2000 * 256 / 2, "{kind}: {rays}");
        let found = lights(&found.stdout);
        let squares = found.iter().zip(&traced).map(|(a, b)| (a - b).powi(2));
        let off = (squares.sum::<f64>() / traced.len() as f64).sqrt();
        assert!(off < 0.012, "{kind}: {off}");
        // Threads change no answer, nor does the order of points.
        let one = ["--method", "coherence", "--threads", "1"];
        let [method, name, threads, count] = one;
        let alone = run!("lookup", map, "--points", points, method, name, threads, count);
        assert_eq!(lights(&alone.stdout()), found);
    }
}

#[test]
fn what_cannot_be_traced_so_is_refused() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "1"), points(&folder));
    for (kind, says) in [
        ("deep", "filter"),
        ("fragments", "traced"),
        ("prefiltered", "prefilter"),
        ("attenuation", "attenuation"),
    ] {
        let map = folder.path(&format!("{kind}.dsm"));
        run!("bake", scene, "-o", map, "--kind", kind, "--resolution", "32", "--quiet").stdout();
        let refused = run!("lookup", map, "--points", points, "--method", "coherence");
        assert!(refused.refusal().contains(says), "{kind}: {refused:?}");
    }
    let map = folder.path("deep.dsm");
    for (switch, value, says) in [
        ("--rays", "200", "a square number of rays"),
        ("--bias", "-1", "a ray offset is not negative"),
        ("--filter", "tent", "--method filter"),
        ("--rule", "ratio", "--rule"),
        ("--far-table", "on", "--far-table"),
    ] {
        let refused =
            run!("lookup", map, "--points", points, "--method", "coherence", switch, value);
        refused.is_wrong_usage(says);
    }
    let picture = folder.path("p.exr");
    run!("render", scene, "-o", picture, "--method", "coherence", "--rays", "99")
        .is_wrong_usage("a square number of rays");
}

#[test]
fn pictures_are_those_of_all_rays() {
    let folder = Folder::new();
    let scene = scene(&folder, "1");
    let (truth, output) = (folder.path("truth.exr"), folder.path("picture.exr"));
    let small = ["--resolution", "96x72", "--samples", "4", "--factor", "--json"];
    let draw = |method: &str, output: &Path, more: &[&str]| {
        let scene = scene.to_str().unwrap();
        let start = ["render", scene, "-o", output.to_str().unwrap(), "--method", method];
        run::run(start.iter().chain(&small).chain(more)).json()
    };
    draw("reference", &truth, &["--rays", "1024"]);
    let map = folder.path("views.dsm");
    run!("bake", scene, "-o", map, "--kind", "views", "--resolution", "256", "--quiet").stdout();
    let map = map.to_str().unwrap();
    for (more, most) in [(&[][..], 0.008), (&["--map", map], 0.03)] {
        let compare = ["--compare", truth.to_str().unwrap()];
        let told = draw("coherence", &output, &[more, &compare].concat());
        assert_eq!(told["method"], json!("coherence"));
        let rmse = told["compare"]["rmse"].as_f64().unwrap();
        assert!(rmse < most, "{more:?}: {rmse}");
        let note = told["notes"][0].as_str().unwrap();
        assert!(note.contains("of 256 rays a point traced"), "{note}");
        let rays: f64 = note.split(' ').next().unwrap().parse().unwrap();
        assert!(rays < 200.0, "{note}");
    }
}
