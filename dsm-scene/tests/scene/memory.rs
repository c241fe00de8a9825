//! The memory that scenes take: once for what is shared, refused before it is taken.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use dsm_scene::detail::{SceneOptions, open_scene_with};
use dsm_scene::{Error, Shape};

fn write_plane(path: &Path, cells: u32) {
    let mut text = String::new();
    let count = cells + 1;
    for (y, x) in (0..count).flat_map(|y| (0..count).map(move |x| (y, x))) {
        writeln!(text, "v {x} {y} 0").unwrap();
    }
    for (y, x) in (0..cells).flat_map(|y| (0..cells).map(move |x| (y, x))) {
        let corner = y * count + x + 1;
        writeln!(text, "f {corner} {} {} {}", corner + 1, corner + count + 1, corner + count)
            .unwrap();
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_scene_states_what_it_takes_and_is_refused_beyond_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    write_plane(&folder.path().join("ground.obj"), 100);
    let scene = folder.path().join("scene.toml");
    let object = "[[object]]\nmesh = \"ground.obj\"\n";
    std::fs::write(&scene, object.repeat(3)).unwrap();

    let opened = open_scene_with(&scene, &SceneOptions::default()).unwrap();
    let memory = opened.memory();
    let [(structures, built), (file, bytes)] = memory.largest()[..] else { panic!("{memory}") };
    assert_eq!((structures, file), ("structures to trace", "ground.obj"));
    // Positions, corners and a material index: the mesh is there once, however often it
    // stands in the scene.
    let least = 101 * 101 * 12 + 2 * 100 * 100 * 16;
    assert!((least..least + 1024).contains(&bytes), "{bytes}");
    assert!(built > 3 * 2 * 100 * 100 * 200, "{built}");
    assert_eq!(memory.total(), bytes + built);

    let enough = SceneOptions::default().memory(memory.total());
    assert!(open_scene_with(&scene, &enough).is_ok());
    for limit in [memory.total() - 1, bytes, 1 << 10] {
        let refused = open_scene_with(&scene, &SceneOptions::default().memory(limit)).unwrap_err();
        let text = refused.to_string();
        assert!(text.contains("more than the") && text.contains("ground.obj"), "{text}");
        let mut cause: &dyn std::error::Error = &refused;
        while let Some(next) = cause.source() {
            cause = next;
        }
        assert!(matches!(refused, Error::Memory { .. } | Error::File(_)), "{cause}");
    }
}

#[test]
fn objects_of_one_builtin_share_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, "[[object]]\nbuiltin = \"hairball\"\n".repeat(4)).unwrap();
    let scene = open_scene_with(&path, &SceneOptions::default()).unwrap();
    let shapes: Vec<&Arc<Shape>> = scene.objects.iter().map(|object| &object.shape).collect();
    let of_one = shapes.len() / 4;
    assert!(of_one > 0 && shapes.len() == 4 * of_one);
    for (at, shape) in shapes.iter().enumerate() {
        assert!(Arc::ptr_eq(shape, shapes[at % of_one]), "{at}");
    }
}
