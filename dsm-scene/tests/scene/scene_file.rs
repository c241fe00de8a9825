//! Scene files: every key, every default, and what is refused.

use std::fs;
use std::path::PathBuf;

use dsm_core::detail::LightShape;
use dsm_core::{LightExtent, Projection, Rgb};
use dsm_scene::detail::Result;
use dsm_scene::{Scene, Shape, open_scene};
use glam::{DVec3, DVec4};
use tempfile::TempDir;

/// A folder with a small model of each kind that is easily written.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let obj = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 2 3 4\n";
    fs::write(folder.path().join("square.obj"), obj).unwrap();
    let mut hair = b"HAIR".to_vec();
    for word in [1_u32, 2, 2, 1] {
        hair.extend(word.to_le_bytes());
    }
    hair.extend(0.5_f32.to_le_bytes());
    hair.resize(128, 0);
    for value in [0.0_f32, 0.0, 0.0, 0.0, 1.0, 0.0] {
        hair.extend(value.to_le_bytes());
    }
    fs::write(folder.path().join("one.hair"), hair).unwrap();
    folder
}

fn open(folder: &TempDir, text: &str) -> Result<Scene> {
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    open_scene(&path)
}

const WHOLE: &str = r#"
[camera]
eye = [0, 2, 6]
target = [0, 1, 0]
up = [0, 1, 0]
fov = 35.0
resolution = [64, 36]

[light]
eye = [2, 5, 2]
target = [0, 1, 0]
up = [0, 1, 0]
projection = "perspective"
fov = 40.0
shape = "rectangle"
size = [1.0, 0.5]

[shutter]
open = 0.25
close = 0.75

[[object]]
curves = "one.hair"
opacity = 0.3
thickness = 0.002
transform = { translate = [0, 1, 0], rotate = [0, 0, 90], scale = 2 }
transform_end = { translate = [1, 0, 0] }

[[object]]
mesh = "square.obj"
opacity = [0.25, 0.5, 1]

[[object]]
builtin = "stained-glass"
opacity = 0.5
"#;

#[test]
fn every_key_is_read() {
    let scene = open(&folder(), WHOLE).unwrap();
    assert_eq!((scene.camera.fov, scene.camera.resolution), (35.0, [64, 36]));
    assert_eq!(scene.camera.view.eye, DVec3::new(0.0, 2.0, 6.0));
    assert_eq!(scene.light.view.target, DVec3::Y);
    assert_eq!(scene.light.projection, Projection::Perspective { fov: 40.0 });
    assert_eq!(scene.light.extent, LightExtent::rectangle([1.0, 0.5]));
    let area = scene.light.area().unwrap();
    assert_eq!(area.shape(), LightShape::Rectangle);
    let [right, up] = area.half_axes();
    assert!((right.length() - 0.5).abs() < 1e-12 && (up.length() - 0.25).abs() < 1e-12);
    assert_eq!(scene.shutter, [0.25, 0.75]);

    let hair = &scene.objects[0];
    let Shape::Curves(curves) = &*hair.shape else { panic!("{:?}", hair.shape) };
    assert_eq!(curves.radii(), [0.001; 2]);
    assert_eq!(hair.opacity, Rgb::new(0.3, 0.3, 0.3));
    // Translated, turned about z, scaled: x goes to y. At the close, the keys
    // that aren't given stay.
    for (time, translate) in [(0.0, DVec3::Y), (1.0, DVec3::X), (0.5, DVec3::new(0.5, 0.5, 0.0))] {
        let to_world = hair.to_world(time);
        let origin = to_world.transform_point3(DVec3::ZERO);
        assert!((origin - translate).length() < 1e-12);
        let x = to_world.transform_vector3(DVec3::X);
        assert!((x - DVec3::Y * 2.0).length() < 1e-12, "{x}");
    }
    assert_eq!(scene.objects[1].opacity, Rgb::new(0.25, 0.5, 1.0));
    assert!(scene.is_coloured() && scene.is_moving());
    assert_eq!(scene.objects[2].opacity, Rgb::new(0.5, 0.5, 0.5), "the lead");
    assert_eq!(scene.objects.len(), 2 + 8);
}

#[test]
fn what_is_not_given_is_as_documented() {
    let folder = folder();
    let scene = open(&folder, "[[object]]\nmesh = \"square.obj\"\n").unwrap();
    let model = open_scene(&folder.path().join("square.obj")).unwrap();
    assert_eq!((scene.light, scene.camera), (model.light, model.camera));
    // c = 0, R = √2.
    let eye = DVec3::new(1.0, 2.0, 1.0).normalize() * 3.0 * 2.0_f64.sqrt();
    assert!((scene.light.view.eye - eye).length() < 1e-12);
    let eye = DVec3::new(-1.0, 1.0, 2.0).normalize() * 3.0 * 2.0_f64.sqrt();
    assert!((scene.camera.view.eye - eye).length() < 1e-12);
    assert_eq!(scene.light.projection, Projection::Perspective { fov: 45.0 });
    assert_eq!((scene.light.extent, scene.shutter), (LightExtent::POINT, [0.0, 1.0]));
    assert!(!scene.is_moving() && !scene.is_coloured());

    let short = "[light]\neye = [0, 9, 0]\ntarget = [0, 0, 0]\n";
    let scene = open(&folder, short).unwrap();
    assert!(scene.objects.is_empty());
    assert_eq!(scene.light.extent, LightExtent::POINT);
    assert!(scene.light.raster([8, 8]).is_ok(), "up is parallel to the view");
    let wide = format!("{short}projection = \"orthographic\"\nextent = 4\nshape = \"disk\"\n");
    let light = open(&folder, &wide).unwrap().light;
    assert_eq!(light.projection, Projection::Orthographic { extent: 4.0 });
    assert_eq!(light.extent, LightExtent::disk(0.5));
    let camera = light.raster([8, 4]).unwrap().shadow_camera();
    let right = camera.world_to_ndc.unwrap() * DVec4::new(1.0, 0.0, 0.0, 1.0);
    assert!((right.truncate().truncate() - 0.5).abs().max_element() > 0.24);
}

#[test]
fn what_cannot_be_is_refused_where_it_stands() {
    let folder = folder();
    for (from, to, expected) in [
        ("fov = 35.0", "fof = 35.0", "line 6: unknown field `fof`"),
        ("opacity = 0.3", "opacitty = 0.3", "unknown field `opacitty`"),
        ("[shutter]", "[shuter]", "unknown field `shuter`"),
        ("scale = 2", "scala = 2", "unknown field `scala`"),
        ("scale = 2", "scale = 0", "object 1, transform: scale"),
        ("scale = 2", "scale = nan", "object 1, transform: scale"),
        ("translate = [1, 0, 0]", "translate = [1, 0]", "line 27: "),
        ("opacity = 0.3", "opacity = 1.5", "object 1, opacity: "),
        ("opacity = 0.3", "opacity = \"much\"", "opacity must be a number or [red, green, blue]"),
        ("opacity = [0.25, 0.5, 1]", "opacity = [0.25, nan, 1]", "object 2, opacity: "),
        ("thickness = 0.002", "thickness = -1", "object 1, thickness: "),
        ("thickness = 0.002", "density = 1", "object 1, density: only volumes"),
        ("mesh = \"square.obj\"", "mesh = \"square.obj\"\nthickness = 1", "object 2, thickness: "),
        ("mesh = \"square.obj\"", "", "object 2, shape: it has one of"),
        ("mesh = \"square.obj\"", "mesh = \"none.obj\"", "none.obj: cannot open"),
        ("mesh = \"square.obj\"", "mesh = \"one.hair\"", "one.hair: unsupported format, .hair: "),
        (
            "builtin = \"stained-glass\"",
            "builtin = \"moss\"",
            "no built-in scene is named `moss`; the names are hairball, ",
        ),
        (
            "target = [0, 1, 0]\nup = [0, 1, 0]\nprojection",
            "target = [2, 5, 2]\nprojection",
            "light, target: ",
        ),
        ("fov = 40.0", "fov = 180", "light, fov: "),
        (
            "projection = \"perspective\"",
            "projection = \"orthographic\"",
            "light, fov: an orthographic",
        ),
        ("fov = 40.0", "projection_is = 1", "unknown field `projection_is`"),
        ("fov = 40.0", "extent = 4", "light, extent: a perspective light has a fov"),
        (
            "shape = \"rectangle\"",
            "shape = \"disk\"",
            "light, size: a disk or a sphere has a radius",
        ),
        (
            "shape = \"rectangle\"",
            "shape = \"sphere\"",
            "light, size: a disk or a sphere has a radius",
        ),
        ("shape = \"rectangle\"", "", "light, size: a point has none"),
        ("size = [1.0, 0.5]", "radius = 0.5", "light, radius: a rectangle has a size"),
        ("projection = \"perspective\"", "projection = \"fisheye\"", "unknown variant `fisheye`"),
        ("size = [1.0, 0.5]", "size = [1.0, -0.5]", "light, light: a light's size"),
        ("resolution = [64, 36]", "resolution = [0, 36]", "camera, resolution: "),
        ("close = 0.75", "close = 0.2", "shutter: it has to open"),
        ("[shutter]", "[shutter", "line 18: "),
    ] {
        assert!(WHOLE.contains(from), "{from}");
        let error = open(&folder, &WHOLE.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{to}: {error}");
    }
    let error = open_scene(&PathBuf::from("none.toml")).unwrap_err().to_string();
    assert!(error.starts_with("none.toml: cannot open"), "{error}");
    fs::write(folder.path().join("odd.toml"), b"a = \"\xff\"").unwrap();
    let error = open_scene(&folder.path().join("odd.toml")).unwrap_err().to_string();
    assert!(error.contains("byte 5: not a text"), "{error}");
}

#[test]
fn files_are_read_once_for_many_objects() {
    let object = "[[object]]\nmesh = \"square.obj\"\ntransform = { translate = [0, 1, 0] }\n";
    let scene = open(&folder(), &object.repeat(3)).unwrap();
    assert!(std::sync::Arc::ptr_eq(&scene.objects[0].shape, &scene.objects[2].shape));
    assert_eq!(scene.bounds().min.y, 1.0);
}
