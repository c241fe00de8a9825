//! `render`: scenes under their light.

use std::fs;

use serde_json::Value;

use crate::maps::Folder;
use crate::run;

/// A pane of opacity ¾ at height 1 over a floor, from above; the light hangs
/// over the pane's edge x = 0.
const SCENE: &str = r#"
[camera]
eye = [0, 20, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov = 10.0
resolution = [24, 16]

[light]
eye = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov = 60.0

[[object]]
mesh = "pane.obj"
opacity = 0.75

[[object]]
mesh = "floor.obj"
"#;

fn scene(folder: &Folder) -> std::path::PathBuf {
    let square = |x0: f32, x1: f32, y: f32, z: f32| {
        format!("v {x0} {y} -{z}\nv {x1} {y} -{z}\nv {x1} {y} {z}\nv {x0} {y} {z}\nf 1 2 3 4\n")
    };
    folder.write("pane.obj", square(-9.0, 0.0, 1.0, 9.0));
    folder.write("floor.obj", square(-9.0, 9.0, 0.0, 9.0));
    folder.write("scene.toml", SCENE)
}

fn grey_png(path: &std::path::Path) -> ([u32; 2], Vec<u8>) {
    let mut reader =
        png::Decoder::new(std::io::Cursor::new(fs::read(path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(frame.color_type, png::ColorType::Grayscale);
    ([frame.width, frame.height], pixels)
}

#[test]
fn all_methods_draw_the_same_shadow() {
    let folder = Folder::new();
    let (scene, reference) = (scene(&folder), folder.path("reference.exr"));
    let told = run!("render", scene, "-o", reference, "--method", "reference", "--factor").stdout();
    assert!(told.contains("24 × 16 pixels, reference, 16 camera rays a pixel"), "{told}");
    assert!(!told.contains("bias"), "{told}");
    let compare = |method: &str, more: &[&str]| -> Value {
        let image = folder.path(&format!("{method}.exr"));
        let base = ["render", scene.to_str().unwrap(), "-o", image.to_str().unwrap()];
        let same = ["--factor", "--compare", reference.to_str().unwrap(), "--json"];
        let method = ["--method", method];
        let arguments = base.iter().chain(&same).chain(&method).chain(more);
        run::run(arguments).json()
    };
    let itself = compare("reference", &[]);
    assert_eq!((itself["compare"]["rmse"].as_f64(), &itself["bias"]), (Some(0.0), &Value::Null));
    // Off at the shadow's edge alone, which is a pixel wide.
    for (method, more, most) in [("filter", &[][..], 0.03), ("pcf", &["--rays", "64"], 0.04)] {
        let told = compare(method, more);
        let rmse = told["compare"]["rmse"].as_f64().unwrap();
        assert!(rmse > 0.0 && rmse < most, "{told}");
        assert!(told["compare"]["max"].as_f64().unwrap() < 0.6, "{told}");
        assert_eq!((&told["method"], &told["width"]), (&method.into(), &24.into()));
        assert_eq!(told["bias"]["rule"], "auto");
        let [min, max] = ["min", "max"].map(|key| told["bias"][key].as_f64().unwrap());
        assert!(min > 0.0 && max < 0.1, "{told}");
    }
    // A bias that is too large lets light through.
    let told = compare("filter", &["--bias", "2"]);
    assert!(told["compare"]["mean"].as_f64().unwrap() > 0.05, "{told}");
    assert_eq!(told["bias"]["rule"], "fixed");
}

#[test]
fn a_picture_is_lit_and_has_its_shadow() {
    let folder = Folder::new();
    let (scene, map, image) = (scene(&folder), folder.path("map.dsm"), folder.path("image.png"));
    run!("bake", scene, "-o", map, "--resolution", "64", "--mip", "--quiet").stdout();
    let wide = ["--filter", "box", "--width", "4", "--level", "auto"];
    let base = ["render", scene.to_str().unwrap(), "--map", map.to_str().unwrap()];
    let output = ["-o", image.to_str().unwrap(), "--quiet"];
    let render = |more: &[&str]| {
        let told = run::run(base.iter().chain(&output).chain(more)).stdout();
        assert_eq!(told, "");
        grey_png(&image)
    };
    let (size, pixels) = render(&[]);
    assert_eq!(size, [24, 16]);
    // Right of the middle the light falls on the floor: 0.8 of it comes back,
    // 231 in sRGB. Left three quarters of it fall on the pane, and a quarter of
    // the rest comes back.
    let [left, right] = [4, 13].map(|x| pixels[8 * 24 + x]);
    assert!((225..=232).contains(&right), "{right}");
    assert!((200..=216).contains(&left), "{left}");
    let (_, factor) = render(&["--factor", "--resolution", "12x8"]);
    assert_eq!((factor.len(), factor[4 * 12 + 11]), (96, 255));
    let (_, blurred) = render(&wide);
    assert!((225..=232).contains(&blurred[8 * 24 + 20]), "{blurred:?}");
}

#[test]
fn threads_change_no_byte_and_seeds_do() {
    let folder = Folder::new();
    let (scene, image) = (scene(&folder), folder.path("image.exr"));
    let render = |more: &[&str]| {
        let base = ["render", scene.to_str().unwrap(), "-o", image.to_str().unwrap(), "--quiet"];
        run::run(base.iter().chain(more)).stdout();
        fs::read(&image).unwrap()
    };
    for method in ["filter", "pcf", "reference"] {
        let one = render(&["--method", method, "--threads", "1"]);
        assert!(one == render(&["--method", method, "--threads", "3"]), "{method}");
        assert!(one != render(&["--method", method, "--seed", "9"]), "{method}");
    }
}

#[test]
fn what_cannot_be_rendered_leaves_no_picture() {
    let folder = Folder::new();
    let (scene, image) = (scene(&folder), folder.write("image.png", "old"));
    let other = folder.path("other.exr");
    run!("render", scene, "-o", other, "--resolution", "8", "--samples", "1", "--quiet").stdout();
    let deep = folder.write(
        "deep.exr",
        fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/sample/tuft.exr")).unwrap(),
    );
    let junk = folder.write("junk.exr", "v/1\u{1}");
    let map = folder.write("map.dsm", "no map");
    let blind = folder
        .map("blind.dsm", &crate::maps::map(dsm_core::MapInfo::default(), |blocked| 1.0 - blocked));
    for (more, reason) in [
        (["--compare", other.to_str().unwrap()], "8 × 8 pixels, but the picture has 24 × 16"),
        (["--compare", deep.to_str().unwrap()], "deep"),
        (["--compare", junk.to_str().unwrap()], "junk.exr"),
        (["--compare", "missing.exr"], "missing.exr"),
        (["--map", map.to_str().unwrap()], "map.dsm"),
        (["--map", blind.to_str().unwrap()], "blind.dsm: the map has no camera"),
        (["--map", "missing.dsm"], "missing.dsm"),
    ] {
        let answer = run!("render", scene, "-o", image, "--samples", "1", more[0], more[1]);
        assert!(answer.refusal().contains(reason), "{answer:?}");
        assert_eq!(fs::read(&image).unwrap(), b"old");
    }
    run!("render", "builtin:moss", "-o", image).refusal();
    let nowhere = folder.path("no/where.png");
    run!("render", scene, "-o", nowhere, "--samples", "1").refusal();
    for (more, reason) in [
        (["--method", "radiosity"], "radiosity"),
        (["--samples", "0"], "--samples"),
        (["--rays", "0"], "--rays"),
        (["--resolution", "0x4"], "65,536"),
        (["--bias", "inf"], "finite"),
        (["--width", "1"], "tent"),
        (["--light-size", "1x-1"], "--light-size"),
        (["--compare", "a.png"], ".exr"),
        (["--map", "a.exr"], ".dsm"),
    ] {
        run!("render", scene, "-o", image, more[0], more[1]).is_wrong_usage(reason);
    }
    run!("render", scene, "-o", "a.tif").is_wrong_usage(".png or .exr");
    run!("render", scene).is_wrong_usage("--output");
    run!("render", scene, "-o", image, "--method", "pcf", "--rays", "8").is_wrong_usage("square");
    run!("render", scene, "-o", image, "--method", "reference", "--map", "a.dsm")
        .is_wrong_usage("--map has no use");
}

#[test]
fn every_switch_shows_in_the_picture() {
    let folder = Folder::new();
    let point = scene(&folder);
    let area = SCENE.replace("fov = 60.0", "fov = 60.0\nshape = \"rectangle\"\nsize = [1.0, 1.0]");
    let area = folder.write("area.toml", area);
    let coloured = SCENE.replace("opacity = 0.75", "opacity = [0.75, 0.5, 0.25]");
    let coloured = folder.write("coloured.toml", coloured);
    // A floor whose depth changes within a pixel.
    let slanted = fs::read_to_string(&area).unwrap() + "transform = { rotate = [0, 0, 30] }\n";
    let slanted = folder.write("slanted.toml", slanted);
    let bake = |scene: &std::path::Path, kind: &str| {
        let map = folder.path(&format!("{kind}.dsm"));
        run!("bake", scene, "-o", map, "--kind", kind, "--resolution", "64", "--quiet").stdout();
        map.to_str().unwrap().to_owned()
    };
    let (fragments, layers) = (bake(&area, "fragments"), bake(&slanted, "mtsm"));
    let image = folder.path("image.exr");
    let draw = |scene: &std::path::Path, arguments: &[&str]| {
        let base = ["render", scene.to_str().unwrap(), "-o", image.to_str().unwrap(), "--quiet"];
        let few = ["--factor", "--samples", "2", "--method"];
        run::run(base.iter().chain(&few).chain(arguments)).stdout();
        fs::read(&image).unwrap()
    };
    let traced = ["trace", "--map", &fragments];
    let filtered = ["pcf", "--map", &layers];
    for (scene, method, switch) in [
        (&area, &["reference"][..], &["--light-size", "2"][..]),
        (&area, &["reference"], &["--rays", "4"]),
        (&point, &["pcf"], &["--width", "9"]),
        (&point, &["filter", "--filter", "box"], &["--width", "9"]),
        // Bakes the levels, too.
        (&point, &["filter"], &["--level", "3"]),
        (&area, &traced, &["--bias", "3"]),
        (&area, &traced, &["--light-size", "2"]),
        (&area, &traced, &["--rays", "4"]),
        (&slanted, &filtered, &["--rays", "4"]),
        (&slanted, &filtered, &["--bias", "0"]),
    ] {
        let with = draw(scene, &[method, switch].concat());
        assert!(draw(scene, method) != with, "{method:?} {switch:?}");
    }
    // Where nothing has a colour, no picture has one.
    assert!(draw(&coloured, &["reference"]) != draw(&point, &["reference"]));
    let channels = |scene: &std::path::Path| {
        draw(scene, &["reference"]);
        exr::meta::MetaData::read_from_file(&image, false).unwrap().headers[0].channels.list.len()
    };
    assert_eq!([channels(&coloured), channels(&point)], [3, 1]);
}
