//! Wavefront OBJ and MTL.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::io::{BufRead, Read};
use std::path::Path;

use glam::{Vec2, Vec3};
use tobj::{LoadOptions, Material};

use super::image::{Channel, decode};
use super::read_file;
use crate::alpha::{Alpha, AlphaMode};
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;

pub(super) fn load(path: &Path) -> Result<TriangleMesh> {
    parse(&read_file(path)?, path.parent().unwrap_or(Path::new("")))
}

fn parse(bytes: &[u8], folder: &Path) -> Result<TriangleMesh> {
    check_faces(bytes)?;
    let options = LoadOptions {
        triangulate: true,
        single_index: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let lines = Cell::new(0);
    let mut reader = CountLines { bytes, lines: &lines };
    // The callback can only answer with a kind of error: its cause waits here.
    let material_error = RefCell::new(None);
    let loaded = tobj::load_obj_buf(&mut reader, &options, |name| {
        let path = folder.join(name);
        Ok(load_materials(&path).unwrap_or_else(|error| {
            material_error.borrow_mut().get_or_insert(error.in_file(&path));
            Materials::default()
        }))
    });
    if let Some(error) = material_error.into_inner() {
        return Err(error);
    }
    let malformed =
        |error: tobj::LoadError| Error::malformed(Place::Line(lines.get()), error.to_string());
    let (models, materials) = loaded.map_err(malformed)?;
    let materials = materials.map_err(malformed)?;
    let mut alphas = vec![Alpha::default()];
    for material in &materials {
        alphas.push(material_alpha(material, folder)?);
    }

    let (mut positions, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let mut triangle_alphas = Vec::new();
    for model in models {
        let mesh = model.mesh;
        let first = u32::try_from(positions.len()).unwrap_or(u32::MAX);
        positions.extend(mesh.positions.as_chunks::<3>().0.iter().map(|&at| Vec3::from(at)));
        if mesh.texcoords.len() / 2 == mesh.positions.len() / 3 {
            uvs.resize(first as usize, Vec2::ZERO);
            // v goes up in OBJ.
            uvs.extend(
                mesh.texcoords.as_chunks::<2>().0.iter().map(|&[u, v]| Vec2::new(u, 1.0 - v)),
            );
        }
        let corners = mesh.indices.as_chunks::<3>().0;
        triangles.extend(corners.iter().map(|t| t.map(|corner| corner.saturating_add(first))));
        let alpha = mesh.material_id.map_or(0, |material| material as u32 + 1);
        triangle_alphas.resize(triangles.len(), alpha);
    }
    if !uvs.is_empty() {
        uvs.resize(positions.len(), Vec2::ZERO);
    }
    TriangleMesh::new(positions, triangles)?.with_uvs(uvs)?.with_alphas(alphas, triangle_alphas)
}

/// Counts the lines that went through.
struct CountLines<'a> {
    bytes: &'a [u8],
    lines: &'a Cell<u64>,
}

impl Read for CountLines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.bytes.read(buffer)
    }
}

impl BufRead for CountLines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        // One line at a time, so that what follows isn't counted.
        let end = self.bytes.iter().position(|&byte| byte == b'\n');
        Ok(&self.bytes[..end.map_or(self.bytes.len(), |end| end + 1)])
    }

    fn consume(&mut self, amount: usize) {
        self.bytes = &self.bytes[amount..];
        if amount > 0 {
            self.lines.set(self.lines.get() + 1);
        }
    }
}

/// Checks that every corner of a face names elements that came before or come
/// later: the parser checks positions, but computes with the others first.
fn check_faces(bytes: &[u8]) -> Result<()> {
    let lines = || bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii_start);
    let starts = |line: &[u8], word: &[u8]| {
        line.strip_prefix(word)
            .is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_whitespace))
    };
    let kinds: [&[u8]; 3] = [b"v", b"vt", b"vn"];
    let mut totals = [0_i64; 3];
    for line in lines() {
        for (total, kind) in totals.iter_mut().zip(kinds) {
            *total += i64::from(starts(line, kind));
        }
    }
    let mut counts = [0_i64; 3];
    for (number, line) in (1..).zip(lines()) {
        for (count, kind) in counts.iter_mut().zip(kinds) {
            *count += i64::from(starts(line, kind));
        }
        if !starts(line, b"f") && !starts(line, b"l") {
            continue;
        }
        let refuse = |reason: String| Err(Error::malformed(Place::Line(number), reason));
        for corner in line[1..].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
            for (kind, index) in corner.split(|&byte| byte == b'/').enumerate() {
                if index.is_empty() {
                    continue;
                }
                let text = String::from_utf8_lossy(index);
                let (Some(total), Ok(value)) = (totals.get(kind), text.parse::<i64>()) else {
                    return refuse(format!(
                        "`{}` is not a corner",
                        String::from_utf8_lossy(corner)
                    ));
                };
                let found = if value < 0 { counts[kind].saturating_add(value) } else { value - 1 };
                if found < 0 || found >= *total {
                    let what = ["vertices", "texture coordinates", "normals"][kind];
                    return refuse(format!(
                        "index {value} is out of range: there are {total} {what}"
                    ));
                }
            }
        }
    }
    Ok(())
}

/// Materials, and which has which name.
type Materials = (Vec<Material>, HashMap<String, usize>);

/// The materials of an MTL file; none if there is no such file.
fn load_materials(path: &Path) -> Result<Materials> {
    if !path.exists() {
        return Ok(Materials::default());
    }
    let bytes = read_file(path)?;
    // Opacity alone: the parser stops the program at colours of less than
    // three numbers.
    let wanted = |line: &&[u8]| {
        let word = line.trim_ascii_start().split(u8::is_ascii_whitespace).next();
        word.is_some_and(|word| [b"newmtl".as_slice(), b"d", b"Tr", b"map_d"].contains(&word))
    };
    let lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').filter(wanted).collect();
    let lines = lines.join(&b'\n');
    tobj::load_mtl_buf(&mut lines.as_slice())
        .map_err(|error| Error::malformed(Place::Whole, error.to_string()))
}

fn material_alpha(material: &Material, folder: &Path) -> Result<Alpha> {
    let place = || Place::Named(format!("material {}", material.name));
    let transparency = match material.unknown_param.get("Tr").map(|text| text.parse::<f32>()) {
        Some(Ok(value)) => value,
        Some(Err(_)) => return Err(Error::malformed(place(), "Tr is not a number")),
        None => 0.0,
    };
    let factor = material.dissolve.unwrap_or(1.0 - transparency);
    if !(0.0..=1.0).contains(&factor) {
        return Err(Error::malformed(place(), format!("opacity {factor} is not in [0, 1]")));
    }
    let texture = match &material.dissolve_texture {
        None => None,
        Some(name) => {
            // Options come before the name.
            let name = if name.starts_with('-') {
                name.split_whitespace().next_back().unwrap_or(name)
            } else {
                name
            };
            let path = folder.join(name.replace('\\', "/"));
            let bytes = read_file(&path).map_err(|error| error.in_file(&path))?;
            decode(&bytes, Channel::AlphaOrBrightness).map_err(|error| error.in_file(&path))?
        }
    };
    Ok(Alpha { mode: AlphaMode::Blend, factor, texture })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Result<TriangleMesh> {
        parse(text.as_bytes(), Path::new("/nowhere"))
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn polygons_become_fans() {
        let mesh = parse_text(&format!("{SQUARE}v 0.5 2 0\nf 1 2 3 4\nf 1 2 3 5 4\nl 1 2\n"));
        let mesh = mesh.unwrap();
        assert_eq!((mesh.positions().len(), mesh.triangles().len()), (5, 5));
        assert_eq!(mesh.corners(1), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        let relative = parse_text(&format!("{SQUARE}f -4 -3 -2\no b\nv 5 5 5\nf -1 -2 1\n"));
        assert_eq!(relative.unwrap().corners(1), [Vec3::splat(5.0), Vec3::Y, Vec3::ZERO]);
    }

    #[test]
    fn broken_faces_are_refused_with_their_line() {
        for face in [
            "f 1 2 5",
            "f 0 1 2",
            "f 1 2 -5",
            "f 1/1 2/1 3/1",
            "f 1//1 2//1 3//1",
            "f 1 2 x",
            "f 1/-9223372036854775807 2 3",
            "f 1 2 9223372036854775807",
            "f 1/1/1/1 2 3",
            "f 1 2 99999999999999999999",
        ] {
            let error = parse_text(&format!("{SQUARE}{face}\n")).unwrap_err();
            assert!(error.to_string().starts_with("line 5: "), "{face}: {error}");
        }
        let error = parse_text("v 0 0 0\nv 1 x 0\nv 1 1 1\n").unwrap_err();
        assert_eq!(error.to_string(), "line 2: position parse error");
        assert!(parse_text("v nan 0 0\nf 1 1 1\n").is_err());
        assert!(parse_text("v 1e39 0 0\nf 1 1 1\n").is_err());
        assert!(parse(b"v \xff\xfe 0\n", Path::new("")).is_err());
        assert!(parse_text("").unwrap().triangles().is_empty());
    }

    #[test]
    fn materials_dissolve() {
        let folder = tempfile::tempdir().unwrap();
        let library = "newmtl glass\nKd 1\nd 0.25\nnewmtl fog\nTr 0.25\nnewmtl wall\n";
        std::fs::write(folder.path().join("a b.mtl"), library).unwrap();
        let text = format!(
            "mtllib a b.mtl\n{SQUARE}usemtl glass\nf 1 2 3\nusemtl fog\nf 1 2 3\n\
             usemtl wall\nf 1 3 4\nusemtl unknown\nf 1 3 4\n"
        );
        let mesh = parse(text.as_bytes(), folder.path()).unwrap();
        let opacities: Vec<_> = (0..4).map(|index| mesh.opacity(index, 0.2, 0.2)).collect();
        assert_eq!(opacities, [0.25, 0.75, 1.0, 1.0]);
        // A missing library is no error, a missing image is.
        assert!(parse_text(&text).unwrap().alphas().is_empty());
        let library = "newmtl glass\nmap_d -clamp on leaf.png\n";
        std::fs::write(folder.path().join("a b.mtl"), library).unwrap();
        let error = parse(text.as_bytes(), folder.path()).unwrap_err();
        assert!(error.to_string().contains("leaf.png: cannot open"), "{error}");
        // The upper row of an image is where v is large.
        let image = std::fs::File::create(folder.path().join("leaf.png")).unwrap();
        let encoder = png::Encoder::new(image, 1, 2);
        encoder.write_header().unwrap().write_image_data(&[255, 51]).unwrap();
        let corners = "vt 0 0\nvt 0 0.5\nvt 0 1\nusemtl glass\nf 1/1 2/2 3/3\n";
        let text = format!("mtllib a b.mtl\n{SQUARE}{corners}");
        let mesh = parse(text.as_bytes(), folder.path()).unwrap();
        assert!((mesh.opacity(0, 0.5, 0.0) - 0.2).abs() < 1e-6);
        assert!(mesh.opacity(0, 0.5, 0.5) > 0.9);
        std::fs::write(folder.path().join("a b.mtl"), "newmtl glass\nd x\n").unwrap();
        let error = parse(text.as_bytes(), folder.path()).unwrap_err();
        assert!(error.to_string().contains("a b.mtl: "), "{error}");
    }
}
