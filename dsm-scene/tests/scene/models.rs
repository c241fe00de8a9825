//! OBJ and PLY files as programs write them, by the light that they stop.

use std::path::Path;

use crate::light::{Stopped, stopped_by};

/// The left half of the square.
const LEFT: &str = "v -1 -1 0\nv 0 -1 0\nv 0 1 0\nv -1 1 0\n";

fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) -> Stopped {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    stopped_by(&path).unwrap()
}

fn check(found: &Stopped, want: f64, name: &str) {
    assert!((found.mean() - want).abs() <= 0.004, "{name}: {want} and not {found:?}");
}

#[test]
fn obj_files_of_every_kind() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, text, want) in [
        ("comment", format!("{LEFT}f 1 2 3 4 # front\n"), 0.5),
        ("continuation", format!("{LEFT}f 1 2 \\\n  3 4\n"), 0.5),
        ("byte order mark", format!("\u{feff}{LEFT}f 1 2 3 4\n"), 0.5),
        ("carriage returns", format!("{LEFT}f 1 2 3 4\n").replace('\n', "\r"), 0.5),
        ("both", format!("{LEFT}f 1 2 3 4\n").replace('\n', "\r\n"), 0.5),
        ("empty name", format!("{LEFT}usemtl \nf 1 2 3 4\n"), 0.5),
        ("normals that are missing", format!("{LEFT}f 1//1 2//1 3//1 4//1\n"), 0.5),
        ("empty uvs", format!("{LEFT}f 1// 2// 3// 4//\n"), 0.5),
        ("uvs that are missing", format!("{LEFT}f 1/1 2/2 3/3 4/4\n"), 0.5),
        ("relative", format!("{LEFT}f -4 -3 -2 -1\nv 5 5 5\n"), 0.5),
        (
            "colours of some",
            format!(
                "{LEFT}v 0 -1 0 1 0 0\nv .5 -1 0 1 0 0\nv .5 1 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3 4\nf 5 6 7 8\n"
            ),
            0.75,
        ),
        ("points and lines", format!("{LEFT}p 1 2 3\nl 1 2 3 4 1\nf 1 2 3 4\n"), 0.5),
        ("arrow", "v -1 -1 0\nv 0 -.5 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3 4\n".to_owned(), 0.375),
        ("arrow turned", "v -1 -1 0\nv 0 -.5 0\nv 1 -1 0\nv 0 1 0\nf 3 2 1 4\n".to_owned(), 0.375),
        // Not in a plane: as seen from the light, what it was drawn as.
        ("bent", "v -1 -1 .3\nv 0 -.5 0\nv 1 -1 .3\nv 0 1 -.4\nf 2 3 4 1\n".to_owned(), 0.375),
    ] {
        let found = write(folder, "a.obj", &text);
        check(&found, want, name);
        assert!(found.warnings.is_empty(), "{name}: {found:?}");
    }
    let mut latin = b"# caf\xe9\n".to_vec();
    latin.extend(LEFT.as_bytes());
    latin.extend(b"usemtl (null)\nf 1 2 3 4\n");
    check(&write(folder, "latin.obj", &latin), 0.5, "Latin-1");
    let lines = write(folder, "lines.obj", format!("{LEFT}l 1 2 3 4 1\np 1\n"));
    check(&lines, 0.0, "lines");
    assert!(lines.warnings[0].contains("lines.obj: it has no surface"), "{lines:?}");
}

#[test]
fn obj_materials_of_every_kind() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // White above, black below.
    let pixels: Vec<u8> = (0..64 * 64).map(|at| if at < 64 * 32 { 255 } else { 0 }).collect();
    for name in ["leaf 1.png", "leaf.jpg", "leaf.tga", "leaf.bmp"] {
        image::save_buffer(folder.join(name), &pixels, 64, 64, image::ExtendedColorType::L8)
            .unwrap();
    }
    let square = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let object = format!("mtllib a.mtl\n{square}usemtl m\nf 1/1 2/2 3/3 4/4\n");
    for (library, want, warned) in [
        ("d 0.25", 0.25, false),
        ("Tr 0.25", 0.75, false),
        ("d 0.25\nTr 0.75", 0.25, false),
        ("d -halo 0.25", 0.25, true),
        ("Tr 1.000000", 0.0, true),
        ("map_d leaf.jpg", 0.5, false),
        ("map_d leaf.tga", 0.5, false),
        ("map_d leaf.bmp", 0.5, false),
        ("map_d leaf 1.png", 0.5, false),
        ("map_d -clamp on leaf 1.png", 0.5, false),
        ("map_d -s 1 1 1 -o 0 0 0 -mm 0 0.5 leaf 1.png\nd 0.5", 0.125, false),
        ("map_d C:\\maps\\leaf.jpg", 0.5, false),
        ("Kd 1 1\nmap_Kd none.png\nillum 2", 1.0, false),
    ] {
        std::fs::write(folder.join("a.mtl"), format!("newmtl m\n{library}\n")).unwrap();
        let found = write(folder, "a.obj", &object);
        check(&found, want, library);
        assert_eq!(!found.warnings.is_empty(), warned, "{library}: {found:?}");
    }
    std::fs::write(folder.join("a.mtl"), b"newmtl gr\xfcn\nd 0.5\n").unwrap();
    let latin = [b"mtllib a.mtl\n".as_slice(), square.as_bytes(), b"usemtl gr\xfcn\nf 1 2 3 4\n"];
    check(&write(folder, "latin.obj", latin.concat()), 0.5, "Latin-1");
    std::fs::remove_file(folder.join("a.mtl")).unwrap();
    let found = write(folder, "a.obj", &object);
    check(&found, 1.0, "no library");
    assert!(found.warnings[0].contains("no material m (a.mtl is missing)"), "{found:?}");
}

fn ply(properties: &str, vertices: &str, elements: &str, rows: &str) -> String {
    let count = vertices.lines().count();
    format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
         property float z\n{properties}{elements}end_header\n{vertices}{rows}"
    )
}

#[test]
fn ply_files_of_every_kind() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let left = "-1 -1 0\n0 -1 0\n0 1 0\n-1 1 0\n";
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    let edges = "element edge 1\nproperty int vertex1\nproperty int vertex2\n";
    let colours = "-1 -1 0 51\n0 -1 0 51\n0 1 0 51\n-1 1 0 51\n";
    for (name, text, want, warning) in [
        ("face", ply("", left, face, "4 0 1 2 3\n"), 0.5, None),
        ("other name", ply("", left, &face.replace("indices", "index"), "4 0 1 2 3\n"), 0.5, None),
        ("wrapped", ply("", left, face, "4\n0 1\n2 3\n"), 0.5, None),
        ("arrow", ply("", "-1 -1 0\n0 -.5 0\n1 -1 0\n0 1 0\n", face, "4 0 1 2 3\n"), 0.375, None),
        ("strips", ply("", left, strips, "8 0 1 3 2 -1 0 0 1\n"), 0.5, None),
        ("edges", ply("", left, edges, "0 1\n"), 0.0, Some("no surface")),
        ("points", ply("", left, "", ""), 0.0, Some("no surface")),
        ("unused", ply("", &format!("{left}nan inf 0\n"), face, "4 0 1 2 3\n"), 0.5, None),
        ("alpha", ply("property uchar alpha\n", colours, face, "4 0 1 2 3\n"), 0.1, Some("alpha")),
    ] {
        let found = write(folder, "a.ply", &text);
        check(&found, want, name);
        match warning {
            None => assert!(found.warnings.is_empty(), "{name}: {found:?}"),
            Some(warning) => assert!(found.warnings[0].contains(warning), "{name}: {found:?}"),
        }
    }
}
