//! glTF 2.0 and GLB.

mod buffers;
mod material;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, Mat4, Vec2};
use gltf::mesh::Mode;
use gltf::{Document, Node, Primitive, Semantic};

use self::buffers::{Buffers, unsigned};
use self::material::{Images, uv_set};
use super::{MAX_PRIMITIVES, extension, read_file};
use crate::alpha::Alpha;
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;

pub(super) fn load(path: &Path) -> Result<TriangleMesh> {
    let bytes = read_file(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    if extension(path).as_deref() == Some("glb") && !bytes.starts_with(b"glTF") {
        return Err(Error::malformed(Place::Header, "not a GLB file: must begin with glTF"));
    }
    parse(&bytes, folder)
}

fn parse(bytes: &[u8], folder: &Path) -> Result<TriangleMesh> {
    if bytes.starts_with(b"glTF") {
        // The parser subtracts the header's length from what the file states.
        let stated = bytes.get(8..12).map_or(0, unsigned);
        if stated < 20 || u64::from(stated) > bytes.len() as u64 {
            let reason = format!("truncated: {} of {stated} bytes", bytes.len());
            return Err(Error::malformed(Place::Header, reason));
        }
    }
    let broken = |error: gltf::Error| Error::malformed(Place::Whole, error.to_string());
    let loaded = gltf::Gltf::from_slice_without_validation(bytes).map_err(broken)?;
    let json = loaded.document.into_json();
    // The validation follows these indices before it checks them.
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut accessors = primitives.flat_map(|primitive| primitive.attributes.values());
    if let Some(index) = accessors.find(|index| index.value() >= json.accessors.len()) {
        let reason = format!("no accessor {index}");
        return Err(Error::malformed(Place::Whole, reason));
    }
    let gltf = Document::from_json(json).map_err(broken)?;
    let buffers = Buffers::load(&gltf, loaded.blob.as_deref(), folder)?;
    let images = Images { document: &gltf, buffers: &buffers, folder };
    let mut mesh = Collected::default();
    let mut seen = vec![false; gltf.nodes().len()];
    let roots = gltf.default_scene().or_else(|| gltf.scenes().next());
    let mut open: Vec<(Node<'_>, DMat4)> = match roots {
        Some(scene) => scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect(),
        None => Vec::new(),
    };
    open.reverse();
    while let Some((node, parent)) = open.pop() {
        let place = || Place::Named(format!("node {}", node.index()));
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(Error::malformed(place(), "occurs twice in the tree"));
        }
        let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4();
        if let Some(shape) = node.mesh() {
            for primitive in shape.primitives() {
                mesh.add(&primitive, &world, &images).map_err(|error| {
                    let index = (shape.index(), primitive.index());
                    at_place(error, &format!("mesh {} primitive {}", index.0, index.1))
                })?;
            }
        }
        let children: Vec<_> = node.children().map(|child| (child, world)).collect();
        open.extend(children.into_iter().rev());
    }
    if !mesh.has_uvs {
        mesh.uvs.clear();
    }
    TriangleMesh::new(mesh.positions, mesh.triangles)?
        .with_uvs(mesh.uvs)?
        .with_alphas(mesh.alphas, mesh.triangle_alphas)
}

/// The error with its place in front.
fn at_place(error: Error, place: &str) -> Error {
    match error {
        Error::Malformed { place: Place::Whole, reason } => {
            Error::Malformed { place: Place::Named(place.to_owned()), reason }
        }
        Error::Malformed { place: inner, reason } => {
            Error::Malformed { place: Place::Named(format!("{place}, {inner}")), reason }
        }
        error => error,
    }
}

/// The mesh so far.
#[derive(Default)]
struct Collected {
    positions: Vec<glam::Vec3>,
    uvs: Vec<Vec2>,
    has_uvs: bool,
    triangles: Vec<[u32; 3]>,
    triangle_alphas: Vec<u32>,
    alphas: Vec<Alpha>,
    /// Index into `alphas` by material.
    materials: HashMap<Option<usize>, u32>,
}

impl Collected {
    fn add(&mut self, primitive: &Primitive<'_>, world: &DMat4, images: &Images<'_>) -> Result<()> {
        let strip = match primitive.mode() {
            Mode::Triangles => None,
            Mode::TriangleStrip => Some(false),
            Mode::TriangleFan => Some(true),
            _ => return Ok(()),
        };
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        let first = self.positions.len();
        let positions = images.buffers.floats::<3>(&positions)?;
        let count = positions.len();
        check_count("vertices", first, count)?;
        self.positions.extend(positions.into_iter().map(|position| {
            world.transform_point3(glam::Vec3::from(position).as_dvec3()).as_vec3()
        }));

        let material = primitive.material();
        let alpha = match self.materials.get(&material.index()) {
            Some(&alpha) => alpha,
            None => {
                let alpha = images.alpha(&material)?;
                self.alphas.push(alpha);
                let index = self.alphas.len() as u32 - 1;
                self.materials.insert(material.index(), index);
                index
            }
        };
        let set = uv_set(&material);
        let uvs = primitive.get(&Semantic::TexCoords(set));
        let textured = self.alphas[alpha as usize].texture.is_some();
        if let Some(uvs) = uvs.filter(|_| textured) {
            let uvs = images.buffers.floats::<2>(&uvs)?;
            if uvs.len() != count {
                let reason = "texture coordinates must be one per vertex";
                return Err(Error::malformed(Place::Whole, reason));
            }
            self.uvs.extend(uvs.into_iter().map(Vec2::from));
            self.has_uvs = true;
        } else if textured {
            let reason = "its opacity texture needs texture coordinates";
            return Err(Error::malformed(Place::Whole, reason));
        }
        self.uvs.resize(self.positions.len(), Vec2::ZERO);

        let corners = match primitive.indices() {
            Some(indices) => images.buffers.indices(&indices)?,
            None => (0..count as u32).collect(),
        };
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            let reason = format!("vertex {corner} is out of range: there are {count}");
            return Err(Error::malformed(Place::Whole, reason));
        }
        check_count("triangles", self.triangles.len(), corners.len())?;
        let moved = |t: [u32; 3]| t.map(|corner| corner + first as u32);
        match strip {
            None => self.triangles.extend(corners.as_chunks::<3>().0.iter().map(|&t| moved(t))),
            Some(false) => {
                self.triangles.extend(corners.windows(3).map(|t| moved([t[0], t[1], t[2]])))
            }
            Some(true) => self
                .triangles
                .extend(corners.windows(2).skip(1).map(|t| moved([corners[0], t[0], t[1]]))),
        }
        self.triangle_alphas.resize(self.triangles.len(), alpha);
        Ok(())
    }
}

fn check_count(what: &'static str, before: usize, more: usize) -> Result<()> {
    let count = before as u64 + more as u64;
    if count > MAX_PRIMITIVES {
        return Err(Error::TooLarge { what, count, limit: MAX_PRIMITIVES });
    }
    Ok(())
}
