//! Whole files of models, as scenes are opened from them.

use std::fs;
use std::path::Path;

use dsm_core::{HitSource, PixelSampling, TileHits, TileSamples};
use dsm_scene::{Scene, SceneRasterizer, Shape, open_scene};

/// What stands between the files of one input.
pub const BETWEEN_FILES: &[u8] = b"\n-----\n";

/// Opens a GLB file, or a glTF document; at rest, and at a time of its first animation.
///
/// # Panics
///
/// If the scene of what was accepted breaks its rules; so do the others here.
pub fn gltf(bytes: &[u8]) -> bool {
    let name = if bytes.starts_with(b"glTF") { "a.glb" } else { "a.gltf" };
    let scene = format!("[[object]]\nmesh = \"{name}\"\ntime = 0.4\nanimation = \"0\"\n");
    let [at_rest, at_a_time] =
        open([name, "scene.toml"], &[(name, bytes), ("scene.toml", scene.as_bytes())]);
    at_rest || at_a_time
}

/// Opens an OBJ file, `m.mtl` and `t.tga` beside it, with [`BETWEEN_FILES`] between them.
pub fn obj(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    let mut files = Vec::new();
    for name in ["a.obj", "m.mtl", "t.tga"] {
        let end = rest.windows(BETWEEN_FILES.len()).position(|window| window == BETWEEN_FILES);
        let end = end.filter(|_| name != "t.tga").unwrap_or(rest.len());
        files.push((name, &rest[..end]));
        rest = rest.get(end + BETWEEN_FILES.len()..).unwrap_or_default();
    }
    open_first(&files)
}

/// Opens a PLY file.
pub fn ply(bytes: &[u8]) -> bool {
    open_first(&[("a.ply", bytes)])
}

/// Opens a USD layer, text or binary, or a package of some.
pub fn usd(bytes: &[u8]) -> bool {
    let name = if bytes.starts_with(b"PK") { "a.usdz" } else { "a.usd" };
    open_first(&[(name, bytes)])
}

/// Opens a file of strands.
pub fn hair(bytes: &[u8]) -> bool {
    open_first(&[("a.hair", bytes)])
}

fn open_first(files: &[(&str, &[u8])]) -> bool {
    let [is_read] = open([files[0].0], files);
    is_read
}

/// Opens some of the files that lie in one folder, and looks at what is in them; whether
/// each could be read.
fn open<const N: usize>(names: [&str; N], files: &[(&str, &[u8])]) -> [bool; N] {
    // In memory where there is such a folder: files come by the thousand a second.
    let memory = Path::new("/dev/shm");
    let folder = tempfile::tempdir_in(memory).or_else(|_| tempfile::tempdir());
    let Ok(folder) = folder else { return [false; N] };
    for (name, bytes) in files {
        assert!(fs::write(folder.path().join(name), bytes).is_ok(), "no room for the files");
    }
    names.map(|name| {
        let scene = open_scene(&folder.path().join(name));
        scene.as_ref().is_ok_and(|scene| {
            check(scene);
            true
        })
    })
}

fn check(scene: &Scene) {
    for line in scene.warnings() {
        assert!(!line.contains(['\n', '\r']), "{line:?}");
    }
    let mut primitives = 0;
    for object in &scene.objects {
        let bounds = object.bounds();
        let is_finite = bounds.min.is_finite() && bounds.max.is_finite();
        assert!(bounds.is_empty() || is_finite, "{bounds:?}");
        let opacity = match &*object.shape {
            Shape::Mesh(mesh) => {
                primitives += mesh.triangles().len();
                let first = 0..mesh.triangles().len().min(16);
                first.map(|index| mesh.opacity(index, 0.25, 0.5)).fold(0.0, f32::max)
            }
            Shape::Curves(curves) => {
                primitives += curves.segments().len();
                let first = 0..curves.segments().len().min(16);
                first.map(|index| curves.opacity(index, 0.5)).fold(0.0, f32::max)
            }
            Shape::Volume(_) => 0.0,
        };
        assert!((0.0..=1.0).contains(&opacity), "{opacity}");
    }
    if primitives > 1000 {
        return;
    }
    let Ok(raster) = scene.light.raster([4; 2]) else { return };
    let Ok(source) = SceneRasterizer::<f32>::new(scene, raster) else { return };
    let Ok(sampling) = PixelSampling::new(2, 1) else { return };
    let Ok(samples) = TileSamples::new(&sampling, [0, 0], [4; 2], None) else { return };
    let mut hits = TileHits::new(samples.len());
    if source.hits(&samples, &mut hits).is_ok() {
        for (_, hit) in hits.surfaces() {
            assert!((0.0..=1.0).contains(&hit.opacity), "{hit:?}");
        }
    }
}
