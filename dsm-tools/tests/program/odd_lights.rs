//! Lights that see nothing, or from one point, and sizes that nothing can hold: maps of kinds
//! `attenuation` and `views`.

use std::path::{Path, PathBuf};

use crate::layers::{lights, points, scene};
use crate::maps::Folder;
use crate::run;

const KINDS: [&str; 2] = ["attenuation", "views"];

fn bake(scene: &Path, map: &Path, kind: &str, more: &[&str]) -> run::Answer {
    let start = ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap(), "--kind", kind];
    run::run(start.iter().chain(more))
}

/// The scene with other lines for its light.
fn lit(folder: &Folder, changes: &[(&str, &str)]) -> PathBuf {
    let mut text = std::fs::read_to_string(scene(folder, "1")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{text}");
        text = text.replacen(from, to, 1);
    }
    folder.write("odd.toml", text)
}

/// What stands where the light does.
const EYE: &str = "eye = [0, 5, 0]\ntarget = [0, 0, 0]";

#[test]
fn lights_that_see_nothing_leave_all_lit() {
    let folder = Folder::new();
    let (points, map) = (points(&folder), folder.path("map.dsm"));
    let away = [
        // Looks up and away; lies below the floor and looks down: all is behind it.
        "eye = [0, 5, 0]\ntarget = [0, 9, 0]",
        "eye = [0, -5, 0]\ntarget = [0, -9, 0]",
    ];
    for (kind, eye) in KINDS.into_iter().flat_map(|kind| away.map(|eye| (kind, eye))) {
        let scene = lit(&folder, &[(EYE, eye)]);
        let is = if kind == "views" { "lit everywhere" } else { "dark everywhere" };
        bake(&scene, &map, kind, &["--resolution", "16"]).warned(is);
        run!("verify", map).warned(is);
        let found = lights(&run!("lookup", map, "--points", points).warned(is));
        // Behind the light's plane, and beside the map.
        assert_eq!(found, [1.0; 5], "{kind} {eye}");
    }
    // It sees nothing, and looks past the points: what it does not see is lit where rays are
    // traced, and dark where places are looked up that nothing was seen at.
    for (kind, expected) in [("attenuation", 0.0), ("views", 1.0)] {
        let scene = lit(
            &folder,
            &[
                ("translate = [0, 2, 0]", "translate = [900, 2, 0]"),
                ("scale = 5.0", "translate = [-900, 0, 0]"),
            ],
        );
        bake(&scene, &map, kind, &["--resolution", "16"]).warned("no sample met anything");
        let air = folder.write("air.csv", "x,y,z\n0,0.5,0\n");
        let found = lights(&run!("lookup", map, "--points", air).warned("holds nothing"));
        assert_eq!(found, [expected], "{kind}");
    }
}

#[test]
fn one_point_of_a_light_casts_hard_shadows() {
    let folder = Folder::new();
    let (scene, map) = (scene(&folder, "1"), folder.path("map.dsm"));
    let line = |step: u32| format!("{},0,0.1\n", f64::from(step) * 0.025 - 1.0);
    let points = folder.write("l.csv", format!("x,y,z\n{}", (0..80).map(line).collect::<String>()));
    for (kind, switch) in [("attenuation", "--light-samples"), ("views", "--views")] {
        bake(&scene, &map, kind, &["--resolution", "128", switch, "1"]).stdout();
        let rays: &[&str] =
            if kind == "views" { &["--rays", "1", "--light-size", "0"] } else { &[] };
        let start = ["lookup", map.to_str().unwrap(), "--points", points.to_str().unwrap()];
        let found = lights(&run::run(start.iter().chain(rays)).stdout());
        assert!(found.iter().all(|&left| left == 0.0 || left == 1.0), "{kind} {found:?}");
        let dark = found.iter().filter(|&&left| left == 0.0).count();
        // The pane's shadow is 1.67 wide.
        assert!((60..75).contains(&dark), "{kind} {dark}");
    }
    // A light that is a point has one, whatever is asked for.
    let small = lit(&folder, &[("size = [1.0, 0.5]", "size = [0.0, 0.0]")]);
    for (kind, switch) in [("attenuation", "--light-samples"), ("views", "--views")] {
        let told = bake(&small, &map, kind, &["--resolution", "32", switch, "9"]).stdout();
        assert!(told.contains("1024 samples met"), "{told}");
    }
}

#[test]
fn what_is_no_number_and_no_size_is_refused() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let good = scene(&folder, "1");
    for kind in KINDS {
        for (from, to) in [
            ("eye = [0, 5, 0]", "eye = [nan, 5, 0]"),
            ("size = [1.0, 0.5]", "size = [nan, 0.5]"),
            ("size = [1.0, 0.5]", "size = [-1.0, 0.5]"),
            ("size = [1.0, 0.5]", "size = [inf, 0.5]"),
        ] {
            let odd = lit(&folder, &[(from, to)]);
            let refused = bake(&odd, &map, kind, &["--resolution", "16"]);
            assert!(refused.refusal().contains("light"), "{kind} {to}: {refused:?}");
            assert!(!map.exists(), "{kind} {to}");
        }
        // As small as can be.
        bake(&good, &map, kind, &["--resolution", "1"]).stdout();
        let points = points(&folder);
        let found = lights(&run!("lookup", map, "--points", points).warned("(NaN)"));
        assert!(found.iter().all(|left| (0.0..=1.0).contains(left)), "{kind} {found:?}");
        std::fs::remove_file(&map).unwrap();
        // A light larger than what it lights, and one that is hardly any.
        for size in ["size = [1e6, 1e6]", "size = [1e-12, 1e-12]"] {
            let odd = lit(&folder, &[("size = [1.0, 0.5]", size)]);
            assert_eq!(bake(&odd, &map, kind, &["--resolution", "16"]).code, 0, "{kind} {size}");
            let found = run!("lookup", map, "--points", points);
            assert_eq!(found.code, 0, "{found:?}");
            let found = lights(&found.stdout);
            assert!(found.iter().all(|left| (0.0..=1.0).contains(left)), "{kind} {found:?}");
            std::fs::remove_file(&map).unwrap();
        }
    }
    // Before anything is rendered: no memory holds so much.
    let huge = bake(&good, &map, "views", &["--views", "1024", "--resolution", "16384"]);
    assert!(huge.refusal().contains("pixels of all views"), "{huge:?}");
    let huge = bake(&good, &map, "attenuation", &["--resolution", "65536"]);
    assert!(huge.refusal().contains("texels of an attenuation map"), "{huge:?}");
    assert!(!map.exists());
}
