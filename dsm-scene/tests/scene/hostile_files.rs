//! Files that are not what they say: an error or a finite shape, and neither a
//! panic nor memory beyond measure.

use std::error::Error as _;
use std::io;
use std::path::Path;

use dsm_scene::detail::{Result, load_curves, load_mesh, load_shape, load_volume};
use dsm_scene::{Error, Shape};

use crate::support::{is_long, real_file};

/// Reads `bytes` as a file of this name, in a folder of its own.
fn load_bytes(name: &str, bytes: &[u8]) -> Result<Shape> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    load_shape(&path)
}

fn finite(shape: &Shape) -> bool {
    let bounds = shape.bounds();
    bounds.is_empty() || (bounds.min.is_finite() && bounds.max.is_finite())
}

#[test]
fn missing_and_unknown_files_are_named() {
    let missing = [
        load_mesh(Path::new("no/such.obj")).unwrap_err(),
        load_mesh(Path::new("no/such.glb")).unwrap_err(),
        load_curves(Path::new("no/such.hair")).unwrap_err(),
        load_volume(Path::new("no/such.vdb"), None).unwrap_err(),
        load_shape(Path::new("no/such.ply")).unwrap_err(),
    ];
    for error in missing {
        assert!(error.to_string().starts_with("no/such."), "{error}");
        assert!(error.to_string().ends_with("cannot open"), "{error}");
        let cause = error.source().and_then(|cause| cause.downcast_ref::<io::Error>());
        assert_eq!(cause.map(io::Error::kind), Some(io::ErrorKind::NotFound), "{error}");
    }
    let error = load_shape(Path::new("a.fbx")).unwrap_err();
    assert!(matches!(&error, Error::File { .. }), "{error}");
    assert!(error.to_string().contains(".fbx") && error.to_string().contains(".ply"), "{error}");
    assert!(load_mesh(Path::new("a.hair")).is_err() && load_curves(Path::new("a")).is_err());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("folder.ply");
    std::fs::create_dir(&path).unwrap();
    let error = load_mesh(&path).unwrap_err();
    let cause = error.source().unwrap().to_string();
    assert_eq!(cause, "not a regular file", "{error}");
}

#[test]
fn empty_files_are_refused_or_empty() {
    for name in ["a.ply", "a.gltf", "a.glb", "a.hair", "a.vdb"] {
        assert!(load_bytes(name, b"").is_err(), "{name}");
    }
    assert!(load_bytes("a.obj", b"").unwrap().bounds().is_empty());
}

/// Every prefix of a kind of lengths, and the file with bytes changed all over
/// its first part, where counts and lengths stand.
fn torture(name: &str, steps: usize) {
    let Some(path) = real_file(name) else { return };
    let steps = if is_long() { steps * 30 } else { steps };
    let whole = std::fs::read(&path).unwrap();
    let file = Path::new(name).file_name().unwrap().to_str().unwrap();
    for step in 0..steps {
        let length = whole.len() * step / steps;
        if let Ok(shape) = load_bytes(file, &whole[..length]) {
            assert!(finite(&shape), "{name}, {length} bytes");
        }
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
            let reach = [64, 512, 4096, whole.len()][next(4)].min(whole.len());
            let at = next(reach);
            let value = [0, 1, 0x7f, 0x80, 0xff][next(5)];
            let run = 1 + next(4);
            broken[at..(at + run).min(whole.len())].fill(value);
        }
        if let Ok(shape) = load_bytes(file, &broken) {
            assert!(finite(&shape), "{name}");
        }
    }
}

#[test]
fn damaged_glb() {
    torture("mesh/Fox.glb", 150);
    torture("mesh/eztree_oak_medium.glb", 40);
}

#[test]
fn damaged_obj() {
    torture("hair/sintel_head.obj", 25);
}

#[test]
fn damaged_hair() {
    torture("hair/ponytail.hair", 60);
}

#[test]
fn damaged_vdb() {
    torture("volume/smoke.vdb", 60);
}
