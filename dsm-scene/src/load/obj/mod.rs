//! Wavefront OBJ.

mod material;
#[cfg(test)]
mod tests;
mod text;
mod texture;

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};

use self::material::Materials;
use self::text::{Lines, name, number, split_word, words};
use super::library::Library;
use super::polygon::PolygonCutter;
use super::read_file;
use super::warnings::Warnings;
use crate::alpha::Alpha;
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;

/// The index of no element.
const NONE: u32 = u32::MAX;

pub(super) fn load(
    path: &Path,
    library: &Library,
    warnings: &mut Warnings,
) -> Result<TriangleMesh> {
    parse(&read_file(path)?, path.parent().unwrap_or(Path::new("")), library, warnings)
}

fn parse(
    bytes: &[u8],
    folder: &Path,
    library: &Library,
    warnings: &mut Warnings,
) -> Result<TriangleMesh> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(Error::malformed(Place::Header, "text in UTF-16: save it as UTF-8"));
    }
    let file = File::read(bytes, folder, warnings)?;
    let alphas = file.alphas(library, warnings)?;
    file.into_mesh(alphas, warnings)
}

/// What a file says, in its order.
#[derive(Default)]
struct File {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    /// Index of the position and of the uv of every corner.
    corners: Vec<[u32; 2]>,
    /// Where a face's corners end, and its name in `names`.
    faces: Vec<(usize, u32)>,
    names: Vec<String>,
    /// The largest index of a position that was not there yet, and its line.
    ahead: Option<(u32, u64)>,
    materials: Materials,
    /// Libraries that are missing.
    missing: Vec<String>,
}

impl File {
    fn read(bytes: &[u8], folder: &Path, warnings: &mut Warnings) -> Result<Self> {
        let mut file = Self { names: vec![String::new()], ..Self::default() };
        let mut by_name = HashMap::from([(String::new(), 0)]);
        let mut material = 0;
        for (line, text) in Lines::new(bytes) {
            let (word, rest) = split_word(&text);
            let malformed = |reason| Error::malformed(Place::Line(line), reason);
            match word {
                b"v" => {
                    let position = numbers::<3>(rest, 3)
                        .ok_or_else(|| malformed("a vertex is three numbers".to_owned()))?;
                    file.positions.push(Vec3::from(position));
                }
                b"vt" => {
                    let uv = numbers::<2>(rest, 1).ok_or_else(|| {
                        malformed("a texture coordinate is one to three numbers".to_owned())
                    })?;
                    // v goes up in OBJ.
                    file.uvs.push(Vec2::new(uv[0], 1.0 - uv[1]));
                }
                // The second is the old name of the first.
                b"f" | b"fo" => {
                    for word in words(rest) {
                        let corner = file.corner(word, line).map_err(malformed)?;
                        file.corners.push(corner);
                    }
                    file.faces.push((file.corners.len(), material));
                }
                b"usemtl" => {
                    let name = name(rest);
                    let next = file.names.len() as u32;
                    material = *by_name.entry(name.clone()).or_insert(next);
                    if material == next {
                        file.names.push(name);
                    }
                }
                b"mtllib" => file.add_libraries(rest, folder, warnings)?,
                b"surf" => warnings.add("free-form surfaces (surf) are left out"),
                b"call" => warnings.add("files that are read in by call are left out"),
                b"shadow_obj" => {
                    warnings.add("shadow_obj, another file to cast shadows, is left out")
                }
                _ => {}
            }
        }
        if let Some((index, line)) = file.ahead
            && index as usize >= file.positions.len()
        {
            let count = file.positions.len();
            let reason = format!(
                "index {} is out of range: there are {count} vertices",
                u64::from(index) + 1
            );
            return Err(Error::malformed(Place::Line(line), reason));
        }
        Ok(file)
    }

    /// The position and uv of `v`, `v/vt`, `v//vn` or `v/vt/vn`: from 1, or from −1
    /// backwards.
    fn corner(&mut self, word: &[u8], line: u64) -> std::result::Result<[u32; 2], String> {
        let text = String::from_utf8_lossy(word);
        let mut parts = text.split('/');
        let mut index = |count: usize| match parts.next() {
            None | Some("") => Ok(None),
            Some(part) => match part.parse::<i64>() {
                Ok(0) => Err("index 0 is out of range: they begin at 1".to_owned()),
                Ok(index) => Ok(Some(if index < 0 {
                    (count as i64).saturating_add(index)
                } else {
                    index - 1
                })),
                Err(_) => Err(format!("`{text}` is not a corner")),
            },
        };
        let position = index(self.positions.len())?;
        let uv = index(self.uvs.len())?;
        // Normals count for nothing, but have to be some.
        index(0)?;
        if parts.next().is_some() {
            return Err(format!("`{text}` is not a corner"));
        }
        let Some(position) = position else { return Err(format!("`{text}` is not a corner")) };
        let position = u32::try_from(position).ok().filter(|&index| index != NONE);
        let Some(position) = position else {
            let count = self.positions.len();
            return Err(format!("`{text}` is out of range: there are {count} vertices"));
        };
        if position as usize >= self.positions.len()
            && self.ahead.is_none_or(|(index, _)| index < position)
        {
            self.ahead = Some((position, line));
        }
        Ok([position, uv.and_then(|uv| u32::try_from(uv).ok()).unwrap_or(NONE)])
    }

    /// The libraries of a line: one whose name has spaces, or several.
    fn add_libraries(
        &mut self,
        names: &[u8],
        folder: &Path,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let whole = name(names);
        let parts: Vec<String> = match texture::find(folder, &whole).is_file() {
            true => vec![whole],
            false => words(names).map(name).collect(),
        };
        for part in parts {
            let path = texture::find(folder, &part);
            if path.is_file() {
                let added = self.materials.add_library(&path, warnings);
                added.map_err(|error| error.in_file(&path))?;
            } else {
                self.missing.push(part);
            }
        }
        Ok(())
    }

    /// The opacity of each name.
    fn alphas(&self, library: &Library, warnings: &mut Warnings) -> Result<Vec<Alpha>> {
        let mut alphas = Vec::new();
        let mut used = vec![false; self.names.len()];
        self.faces.iter().for_each(|&(_, material)| used[material as usize] = true);
        for (name, used) in self.names.iter().zip(used) {
            // What some programs write for none.
            let none = ["", "(null)", "None", "none", "default"].contains(&name.as_str());
            if !used {
                alphas.push(Alpha::default());
                continue;
            }
            let known = match self.materials.alpha(name, library, warnings)? {
                // A comment may follow, and a name may have a # in it.
                None => match name.split_once(" #") {
                    Some((name, _)) => self.materials.alpha(name.trim_end(), library, warnings)?,
                    None => None,
                },
                known => known,
            };
            if known.is_none() && !none {
                let missing = match self.missing.as_slice() {
                    [] => String::new(),
                    missing => format!(" ({} is missing)", missing.join(", ")),
                };
                warnings.add(format!("no material {name}{missing}: it is taken for opaque"));
            }
            alphas.push(known.unwrap_or_default());
        }
        Ok(alphas)
    }

    fn into_mesh(self, alphas: Vec<Alpha>, warnings: &mut Warnings) -> Result<TriangleMesh> {
        let textured = |material: u32| alphas[material as usize].texture.is_some();
        let splits = alphas.iter().any(|alpha| alpha.texture.is_some());
        let mut vertices = Vertices::default();
        let mut cutter = PolygonCutter::default();
        let (mut triangles, mut triangle_alphas) = (Vec::new(), Vec::new());
        let (mut begin, mut polygon, mut places) = (0, Vec::new(), Vec::new());
        for &(end, material) in &self.faces {
            let corners = &self.corners[begin..end];
            begin = end;
            polygon.clear();
            places.clear();
            for &[position, uv] in corners {
                places.push(self.positions[position as usize]);
                let uv = if textured(material) { uv } else { NONE };
                polygon.push(if splits { vertices.index(position, uv) } else { position });
            }
            let cut = cutter.cut(&places)?.iter();
            triangles.extend(cut.map(|triangle| triangle.map(|at| polygon[at as usize])));
            triangle_alphas.resize(triangles.len(), material);
            if textured(material) && corners.iter().any(|&[_, uv]| uv as usize >= self.uvs.len()) {
                warnings.add(
                    "faces without texture coordinates are as opaque as where their map_d is white",
                );
            }
        }
        if !splits {
            return TriangleMesh::new(self.positions, triangles)?
                .with_alphas(alphas, triangle_alphas);
        }
        let (mut positions, mut uvs) = (Vec::new(), Vec::new());
        for &(position, uv) in &vertices.pairs {
            positions.push(self.positions[position as usize]);
            // Textures are white there.
            uvs.push(self.uvs.get(uv as usize).copied().unwrap_or(Vec2::NAN));
        }
        TriangleMesh::new(positions, triangles)?.with_uvs(uvs)?.with_alphas(alphas, triangle_alphas)
    }
}

/// Vertices that are a position together with a uv.
#[derive(Default)]
struct Vertices {
    pairs: Vec<(u32, u32)>,
    indices: HashMap<(u32, u32), u32>,
}

impl Vertices {
    fn index(&mut self, position: u32, uv: u32) -> u32 {
        let next = self.pairs.len() as u32;
        let index = *self.indices.entry((position, uv)).or_insert(next);
        if index == next {
            self.pairs.push((position, uv));
        }
        index
    }
}

/// The first `N` numbers of a line, of which `needed` have to be there; 0 for others.
fn numbers<const N: usize>(line: &[u8], needed: usize) -> Option<[f32; N]> {
    let mut found = [0.0; N];
    let mut words = words(line);
    for (at, value) in found.iter_mut().enumerate() {
        match words.next() {
            Some(word) => *value = number(word)?,
            None if at < needed => return None,
            None => break,
        }
    }
    Some(found)
}
