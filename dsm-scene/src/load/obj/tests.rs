use std::path::Path;

use glam::Vec3;
use image::{ExtendedColorType, ImageFormat};

use super::parse;
use crate::error::Result;
use crate::load::library::Library;
use crate::load::warnings::Warnings;
use crate::mesh::TriangleMesh;

fn parse_bytes(bytes: &[u8], folder: &Path) -> Result<(TriangleMesh, Vec<String>)> {
    let mut warnings = Warnings::default();
    parse(bytes, folder, &Library::default(), &mut warnings)
        .map(|mesh| (mesh, warnings.into_lines()))
}

/// The mesh of a text that gives no warning.
fn parse_text(text: &str) -> Result<TriangleMesh> {
    parse_bytes(text.as_bytes(), Path::new("/nowhere")).map(|(mesh, warnings)| {
        assert!(warnings.is_empty(), "{warnings:?}");
        mesh
    })
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn area(mesh: &TriangleMesh) -> f32 {
    let areas = (0..mesh.triangles().len()).map(|at| {
        let [a, b, c] = mesh.corners(at);
        (b - a).cross(c - a).length() / 2.0
    });
    areas.sum()
}

#[test]
fn polygons_become_triangles() {
    let mesh = parse_text(&format!("{SQUARE}v 0.5 2 0\nf 1 2 3 4\nf 1 2 3 5 4\nl 1 2\np 1\n"));
    let mesh = mesh.unwrap();
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (5, 5));
    assert_eq!(mesh.corners(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    let relative = parse_text(&format!("{SQUARE}f -4 -3 -2\no b\nv 5 5 5\nf -1 -2 1\n"));
    assert_eq!(relative.unwrap().corners(1), [Vec3::splat(5.0), Vec3::Y, Vec3::ZERO]);
    let ahead = parse_text(&format!("f 1 2 3\n{SQUARE}f 1 2\nf 1\nf\n")).unwrap();
    assert_eq!(ahead.triangles(), [[0, 1, 2]]);
    let arrow = "v 0 0 0\nv 1 2 0\nv 2 0 0\nv 1 1 0\n";
    for roll in ["1 2 3 4", "2 3 4 1", "3 4 1 2", "4 1 2 3", "4 3 2 1"] {
        let mesh = parse_text(&format!("{arrow}f {roll}\n")).unwrap();
        assert_eq!(area(&mesh), 1.0, "{roll}");
    }
}

#[test]
fn text_is_read_as_programs_write_it() {
    for text in [
        "f 1 2 3 4 # front\n",
        "f 1 2 \\\n 3 4\n",
        "f 1 2 \\\r\n3 4",
        "f 1// 2// 3// 4//\n",
        "f 1//1 2//1 3//1 4//9\n",
        "f 1/1/1 2/2/2 3/3/3 4/4/4\n",
        "f 1/7 2/-1 3 4\n",
        "usemtl \nf 1 2 3 4\n",
        "usemtl\nf 1 2 3 4\n",
        "usemtl (null)\ng\ns off\nvn 0 0\nvp 1\nf 1 2 3 4\n",
        "# \\\nf 1 2 3 4\n",
        "f\t1  2\t3 4 \n",
        "v nan nan -nan(ind)\nf 1 2 3 4\n",
        "v 0 0 0 0.5 0.5 0.5\nf 1 2 3 4\n",
        "o a b # c\nf 1 2 3 4\nv 9 9 9 1\nl 5 1\np 5\n",
        "fo 1 2 3 4\n",
    ] {
        let mesh = parse_text(&format!("{SQUARE}{text}")).unwrap();
        assert_eq!((area(&mesh), mesh.triangles().len()), (1.0, 2), "{text:?}");
        let old = format!("\u{feff}{SQUARE}{text}").replace('\n', "\r");
        assert_eq!(area(&parse_text(&old.replace("\r\r", "\r")).unwrap()), 1.0, "{text:?}");
    }
    let mesh = parse_bytes(b"# caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", Path::new(""));
    assert_eq!(mesh.unwrap().0.triangles().len(), 1);
}

#[test]
fn broken_faces_are_refused_with_their_line() {
    for face in [
        "f 1 2 5",
        "f 0 1 2",
        "f 1 2 -5",
        "f 1 2 x",
        "f 1 2 /1",
        "f 1/x 2 3",
        "f 1 2 9223372036854775807",
        "f 1 2 -9223372036854775808",
        "f 1/1/1/1 2 3",
        "f 1 2 99999999999999999999",
        "v 1 2",
        "v 1 2 x",
        "vt",
    ] {
        let error = parse_text(&format!("{SQUARE}{face}\n")).unwrap_err();
        assert!(error.to_string().starts_with("line 5: "), "{face}: {error}");
    }
    let error = parse_text("v 0 0 0\nv 1 x 0\nv 1 1 1\n").unwrap_err();
    assert_eq!(error.to_string(), "line 2: a vertex is three numbers");
    assert!(parse_text("v nan 0 0\nf 1 1 1\n").is_err());
    assert!(parse_text("v 1e39 0 0\nf 1 1 1\n").is_err());
    assert!(parse_bytes(b"v \xff\xfe 0\n", Path::new("")).is_err());
    let error = parse_bytes(b"\xff\xfev\0 \0", Path::new("")).unwrap_err();
    assert!(error.to_string().contains("UTF-16"), "{error}");
    assert!(parse_text("").unwrap().triangles().is_empty());
}

/// The opacity of a face with `library` as its material m, and the warnings.
fn opacity(library: &str) -> Result<(f32, Vec<String>)> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.mtl"), library).unwrap();
    let text = format!("mtllib a b.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
    let (mesh, warnings) = parse_bytes(text.as_bytes(), folder.path())?;
    Ok((mesh.opacity(0, 0.2, 0.2), warnings))
}

#[test]
fn materials_dissolve() {
    for (library, want) in [
        ("newmtl m\nKd 1\nd 0.25\n", 0.25),
        ("newmtl m\nTr 0.25\n", 0.75),
        ("newmtl m\nTr 0.75\nd 0.25\n", 0.25),
        ("newmtl m\n", 1.0),
        ("newmtl m\nd 1.0\nTr 0.0\n", 1.0),
        ("\u{feff}newmtl m \r\n\td 0.5 # half\r\n", 0.5),
        ("d 0.1\nnewmtl other\nd 0.3\nnewmtl m\nd 0.5\nnewmtl m\nd 0.7", 0.5),
        ("newmtl m\rD 0.5\r", 0.5),
    ] {
        assert_eq!(opacity(library).unwrap(), (want, Vec::new()), "{library:?}");
    }
    for (library, want, warning) in [
        ("newmtl m\nd -halo 0.5\n", 0.5, "d -halo"),
        ("newmtl m\nTr 1.000\n", 0.0, "invisible"),
        ("newmtl m\nTr 1\nd 1\n", 1.0, "do not add up"),
        ("newmtl m\nd 1.5\n", 1.0, "into [0, 1]"),
        ("newmtl n\nd 0.5\n", 1.0, "no material m"),
    ] {
        let (found, warnings) = opacity(library).unwrap();
        assert_eq!(found, want, "{library:?}");
        assert!(warnings.len() == 1 && warnings[0].contains(warning), "{warnings:?}");
    }
    for library in ["newmtl m\nd x\n", "newmtl m\nd\n", "newmtl m\nTr nan\n", "newmtl m\nmap_d\n"] {
        let error = opacity(library).unwrap_err();
        assert!(error.to_string().contains("a b.mtl: line 2: "), "{error}");
    }
    let text = format!("mtllib a.mtl b.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
    let (mesh, warnings) = parse_bytes(text.as_bytes(), Path::new("/nowhere")).unwrap();
    assert!(mesh.alphas().is_empty());
    assert_eq!(warnings, ["no material m (a.mtl, b.mtl is missing): it is taken for opaque"]);
}

#[test]
fn names_match_in_any_encoding() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("l.mtl"), b"newmtl gr\xfcn # 1\nd 0.5\n").unwrap();
    for name in [b"gr\xfcn # 1".as_slice(), "grün # 1".as_bytes()] {
        let text =
            [b"mtllib l.mtl\nusemtl ".as_slice(), name, b"\n", SQUARE.as_bytes(), b"f 1 2 3"];
        let (mesh, warnings) = parse_bytes(&text.concat(), folder.path()).unwrap();
        assert_eq!((mesh.opacity(0, 0.1, 0.1), warnings.len()), (0.5, 0));
    }
    std::fs::write(folder.path().join("l.mtl"), "newmtl glass\nd 0.5\n").unwrap();
    let text = format!("mtllib l.mtl none.mtl\n{SQUARE}usemtl glass # pane\nf 1 2 3");
    let (mesh, _) = parse_bytes(text.as_bytes(), folder.path()).unwrap();
    assert_eq!(mesh.opacity(0, 0.1, 0.1), 0.5);
}

#[test]
fn maps_of_opacity_are_read_the_right_way_up() {
    let folder = tempfile::tempdir().unwrap();
    // The upper row of an image is where v is large.
    let image = |name: &str, format| {
        let path = folder.path().join(name);
        let (pixels, kind) = ([255; 3].into_iter().chain([51; 3]), ExtendedColorType::Rgb8);
        let pixels: Vec<u8> = pixels.collect();
        image::save_buffer_with_format(path, &pixels, 1, 2, kind, format).unwrap();
    };
    image("leaf 1.png", ImageFormat::Png);
    image("leaf.tga", ImageFormat::Tga);
    image("leaf.bmp", ImageFormat::Bmp);
    image("leaf.webp", ImageFormat::WebP);
    let corners = "vt 0 0\nvt 0 0.5\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";
    let text = format!("mtllib a.mtl\n{SQUARE}{corners}");
    let load = |map: &str| {
        let library = format!("newmtl m\nmap_d {map}\n");
        std::fs::write(folder.path().join("a.mtl"), library).unwrap();
        parse_bytes(text.as_bytes(), folder.path())
    };
    for map in
        ["leaf 1.png", "-clamp on leaf.tga", "leaf.bmp", "leaf.webp", "C:\\textures\\leaf 1.png"]
    {
        let (mesh, warnings) = load(map).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!((mesh.opacity(0, 0.5, 0.0) - 0.2).abs() < 1e-6, "{map}");
        assert!(mesh.opacity(0, 0.5, 0.5) > 0.9, "{map}");
    }
    // Moved by half of it: what was below is above.
    let (mesh, _) = load("-o 0 0.5 leaf 1.png").unwrap();
    assert!((mesh.opacity(0, 0.5, 0.0) - 1.0).abs() < 1e-6);
    let (mesh, _) = load("-mm 0.5 0.5 leaf 1.png").unwrap();
    assert!((mesh.opacity(0, 0.5, 0.0) - 0.6).abs() < 3e-3);
    let error = load("-clamp on no leaf.png").unwrap_err();
    assert!(error.to_string().contains("no leaf.png: cannot open"), "{error}");
    load("leaf 1.png").unwrap();
    let text = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
    let (mesh, warnings) = parse_bytes(text.as_bytes(), folder.path()).unwrap();
    assert_eq!(mesh.opacity(0, 0.5, 0.0), 1.0);
    assert!(warnings[0].contains("without texture coordinates"), "{warnings:?}");
}
