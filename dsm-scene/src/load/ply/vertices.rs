//! The vertices of a PLY file.

use glam::{Vec2, Vec3};

use super::header::{Element, Property};
use super::rows;
use super::values::{Kind, Values};
use crate::error::{Error, Place, Result};
use crate::load::warnings::Warnings;
use crate::mesh::TriangleMesh;

#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    /// Empty if vertices have none, as are the alphas.
    uvs: Vec<Vec2>,
    alphas: Vec<f64>,
    /// The alpha that is opaque, if its kind says so.
    opaque: Option<f64>,
}

impl Vertices {
    pub(super) fn read(element: &Element, values: &mut Values<'_>) -> Result<Self> {
        let find = |names: &[&str]| {
            let named = |property: &Property| names.contains(&property.name.as_str());
            let found = element.properties.iter().position(named);
            found.filter(|&index| element.properties[index].length.is_none())
        };
        let [x, y, z] = ["x", "y", "z"].map(|name| {
            let missing = || format!("vertices have no property {name}");
            find(&[name]).ok_or_else(|| Error::malformed(Place::Header, missing()))
        });
        let position = [x?, y?, z?];
        let uv = find(&["u", "s", "texture_u"]).zip(find(&["v", "t", "texture_v"]));
        let alpha = find(&["alpha"]);
        let mut vertices = Self::default();
        rows(element, values, None, |numbers, _| {
            vertices.positions.push(Vec3::from(position.map(|index| numbers[index] as f32)));
            if let Some((u, v)) = uv {
                // v goes up in PLY.
                vertices.uvs.push(Vec2::new(numbers[u] as f32, 1.0 - numbers[v] as f32));
            }
            vertices.alphas.extend(alpha.map(|index| numbers[index]));
        })?;
        vertices.opaque = alpha.and_then(|index| match element.properties[index].kind {
            Kind::F32 | Kind::F64 => None,
            Kind::U16 | Kind::I16 => Some(65535.0),
            _ => Some(255.0),
        });
        Ok(vertices)
    }

    /// The corners as indices of vertices that there are; `face` is theirs.
    pub(super) fn corners(&self, corners: &[i64], face: u64) -> Result<Vec<u32>> {
        let corner = |&corner: &i64| {
            let index = u32::try_from(corner).ok();
            index.filter(|&index| (index as usize) < self.positions.len()).ok_or_else(|| {
                let count = self.positions.len();
                let reason = format!("vertex {corner} is out of range: there are {count}");
                Error::malformed(Place::Face(face), reason)
            })
        };
        corners.iter().map(corner).collect()
    }

    pub(super) fn into_mesh(
        self,
        triangles: Vec<[u32; 3]>,
        warnings: &mut Warnings,
    ) -> Result<TriangleMesh> {
        let alphas = self.opacities(&triangles, warnings);
        TriangleMesh::new(self.positions, triangles)?.with_uvs(self.uvs)?.with_vertex_alphas(alphas)
    }

    /// The opacity of each vertex; 1 for those that no triangle uses.
    fn opacities(&self, triangles: &[[u32; 3]], warnings: &mut Warnings) -> Vec<f32> {
        if self.alphas.is_empty() {
            return Vec::new();
        }
        let used = || triangles.iter().flatten().map(|&corner| corner as usize);
        let largest = used().map(|corner| self.alphas[corner]).fold(0.0, f64::max);
        // Some programs write floats as if they were bytes.
        let opaque = self.opaque.unwrap_or(if largest > 1.0 { 255.0 } else { 1.0 });
        let mut opacities = vec![1.0_f32; self.alphas.len()];
        let (mut low, mut high) = (f32::INFINITY, 0.0_f32);
        for corner in used() {
            // One that is not a number is opaque.
            let opacity = (self.alphas[corner] / opaque).clamp(0.0, 1.0) as f32;
            let opacity = if opacity.is_nan() { 1.0 } else { opacity };
            (low, high) = (low.min(opacity), high.max(opacity));
            opacities[corner] = opacity;
        }
        if low < 1.0 {
            warnings.add(format!(
                "alpha of vertices is taken for opacity: {low} to {high}, 1 is opaque"
            ));
        }
        opacities
    }
}
