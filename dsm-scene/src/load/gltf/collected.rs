//! The one mesh that a file's primitives become.

use std::collections::HashMap;

use glam::{DMat4, DVec3, Vec2, Vec3};

use super::malformed;
use super::material::{Materials, Opacity};
use super::skin::Skin;
use super::vertices::Vertices;
use crate::alpha::{Alpha, AlphaMode};
use crate::error::{Error, Result};
use crate::load::MAX_PRIMITIVES;
use crate::load::warnings::Warnings;
use crate::mesh::TriangleMesh;

/// Copies of one vertex or triangle for each byte of a file, on top of a million: no
/// small file fills the memory.
const COPIES_PER_BYTE: u64 = 1024;

/// Of a position, a uv and an alpha, and of three corners and a material.
const VERTEX_BYTES: usize = 12 + 8 + 4;
const TRIANGLE_BYTES: usize = 12 + 4;

/// Where a primitive stands.
pub(super) struct Placement<'a> {
    /// The skin, which is in the world already.
    pub(super) skin: Option<&'a Skin>,
    /// Mesh to world, one for each copy.
    pub(super) instances: &'a [DMat4],
}

/// The mesh so far.
pub(super) struct Collected<'a> {
    materials: Materials<'a>,
    most: u64,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    has_uvs: bool,
    vertex_alphas: Vec<f32>,
    triangles: Vec<[u32; 3]>,
    triangle_alphas: Vec<u32>,
    alphas: Vec<Alpha>,
    /// Index into `alphas` and set of uvs by material.
    known: HashMap<Option<usize>, (u32, usize)>,
}

impl<'a> Collected<'a> {
    /// The mesh of a file of so many `bytes`.
    pub(super) fn new(materials: Materials<'a>, bytes: usize) -> Self {
        let most = (bytes as u64).saturating_mul(COPIES_PER_BYTE).saturating_add(1 << 20);
        Self {
            materials,
            most: most.min(MAX_PRIMITIVES),
            positions: Vec::new(),
            uvs: Vec::new(),
            has_uvs: false,
            vertex_alphas: Vec::new(),
            triangles: Vec::new(),
            triangle_alphas: Vec::new(),
            alphas: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// Adds the triangles of a primitive, a copy for each instance.
    pub(super) fn add(
        &mut self,
        vertices: &Vertices<'_>,
        placement: &Placement<'_>,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let primitive = vertices.primitive;
        let mode = primitive.mode.map_or(4, |mode| mode.0);
        match mode {
            0..=3 => return Ok(()),
            4..=6 => {}
            _ => return Err(malformed(format!("mode {mode} is not known"))),
        }
        if primitive.extensions.draco.is_some() && !self.has_positions(vertices) {
            return Err(malformed("Draco compression is not supported".to_owned()));
        }
        let Some(positions) = vertices.positions()? else { return Ok(()) };
        let count = positions.len();
        let (alpha, uv_set) = self.material(primitive.material.map(|at| at.0), warnings)?;
        let opacity = &self.alphas[alpha as usize];
        let is_textured = opacity.texture.is_some();
        let uvs = if is_textured { vertices.uvs(uv_set, count)? } else { None };
        if is_textured && uvs.is_none() {
            let reason = format!("its opacity texture needs TEXCOORD_{uv_set}");
            return Err(malformed(reason));
        }
        let alphas = match opacity.mode {
            AlphaMode::Opaque => None,
            _ => vertices.alphas(count)?,
        };
        let corners = triangles(mode, &vertices.indices(count)?);
        let skinned = match placement.skin {
            Some(skin) => skin.place(primitive, &positions, vertices.buffers)?,
            None => None,
        };
        let copies = if skinned.is_some() { 1 } else { placement.instances.len() };
        self.check_count("vertices", self.positions.len(), count, copies)?;
        self.check_count("triangles", self.triangles.len(), corners.len(), copies)?;
        let bytes = (self.positions.len() + count * copies) * VERTEX_BYTES
            + (self.triangles.len() + corners.len() * copies) * TRIANGLE_BYTES;
        self.materials.check_memory(bytes as u64)?;
        for copy in 0..copies {
            let first = self.positions.len() as u32;
            match &skinned {
                Some(places) => self.positions.extend(places.iter().map(|place| place.as_vec3())),
                None => {
                    let world = placement.instances[copy];
                    self.positions.extend(positions.iter().map(|position| {
                        let position = DVec3::from(position.map(f64::from));
                        world.transform_point3(position).as_vec3()
                    }));
                }
            }
            self.uvs.extend(uvs.iter().flatten());
            self.vertex_alphas.extend(alphas.iter().flatten());
            self.uvs.resize(self.positions.len(), Vec2::ZERO);
            self.vertex_alphas.resize(self.positions.len(), 1.0);
            self.triangles.extend(corners.iter().map(|t| t.map(|corner| corner + first)));
            self.triangle_alphas.resize(self.triangles.len(), alpha);
        }
        self.has_uvs |= uvs.is_some();
        Ok(())
    }

    /// True if positions are there beside what is compressed.
    fn has_positions(&self, vertices: &Vertices<'_>) -> bool {
        let accessors = &vertices.buffers.root.accessors;
        let with_bytes =
            |index: usize| accessors.get(index).is_some_and(|at| at.buffer_view.is_some());
        let primitive = vertices.primitive;
        let positions = primitive.attributes.get("POSITION").is_none_or(|at| with_bytes(at.0));
        positions && primitive.indices.is_none_or(|at| with_bytes(at.0))
    }

    /// The index of a material's opacity, and its set of uvs.
    fn material(
        &mut self,
        material: Option<usize>,
        warnings: &mut Warnings,
    ) -> Result<(u32, usize)> {
        if let Some(&known) = self.known.get(&material) {
            return Ok(known);
        }
        let Opacity { alpha, uv_set } = self.materials.opacity(material, warnings)?;
        let known = (self.alphas.len() as u32, uv_set);
        self.alphas.push(alpha);
        self.known.insert(material, known);
        Ok(known)
    }

    fn check_count(
        &self,
        what: &'static str,
        before: usize,
        more: usize,
        copies: usize,
    ) -> Result<()> {
        let more = (more as u64).saturating_mul(copies as u64);
        let count = (before as u64).saturating_add(more);
        if count > self.most {
            return Err(Error::TooLarge { what, count, limit: self.most });
        }
        Ok(())
    }

    pub(super) fn into_mesh(mut self) -> Result<TriangleMesh> {
        if !self.has_uvs {
            self.uvs.clear();
        }
        TriangleMesh::new(self.positions, self.triangles)?
            .with_uvs(self.uvs)?
            .with_vertex_alphas(self.vertex_alphas)?
            .with_alphas(self.alphas, self.triangle_alphas)
    }
}

/// The triangles of a mode: lists, strips or fans.
fn triangles(mode: usize, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        5 => corners.windows(3).map(|t| [t[0], t[1], t[2]]).collect(),
        6 => corners.windows(2).skip(1).map(|t| [corners[0], t[0], t[1]]).collect(),
        _ => corners.as_chunks::<3>().0.to_vec(),
    }
}
