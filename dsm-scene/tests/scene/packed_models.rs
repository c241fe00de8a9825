//! A model that gltfpack packed in many ways: `tests/data/packed/make.py`.

use std::path::PathBuf;

use dsm_scene::detail::load_mesh;

use crate::light::stopped_by;

fn file(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests/data/packed", name].iter().collect()
}

#[test]
fn packed_models_are_the_same_models() {
    let source = stopped_by(&file("source.gltf")).unwrap();
    let triangles = load_mesh(&file("source.gltf")).unwrap().triangles().len();
    assert!(triangles > 150 && source.mean() > 0.2 && source.warnings.is_empty(), "{source:?}");
    for name in [
        "floats",
        "quantised",
        "compressed",
        "compressed_more",
        "compressed_fallback",
        "float_positions",
        "float_all",
        "khr",
    ] {
        let path = file(&format!("{name}.glb"));
        assert_eq!(load_mesh(&path).unwrap().triangles().len(), triangles, "{name}");
        let packed = stopped_by(&path).unwrap();
        assert!(packed.warnings.is_empty(), "{name}: {packed:?}");
        for (packed, source) in packed.halves.iter().zip(source.halves) {
            // Rays at the edges of triangles see what 14 bits make of them.
            assert!((packed - source).abs() < 1e-3, "{name}: {packed} and not {source}");
        }
    }
}
