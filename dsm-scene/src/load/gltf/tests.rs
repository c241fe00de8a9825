use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;

use super::parse as parse_with;
use crate::error::Result;
use crate::load::library::Library;
use crate::load::warnings::Warnings;
use crate::mesh::TriangleMesh;

/// A triangle in a file: three positions, three indices as bytes, and
/// whatever else a test wants to say.
fn file(material: &str, images: &str, nodes: &str, primitive: &str) -> String {
    let mut bytes = Vec::new();
    for value in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0, 1, 2, 0]);
    for value in [0.0_f32, 0.0, 1.0, 0.0, 0.0, 1.0] {
        bytes.extend(value.to_le_bytes());
    }
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{nodes}], "meshes": [{{"primitives": [{{"attributes":
        {{"POSITION": 0, "TEXCOORD_0": 2}}, "indices": 1, "material": 0 {primitive}}}]}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [1, 1, 1, 0.5]
        {material}}}], {images}
        "buffers": [{{"byteLength": 64, "uri": "data:application/octet-stream;base64,{}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}},
        {{"buffer": 0, "byteOffset": 36, "byteLength": 4}},
        {{"buffer": 0, "byteOffset": 40, "byteLength": 24}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0]}},
        {{"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}},
        {{"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"}}]}}"#,
        STANDARD.encode(bytes)
    )
}

fn parse(bytes: &[u8], folder: &Path) -> Result<TriangleMesh> {
    let path = folder.join("test.gltf");
    parse_with(bytes, &path, None, &Library::default(), &mut Warnings::default())
}

fn parse_text(text: &str) -> Result<TriangleMesh> {
    parse(text.as_bytes(), Path::new("/nowhere"))
}

const BLEND: &str = r#"}, "alphaMode": "BLEND""#;
const NODE: &str = r#"{"mesh": 0}"#;
const TEXTURED: &str = r#", "baseColorTexture": {"index": 0}}, "alphaMode": "MASK""#;
const IMAGES: &str = r#""textures": [{"source": 0}], "images": [{"uri": "no%20leaf.png"}],"#;

#[test]
fn nodes_are_placed() {
    let nodes = r#"{"children": [1, 2], "translation": [1, 0, 0]},
        {"mesh": 0, "scale": [2, 3, 1]}, {"mesh": 0, "rotation": [0, 0, 1, 0]}"#;
    let mesh = parse_text(&file(BLEND, "", nodes, "")).unwrap();
    assert_eq!(mesh.corners(0), [Vec3::X, Vec3::X * 3.0, Vec3::new(1.0, 3.0, 0.0)]);
    let turned = mesh.corners(1)[1];
    assert!((turned - Vec3::ZERO).length() < 1e-6, "{turned}");
    assert_eq!(mesh.opacity(1, 0.2, 0.2), 0.5);
    let opaque = parse_text(&file("}", "", nodes, "")).unwrap();
    assert!(opaque.alphas().is_empty());
}

#[test]
fn an_image_is_missed_only_where_alpha_needs_it() {
    let needed = file(TEXTURED, IMAGES, NODE, "");
    let error = parse_text(&needed).unwrap_err();
    assert!(error.to_string().contains("no leaf.png: cannot open"), "{error}");
    assert!(parse_text(&needed.replace("MASK", "OPAQUE")).is_ok());
    // Half of the texture is opaque, and the cutoff is applied after.
    let folder = tempfile::tempdir().unwrap();
    let image = std::fs::File::create(folder.path().join("no leaf.png")).unwrap();
    let mut encoder = png::Encoder::new(image, 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[0, 0, 0, 255, 0, 0, 0, 150]).unwrap();
    writer.finish().unwrap();
    let sampler = r#""samplers": [{"magFilter": 9728}], "textures": [{"sampler": 0, "#;
    let cut = needed.replace(r#""textures": [{"#, sampler);
    let mesh = parse(cut.as_bytes(), folder.path()).unwrap();
    let opacities = [0.1, 0.9].map(|u| mesh.opacity(0, u, 0.05));
    assert_eq!(opacities, [1.0, 0.0]);
    let mesh = parse(cut.replace("MASK", "BLEND").as_bytes(), folder.path()).unwrap();
    assert_eq!(mesh.opacity(0, 0.1, 0.05), 0.5);
}

#[test]
fn broken_files_are_refused() {
    let whole = file(BLEND, "", NODE, "");
    assert!(parse_text(&whole).is_ok());
    for (from, to) in [
        (r#""byteLength": 36"#, r#""byteLength": 35"#),
        (r#""byteLength": 36"#, r#""byteLength": 18446744073709551615"#),
        (r#""byteOffset": 36"#, r#""byteOffset": 18446744073709551615"#),
        (r#""byteLength": 64"#, r#""byteLength": 65"#),
        (r#""count": 3, "type": "VEC3""#, r#""count": 4, "type": "VEC3""#),
        (r#""count": 3, "type": "VEC3""#, r#""count": 2, "type": "VEC3""#),
        (r#""count": 3, "type": "VEC3""#, r#""count": 1152921504606846976, "type": "VEC3""#),
        (r#""type": "VEC3""#, r#""type": "VEC2""#),
        (
            r#""componentType": 5126, "count": 3, "type": "VEC3""#,
            r#""componentType": 5125, "count": 3, "type": "VEC3""#,
        ),
        (r#""componentType": 5121"#, r#""componentType": 5126"#),
        (
            r#"{"bufferView": 0, "componentType": 5126, "count": 3"#,
            r#"{"componentType": 5126, "count": 1152921504606846976"#,
        ),
        (r#"{"mesh": 0}"#, r#"{"mesh": 0, "children": [0]}"#),
        (r#"{"mesh": 0}"#, r#"{"children": [1, 1]}, {"mesh": 0}"#),
        (r#"{"mesh": 0}"#, r#"{"mesh": 7}"#),
        (r#""POSITION": 0"#, r#""POSITION": 3"#),
        (r#""indices": 1"#, r#""indices": 3"#),
        (r#"{"mesh": 0}"#, r#"{"mesh": 0, "scale": [1e300, 1, 1]}"#),
        ("octet-stream;base64,", "octet-stream;base64,!"),
        ("data:application/octet-stream;base64,", "http://example.org/"),
        (r#""uri": "data"#, r#""name": "data"#),
    ] {
        assert!(whole.contains(from), "{from}");
        assert!(parse_text(&whole.replace(from, to)).is_err(), "{to}");
    }
    for length in (0..whole.len()).step_by(7) {
        assert!(parse_text(&whole[..length]).is_err(), "{length} bytes");
    }
    for stated in [0, 11, 12, 19, 20, 21, u32::MAX] {
        let header = [b"glTF\x02\0\0\0".as_slice(), &u32::to_le_bytes(stated)].concat();
        let glb = [header, vec![0; 8]].concat();
        assert!(parse(&glb, Path::new("")).is_err(), "{stated}");
    }
}

#[test]
fn strips_and_fans_are_triangles_and_lines_are_not() {
    let of_mode = |mode: u32| {
        let primitive = format!(r#", "mode": {mode}"#);
        parse_text(&file(BLEND, "", NODE, &primitive)).unwrap().triangles().len()
    };
    assert_eq!([0, 1, 4, 5, 6].map(of_mode), [0, 0, 1, 1, 1]);
}

#[test]
fn sparse_elements_take_their_places() {
    let text = file(BLEND, "", NODE, "").replace(
        r#"{"bufferView": 1, "componentType": 5121, "count": 3"#,
        r#"{"bufferView": 1, "componentType": 5121, "sparse": {"count": 1, "indices":
        {"bufferView": 1, "byteOffset": 1, "componentType": 5121},
        "values": {"bufferView": 1, "byteOffset": 2}}, "count": 3"#,
    );
    assert_eq!(parse_text(&text).unwrap().triangles(), [[0, 2, 2]]);
    let beyond =
        text.replace(r#""byteOffset": 1, "componentType""#, r#""byteOffset": 4, "componentType""#);
    assert!(parse_text(&beyond).is_err());
}
