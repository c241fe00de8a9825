//! Stanford PLY.

use std::io::Cursor;
use std::path::Path;

use glam::{Vec2, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    BeginList, ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType,
};

use super::read_file;
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;

pub(super) fn load(path: &Path) -> Result<TriangleMesh> {
    parse(&read_file(path)?)
}

#[derive(Debug, Default)]
struct Vertex {
    position: Vec3,
    uv: Vec2,
}

impl Vertex {
    fn set(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "u" | "s" | "texture_u" => self.uv.x = value,
            // v goes up in PLY.
            "v" | "t" | "texture_v" => self.uv.y = 1.0 - value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        self.set(name, value)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match property.to_f32_lossy() {
            Some(value) => self.set(name, value),
            None => PropertyAccessResult::Ignored,
        }
    }
}

/// The corners of a polygon.
#[derive(Debug, Default)]
struct Face {
    signed: Vec<i32>,
    unsigned: Vec<u32>,
}

fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn begin_list_int(&mut self, name: &str, _: usize) -> BeginList<'_, i32> {
        if is_corners(name) { BeginList::Fill(&mut self.signed) } else { BeginList::UseSetter }
    }

    fn begin_list_uint(&mut self, name: &str, _: usize) -> BeginList<'_, u32> {
        if is_corners(name) { BeginList::Fill(&mut self.unsigned) } else { BeginList::UseSetter }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_corners(name) {
            return PropertyAccessResult::Ignored;
        }
        self.signed = match property {
            Property::ListChar(list) => list.into_iter().map(i32::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i32::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i32::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i32::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that no mesh needs.
#[derive(Debug)]
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}

fn parse(bytes: &[u8]) -> Result<TriangleMesh> {
    let in_header = |error: ply_rs_bw::parser::ParseError| {
        Error::malformed(Place::Header, one_line(&error.to_string()))
    };
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Ignored>::new().read_header(&mut reader).map_err(in_header)?;
    let (mut vertices, mut faces) = (None, Vec::new());
    for (name, element) in &header.elements {
        check_element(element, bytes.len() as u64 - reader.get_ref().position())?;
        let broken = |error: ply_rs_bw::parser::ParseError| {
            let place = Place::Named(format!("element {name}"));
            Error::malformed(place, one_line(&error.to_string()))
        };
        match name.as_str() {
            "vertex" => {
                let parser = Parser::<Vertex>::new();
                let read = parser.read_payload_for_element(&mut reader, element, &header);
                vertices = Some(read.map_err(broken)?);
            }
            "face" => {
                let parser = Parser::<Face>::new();
                let read = parser.read_payload_for_element(&mut reader, element, &header);
                faces = read.map_err(broken)?;
            }
            _ => {
                let parser = Parser::<Ignored>::new();
                let read = parser.read_payload_for_element(&mut reader, element, &header);
                read.map_err(broken)?;
            }
        }
    }
    let Some(vertices) = vertices else {
        return Err(Error::malformed(Place::Header, "no element vertex"));
    };
    let properties = &header.elements["vertex"].properties;
    let has = |names: &[&str]| names.iter().any(|&name| properties.contains_key(name));
    if let Some(missing) = ["x", "y", "z"].into_iter().find(|&name| !has(&[name])) {
        let reason = format!("vertices have no property {missing}");
        return Err(Error::malformed(Place::Header, reason));
    }
    let has_uvs = has(&["u", "s", "texture_u"]) && has(&["v", "t", "texture_v"]);
    let positions = vertices.iter().map(|vertex| vertex.position).collect();
    let uvs = if has_uvs { vertices.iter().map(|vertex| vertex.uv).collect() } else { Vec::new() };
    let mut triangles = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        if let Some(negative) = face.signed.iter().find(|&&corner| corner < 0) {
            let reason = format!("vertex {negative} is out of range");
            return Err(Error::malformed(Place::Face(index as u64), reason));
        }
        let signed = face.signed.iter().map(|&corner| corner as u32);
        let corners: Vec<u32> = signed.chain(face.unsigned.iter().copied()).collect();
        let beyond = |corner: &&u32| **corner as usize >= vertices.len();
        if let Some(corner) = corners.iter().find(beyond) {
            let reason = format!("vertex {corner} is out of range: there are {}", vertices.len());
            return Err(Error::malformed(Place::Face(index as u64), reason));
        }
        triangles.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
    }
    TriangleMesh::new(positions, triangles)?.with_uvs(uvs)
}

/// Refuses elements that are more than the bytes that are `left` can hold, or
/// that take none: those would never end.
fn check_element(element: &ElementDef, left: u64) -> Result<()> {
    let place = || Place::Named(format!("element {}", element.name));
    if element.properties.is_empty() {
        return Err(Error::malformed(place(), "it has no properties"));
    }
    // Every property takes a byte at least: a list its length.
    let smallest = element.properties.len() as u64;
    if (element.count as u64).saturating_mul(smallest) > left {
        let reason = format!("{} of them do not fit into {left} bytes", element.count);
        return Err(Error::malformed(place(), reason));
    }
    let corners = element.properties.values().filter(|property| is_corners(&property.name));
    for property in corners {
        if element.name == "face" && matches!(property.data_type, PropertyType::Scalar(_)) {
            return Err(Error::malformed(place(), format!("{} is not a list", property.name)));
        }
    }
    Ok(())
}

/// The parser's messages quote lines of the file.
fn one_line(message: &str) -> String {
    let words: Vec<&str> = message.split_whitespace().collect();
    let mut line = words.join(" ");
    if let Some((end, _)) = line.char_indices().nth(200) {
        line.truncate(end);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mesh = parse(TEXT.as_bytes()).unwrap();
        assert_eq!((mesh.positions().len(), mesh.triangles().len()), (4, 3));
        assert_eq!(
            mesh.corners(1),
            [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 2.0)]
        );
        let little = binary("little", |f, u| (f.to_le_bytes(), u.to_le_bytes()));
        let big = binary("big", |f, u| (f.to_be_bytes(), u.to_be_bytes()));
        for file in [little, big] {
            let mesh = parse(&file).unwrap();
            assert_eq!(mesh.corners(0), [Vec3::ZERO, Vec3::new(0.0, 1.0, 2.0), Vec3::X]);
            assert_eq!(mesh.uvs()[0], Vec2::new(0.25, 0.0));
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
            ("list uchar int vertex_indices", "int vertex_indices"),
            ("list uchar int", "list uchar float"),
            ("\n1 1 0 9", "\n1 nan 0 9"),
            ("\n3 2 1 0", "\n3 2 1 4"),
            ("\n3 2 1 0", "\n3 2 1 -1"),
            ("element vertex 4", "element vortex 4"),
        ] {
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
}
