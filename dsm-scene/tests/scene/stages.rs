//! USD stages as scenes, whole and damaged.

use std::path::{Path, PathBuf};
use std::time::Instant;

use dsm_core::{Ray, RayHits};
use dsm_scene::detail::{Result, load_shape};
use dsm_scene::{Scene, Shape, TracedScene, open_scene};
use glam::DVec3;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/usd").join(name)
}

fn open_text(text: &str) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.usda");
    std::fs::write(&path, format!("#usda 1.0\n{text}")).unwrap();
    open_scene(&path)
}

const QUAD: &str = "int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]";

/// Depths and opacities along −z from (x, y, 10).
fn hits(scene: &Scene, x: f64, y: f64) -> Vec<(f64, f32)> {
    let mut hits = RayHits::<f32>::default();
    let traced = TracedScene::new(scene).unwrap();
    let ray = Ray::new(DVec3::new(x, y, 10.0), DVec3::NEG_Z);
    traced.tracer().hits(&ray, &mut hits).unwrap();
    hits.surfaces().iter().map(|surface| (f64::from(surface.depth), surface.opacity)).collect()
}

#[test]
fn opacities_of_a_stage_dim_rays() {
    let scene = open_text(&format!(
        r#"
def Mesh "Front" {{ {QUAD}
    float[] primvars:displayOpacity = [0, 1, 1, 0] (interpolation = "vertex")
}}
def Xform "Behind" {{
    float[] primvars:displayOpacity = [0.25]
    double xformOp:translateZ = -2
    uniform token[] xformOpOrder = ["xformOp:translateZ"]
    def Mesh "Pane" {{ {QUAD} }}
    def Points "Dots" {{
        point3f[] points = [(0.5, 0.5, -1)]
        float[] widths = [0.5] (interpolation = "constant")
    }}
}}
"#
    ))
    .unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    assert_eq!(scene.objects.len(), 2, "one of surfaces, one of strands");
    let near = |found: Vec<(f64, f32)>, expected: &[(f64, f32)]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found.0 - expected.0).abs() < 1e-6, "{found:?}");
            assert!((found.1 - expected.1).abs() < 1e-6, "{found:?}");
        }
    };
    near(hits(&scene, 0.5, 0.0), &[(10.0, 0.75), (12.0, 0.25)]);
    near(hits(&scene, -0.25, 0.3), &[(10.0, 0.375), (12.0, 0.25)]);
    // A point is a disc of half its width.
    near(hits(&scene, 0.5, 0.74), &[(10.0, 0.75), (12.0, 0.25), (13.0, 0.25)]);
    near(hits(&scene, 0.5, 0.76), &[(10.0, 0.75), (12.0, 0.25)]);
}

#[test]
fn a_scene_file_places_a_stage_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |more: &str| {
        let stage = data("text/time.usda");
        let text = format!("[[object]]\nusd = '{}'\n{more}", stage.display());
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        open_scene(&path)
    };
    let opened = scene("time = 5\nopacity = 0.5\ntransform = { translate = [0, 100, 0] }").unwrap();
    let bounds = opened.bounds();
    // Still is at (4, 0, 0) and turned by 45° about x, Moving at z = 2 to 4 of its own.
    assert!((bounds.min.x - 4.0).abs() < 1e-5 && bounds.min.y > 90.0, "{bounds:?}");
    assert!(opened.objects.iter().all(|object| object.opacity.red == 0.5));
    let default = scene("").unwrap().bounds();
    assert!(default.min.x > -1.0 && default.min.y > -1.0, "{default:?}");
    for (odd, key) in [
        ("mesh = 'a.obj'", "shape"),
        ("thickness = 1.0", "thickness"),
        ("time = inf", "time"),
        ("grid = 'a'", "grid"),
    ] {
        let error = scene(odd).unwrap_err().to_string();
        assert!(error.contains(&format!("object 1, {key}: ")), "{error}");
    }
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, "[[object]]\nbuiltin = 'hairball'\ntime = 1\n").unwrap();
    let error = open_scene(&path).unwrap_err().to_string();
    assert!(error.contains("time: only usd and mesh have one"), "{error}");
}

#[test]
fn what_is_left_out_is_said() {
    let scene = open_text(&format!(
        r#"(
    upAxis = "Z"
)
def Sphere "Ball" {{ }}
def Cube "Box" {{ }}
def Cube "Other" {{ }}
def Mesh "Skinned" {{ {QUAD}
    int[] primvars:skel:jointIndices = [0]
}}
def "Lost" (references = @none.usda@) {{ }}
def "Nowhere" (references = </None>) {{ }}
def "Round" (references = </Round/Below>) {{ def "Below" {{ }} }}
def Material "Glass" {{ def Shader "S" {{ float inputs:opacity = 0.5
 }} }}
def PointInstancer "Copies" {{
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = </Missing>
}}
"#
    ))
    .unwrap();
    let warnings = scene.warnings().join("\n");
    for part in [
        "up axis is Z",
        "1 prims of type Sphere",
        "2 prims of type Cube",
        "/Skinned: its skeleton",
        "none.usda is left out",
        "/Nowhere: /None is not there",
        "/Round/Below is composed of itself",
        "no prototype /Missing",
        "/Glass/S: the opacity of a material",
    ] {
        assert!(warnings.contains(part), "{part} in {warnings}");
    }
    assert!(scene.warnings()[0].contains("stage.usda: "));
    let empty = open_text("").unwrap();
    assert!(empty.warnings()[0].ends_with("nothing in it is drawn"), "{:?}", empty.warnings());
}

#[test]
fn stages_no_scene_can_have_are_refused_where_they_are_wrong() {
    for (body, reason) in [
        ("int[] faceVertexCounts = [4]", "/A: its faces have 4 corners, and 0 are there"),
        (
            "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]",
            "/A: point 0 is out of range: there are 0",
        ),
        ("int[] faceVertexCounts = [-3]", "/A: faceVertexCounts has -3"),
        ("point3f[] points = [(0, 0)]", "/A: points are no vectors"),
        ("point3f[] points = [(0, 0, 0), (0, 0)]", "line 4: its elements are not alike"),
        ("point3f[] points = [(0, 0, 0", "line 5: "),
        ("float x = ]", "line 4: "),
    ] {
        let opened = open_text(&format!("\ndef Mesh \"A\" {{\n{body}\n}}\n"));
        let error = opened.expect_err(body);
        assert!(error.to_string().contains(reason), "{error}: {reason}");
    }
    let error = open_text("def BasisCurves \"A\" { int[] curveVertexCounts = [2]\n }").unwrap_err();
    assert!(error.to_string().contains("its curves have 2 points, and 0 are there"), "{error}");
    for name in ["a.usda", "a.usdc", "a.usd", "a.usdz"] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, b"").unwrap();
        assert!(open_scene(&path).is_err(), "{name}");
        assert!(load_shape(&path).unwrap_err().to_string().contains("many shapes"));
    }
}

#[test]
fn small_files_make_no_large_scenes() {
    let started = Instant::now();
    // Each prim refers to the one before twice: 2^40 leaves.
    let mut doubling = format!("def Mesh \"p0\" {{ {QUAD}\n }}\n");
    for at in 1..40 {
        let below = at - 1;
        doubling += &format!(
            "def \"p{at}\" {{ def \"a\" (references = </p{below}>) {{ }}\n\
             def \"b\" (references = </p{below}>) {{ }} }}\n"
        );
    }
    assert!(open_text(&doubling).unwrap_err().to_string().contains("opinions"));
    // Copies of copies: 20^20.
    let zeros = vec!["0"; 20].join(", ");
    let places = vec!["(0, 0, 0)"; 20].join(", ");
    let mut copies = format!("def Mesh \"p0\" {{ {QUAD}\n }}\n");
    for at in 1..20 {
        copies += &format!(
            "def PointInstancer \"p{at}\" {{ rel prototypes = </p{}>\n\
             int[] protoIndices = [{zeros}]\npoint3f[] positions = [{places}]\n }}\n",
            at - 1
        );
    }
    assert!(open_text(&copies).unwrap_err().to_string().contains("shapes: "));
    let itself = "def PointInstancer \"p\" { rel prototypes = </p>\n\
        int[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\n }";
    assert!(open_text(itself).unwrap_err().to_string().contains("nested too deep"));
    let deep = "def \"a\" {\n".repeat(100_000);
    assert!(open_text(&deep).unwrap_err().to_string().contains("nested too deep"));
    let deep = format!("def \"a\" {{ float[] b = {}", "[".repeat(100_000));
    assert!(open_text(&deep).unwrap_err().to_string().contains("nested too deep"));
    let deep = format!("(\n customData = {}", "{ dictionary a = ".repeat(100_000));
    assert!(open_text(&deep).is_err());
    let chain: String =
        (0..100).map(|at| format!("def \"p{at}\" (references = </p{}>) {{ }}\n", at + 1)).collect();
    assert!(open_text(&chain).unwrap_err().to_string().contains("nested too deep"));
    assert!(started.elapsed().as_secs() < 120, "{:?}", started.elapsed());
}

/// Every prefix of a file, and the file with bytes changed all over it.
fn torture(name: &str, steps: usize) {
    let whole = std::fs::read(data(name)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(Path::new(name).file_name().unwrap());
    let check = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        if let Ok(scene) = open_scene(&path) {
            let bounds = scene.bounds();
            assert!(bounds.is_empty() || bounds.min.is_finite() && bounds.max.is_finite());
            for object in &scene.objects {
                assert!(!matches!(&*object.shape, Shape::Volume(_)));
            }
        }
    };
    for length in 0..whole.len() {
        check(&whole[..length]);
    }
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..steps {
        let mut broken = whole.clone();
        for _ in 0..=next(3) {
            let at = next(whole.len());
            let run = 1 + next(4);
            let value = [0, 1, 0x7f, 0x80, 0xff, b'[', b'(', next(256) as u8][next(8)];
            broken[at..(at + run).min(whole.len())].fill(value);
        }
        check(&broken);
    }
}

#[test]
fn damaged_text() {
    torture("text/instances.usda", 1500);
    torture("text/time.usda", 1500);
}

#[test]
fn damaged_binaries() {
    for name in ["meshes", "curves", "points", "instances", "time"] {
        torture(&format!("binary/{name}.usdc"), 2000);
    }
}

#[test]
fn damaged_archives() {
    torture("packed/points.usdz", 1500);
    torture("packed/composed.usdz", 1500);
}
