use glam::{Vec2, Vec3};

use super::parse as parse_with;
use crate::error::Result;
use crate::load::warnings::Warnings;
use crate::mesh::TriangleMesh;

fn parse(bytes: &[u8]) -> Result<TriangleMesh> {
    parse_with(bytes, &mut Warnings::default())
}

const TEXT: &str = "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\n\
    property double y\nproperty int z\nproperty uchar red\nelement strange 1\n\
    property list uchar float of\nelement face 2\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 2 9\n3 1 2 3\n4 0 1 2 3\n3 2 1 0\n";

fn binary(order: &str, bytes: impl Fn(f32, u32) -> ([u8; 4], [u8; 4])) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty float x\n\
         property float y\nproperty float z\nproperty float u\nproperty float v\n\
         element face 1\nproperty list uint uint vertex_index\nend_header\n"
    )
    .into_bytes();
    for value in [0.0, 0.0, 0.0, 0.25, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0] {
        file.extend(bytes(value, 0).0);
    }
    [3, 0, 2, 1].into_iter().for_each(|value| file.extend(bytes(0.0, value).1));
    file
}

#[test]
fn text_and_both_byte_orders_are_read() {
    for text in [TEXT.to_owned(), TEXT.replace('\n', "\r\n"), TEXT.replace('\n', "\r")] {
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!((mesh.positions().len(), mesh.triangles().len()), (4, 3));
        assert_eq!(
            mesh.corners(1),
            [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 2.0)]
        );
    }
    let little = binary("little", |f, u| (f.to_le_bytes(), u.to_le_bytes()));
    let big = binary("big", |f, u| (f.to_be_bytes(), u.to_be_bytes()));
    for file in [little, big] {
        let mesh = parse(&file).unwrap();
        assert_eq!(mesh.corners(0), [Vec3::ZERO, Vec3::new(0.0, 1.0, 2.0), Vec3::X]);
        assert_eq!(mesh.uvs()[0], Vec2::new(0.25, 0.0));
    }
}

const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

/// A file of four vertices, with `properties` and `elements` more.
fn square(properties: &str, rows: &str, elements: &str, body: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\n{properties}{elements}end_header\n{rows}{body}"
    )
}

#[test]
fn rows_may_wrap_and_elements_come_in_any_order() {
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    let wrapped = square("", "0 0\n0 1 0 0 1\n\n1 0 0 1 0\n", face, "4 0 1\n2 3\n");
    assert_eq!(parse(wrapped.as_bytes()).unwrap().triangles().len(), 2);
    let first = "ply\nformat ascii 1.0\nelement face 1\nproperty uchar red\n\
        property list uchar uint16 vertex_index\nproperty list uchar float32 texcoord\n\
        element vertex 4\nproperty float32 z\nproperty list uchar int of\nproperty float64 y\n\
        property int8 x\nend_header\n7 3 0 1 2 2 .5 .5\n0 1 5 0 0\n0 0 0 1\n0 2 5 5 1 1\n0 0 1 0\n";
    let mesh = parse(first.as_bytes()).unwrap();
    assert_eq!(mesh.corners(0), [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    // An arrow, whose fan around its first corner is not what it covers.
    let arrow = square("", "-1 -1 0\n0 -0.5 0\n1 -1 0\n0 1 0\n", face, "4 0 1 2 3\n");
    let mesh = parse(arrow.as_bytes()).unwrap();
    let covers = |at: usize| {
        let [a, b, c] = mesh.corners(at);
        (b - a).cross(c - a).length() / 2.0
    };
    assert_eq!(covers(0) + covers(1), 1.5);
}

#[test]
fn strips_are_surfaces_and_nothing_else_is() {
    let strips = "element tristrips 2\nproperty list int int vertex_indices\n";
    let file = square("", SQUARE, strips, "8 0 1 3 -1 3 1 2 0\n2 0 1\n");
    let mesh = parse(file.as_bytes()).unwrap();
    assert_eq!(mesh.triangles(), [[0, 1, 3], [3, 1, 2], [1, 2, 0]]);
    for (elements, body, warned) in [
        ("element edge 1\nproperty int vertex1\nproperty int vertex2\n", "0 1\n", false),
        ("element face 0\nproperty list uchar int vertex_indices\n", "", false),
        ("element range_grid 1\nproperty list uchar int vertex_indices\n", "1 0\n", true),
        ("element material 1\nproperty int face\n", "3\n", false),
    ] {
        let mut warnings = Warnings::default();
        let file = square("", SQUARE, elements, body);
        let mesh = parse_with(file.as_bytes(), &mut warnings).unwrap();
        assert!(mesh.triangles().is_empty(), "{elements}");
        assert_eq!(!warnings.into_lines().is_empty(), warned, "{elements}");
    }
    for (strip, name) in [("3 0 1 4", "beyond"), ("3 0 1 -2", "negative")] {
        let file = square("", SQUARE, strips, &format!("{strip}\n0\n"));
        assert!(parse(file.as_bytes()).is_err(), "{name}");
    }
}

#[test]
fn alpha_of_vertices_is_opacity_and_said() {
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    for (kind, values, want) in [
        ("uchar", "51 51 51 7", Some(0.2)),
        ("ushort", "13107 13107 13107 7", Some(0.2)),
        ("float", "0.2 0.2 0.2 7", Some(0.2)),
        ("float", "51 51 51 nan", Some(0.2)),
        ("uchar", "255 255 255 0", None),
        ("float", "nan 1 1 0", None),
    ] {
        let values: Vec<&str> = values.split(' ').collect();
        let rows = SQUARE.lines().zip(values).map(|(row, alpha)| format!("{row} {alpha}\n"));
        let rows: String = rows.collect();
        let file = square(&format!("property {kind} alpha\n"), &rows, face, "3 0 1 2\n");
        let mut warnings = Warnings::default();
        let mesh = parse_with(file.as_bytes(), &mut warnings).unwrap();
        assert!((mesh.opacity(0, 0.3, 0.3) - want.unwrap_or(1.0)).abs() < 1e-6, "{kind} {rows}");
        assert_eq!(warnings.into_lines().len(), usize::from(want.is_some()), "{kind} {rows}");
    }
}

#[test]
fn truncated_files_are_refused() {
    let file = binary("little", |f, u| (f.to_le_bytes(), u.to_le_bytes()));
    for length in 0..file.len() {
        assert!(parse(&file[..length]).is_err(), "{length} of {} bytes", file.len());
    }
    for length in 0..TEXT.len() - 2 {
        assert!(parse(&TEXT.as_bytes()[..length]).is_err(), "{length}");
    }
}

#[test]
fn absurd_files_are_refused() {
    let replace = |from: &str, to: &str| parse(TEXT.replace(from, to).as_bytes());
    for (from, to) in [
        ("strange 1\nproperty list uchar float of", "strange 18446744073709551615"),
        ("vertex 4", "vertex 18446744073709551615"),
        ("vertex 4", "vertex 99999999999999999999999"),
        ("face 2", "face 4000000000"),
        ("strange 1\nproperty list uchar float of", "strange 1"),
        ("property double y", "property double w"),
        ("property double y", "property list uchar double y"),
        ("list uchar int vertex_indices", "int vertex_indices"),
        ("list uchar int vertex_indices", "list uchar int corners"),
        ("list uchar int", "list uchar float"),
        ("list uchar int", "list float int"),
        ("\n1 1 0 9", "\n1 nan 0 9"),
        ("\n1 1 0 9", "\n1 x 0 9"),
        ("\n3 2 1 0", "\n3 2 1 4"),
        ("\n3 2 1 0", "\n3 2 1 -1"),
        ("\n3 2 1 0", "\n3.5 2 1 0"),
        ("\n3 2 1 0", "\n-3 2 1 0"),
        ("element vertex 4", "element vortex 4"),
        ("format ascii", "format latin"),
        ("format ascii 1.0\n", ""),
        ("property float x", "property quad x"),
        ("comment c", "element"),
        ("ply\n", "plyx\n"),
    ] {
        assert!(TEXT.contains(from), "{from}");
        let error = replace(from, to).unwrap_err();
        assert!(!error.to_string().contains('\n'), "{error}");
    }
    let error = replace("face 2", "face 4000000000").unwrap_err().to_string();
    assert!(error.contains("4000000000 of them do not fit"), "{error}");
    let mut file = binary("little", |f, u| (f.to_le_bytes(), u.to_le_bytes()));
    let list = file.len() - 16;
    file[list..list + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(parse(&file).is_err());
    assert!(replace("\n3 2 1 0", "\n0").unwrap().triangles().len() == 2);
}
