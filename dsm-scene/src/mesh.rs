//! Triangle meshes.

use glam::{Vec2, Vec3};

use crate::alpha::{Alpha, AlphaMode};
use crate::bounds::Bounds;
use crate::error::{Error, Place, Result};

/// No coordinate may be larger: squares of it must be finite in `f32`.
pub(crate) const LARGEST_COORDINATE: f32 = 1e18;

/// Checks that a point can be part of a scene.
pub(crate) fn check_point(point: Vec3, place: impl FnOnce() -> Place) -> Result<()> {
    if point.abs().cmple(Vec3::splat(LARGEST_COORDINATE)).all() {
        Ok(())
    } else {
        Err(Error::malformed(place(), "coordinates must be finite and at most 1e18"))
    }
}

/// A triangle mesh, seen from both sides. Every crossing of a triangle blocks
/// light.
///
/// ```
/// use dsm_scene::TriangleMesh;
/// use glam::Vec3;
///
/// let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]])?;
/// assert_eq!(mesh.corners(0)[1], Vec3::X);
/// assert!(TriangleMesh::new(vec![Vec3::ZERO], vec![[0, 0, 1]]).is_err());
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    uvs: Vec<Vec2>,
    alphas: Vec<Alpha>,
    triangle_alphas: Vec<u32>,
    /// One a vertex; empty if all are 1.
    vertex_alphas: Vec<f32>,
    /// True if `alphas` and `vertex_alphas` make anything less than opaque.
    lets_light: bool,
}

impl TriangleMesh {
    /// A mesh that is opaque everywhere; `triangles` index `positions`, of which
    /// those that no triangle uses may be anything.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for coordinates that are not finite or beyond
    /// 1e18, and for indices out of range; [`Error::TooLarge`] above 2³²
    /// vertices or triangles.
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        for (what, count) in [("vertices", positions.len()), ("triangles", triangles.len())] {
            let limit = u64::from(u32::MAX);
            if count as u64 > limit {
                return Err(Error::TooLarge { what, count: count as u64, limit });
            }
        }
        let beyond = |corner: &u32| *corner as usize >= positions.len();
        if let Some((face, corner)) = triangles
            .iter()
            .enumerate()
            .find_map(|(at, t)| Some((at, *t.iter().find(|c| beyond(c))?)))
        {
            let reason = format!("vertex {corner} is out of range: there are {}", positions.len());
            return Err(Error::malformed(Place::Face(face as u64), reason));
        }
        for &corner in triangles.iter().flatten() {
            check_point(positions[corner as usize], || Place::Vertex(u64::from(corner)))?;
        }
        Ok(Self { positions, triangles, ..Self::default() })
    }

    /// Bytes of its columns, without the images of its materials, which may be shared.
    pub(crate) fn bytes(&self) -> u64 {
        fn of<V>(column: &[V]) -> u64 {
            size_of_val(column) as u64
        }
        of(&self.positions)
            + of(&self.triangles)
            + of(&self.uvs)
            + of(&self.alphas)
            + of(&self.triangle_alphas)
            + of(&self.vertex_alphas)
    }

    /// Sets texture coordinates: one a vertex, or none.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for another number of them.
    pub fn with_uvs(self, uvs: Vec<Vec2>) -> Result<Self> {
        if !uvs.is_empty() && uvs.len() != self.positions.len() {
            let reason = "texture coordinates must be one per vertex";
            return Err(Error::malformed(Place::Whole, reason));
        }
        Ok(Self { uvs, ..self })
    }

    /// Sets materials: `triangle_alphas` holds one index into `alphas` a triangle.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for another number of them, or an index out of
    /// range.
    pub fn with_alphas(self, alphas: Vec<Alpha>, triangle_alphas: Vec<u32>) -> Result<Self> {
        if triangle_alphas.len() != self.triangles.len() {
            let reason = "materials must be one per triangle";
            return Err(Error::malformed(Place::Whole, reason));
        }
        if let Some(face) = triangle_alphas.iter().position(|&at| at as usize >= alphas.len()) {
            return Err(Error::malformed(Place::Face(face as u64), "the material is out of range"));
        }
        Ok(Self { alphas, triangle_alphas, ..self }.measured())
    }

    /// Sets the alpha of vertices: one a vertex, in [0, 1], or none. It varies evenly
    /// over a triangle and is a factor of the material's alpha, which counts by the
    /// material's [`AlphaMode`]; without materials it is the opacity.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for another number of them, or one that is not in [0, 1].
    pub fn with_vertex_alphas(self, mut vertex_alphas: Vec<f32>) -> Result<Self> {
        if !vertex_alphas.is_empty() && vertex_alphas.len() != self.positions.len() {
            let reason = "alphas must be one per vertex";
            return Err(Error::malformed(Place::Whole, reason));
        }
        if let Some(odd) = vertex_alphas.iter().position(|alpha| !(0.0..=1.0).contains(alpha)) {
            let reason = format!("alpha {} is not in [0, 1]", vertex_alphas[odd]);
            return Err(Error::malformed(Place::Vertex(odd as u64), reason));
        }
        if vertex_alphas.iter().all(|&alpha| alpha == 1.0) {
            vertex_alphas = Vec::new();
        }
        Ok(Self { vertex_alphas, ..self }.measured())
    }

    /// The mesh, once it is known whether it lets light through.
    fn measured(self) -> Self {
        let whole = |alpha: &Alpha| match alpha.mode {
            AlphaMode::Opaque => true,
            _ => self.vertex_alphas.is_empty() && alpha.is_opaque(),
        };
        let is_opaque = match self.alphas.as_slice() {
            [] => self.vertex_alphas.is_empty(),
            alphas => alphas.iter().all(whole),
        };
        Self { lets_light: !is_opaque, ..self }
    }

    /// The vertices.
    #[must_use]
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Three vertices a triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Texture coordinates, one a vertex; empty if there are none.
    #[must_use]
    pub fn uvs(&self) -> &[Vec2] {
        &self.uvs
    }

    /// The materials that are not opaque everywhere, with those that the file
    /// had beside them; empty if all are opaque.
    #[must_use]
    pub fn alphas(&self) -> &[Alpha] {
        if self.lets_light { &self.alphas } else { &[] }
    }

    /// One index into [`Self::alphas`] a triangle; empty if all are opaque.
    #[must_use]
    pub fn triangle_alphas(&self) -> &[u32] {
        if self.lets_light { &self.triangle_alphas } else { &[] }
    }

    /// The alpha of each vertex; empty if all are 1 or no material heeds them.
    #[must_use]
    pub fn vertex_alphas(&self) -> &[f32] {
        if self.lets_light { &self.vertex_alphas } else { &[] }
    }

    /// True if every triangle has one opacity all over.
    pub(crate) fn is_even(&self) -> bool {
        self.vertex_alphas().is_empty() && self.alphas().iter().all(Alpha::is_even)
    }

    /// The corners of triangle `index`.
    #[must_use]
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].map(|corner| self.positions[corner as usize])
    }

    /// The opacity of triangle `index` where its second and third corner weigh
    /// `u` and `v`: 1 unless a material or the vertices say otherwise.
    #[must_use]
    pub fn opacity(&self, index: usize, u: f32, v: f32) -> f32 {
        if !self.lets_light {
            return 1.0;
        }
        let corners = self.triangles[index].map(|corner| corner as usize);
        let vertices = match self.vertex_alphas.as_slice() {
            [] => 1.0,
            alphas => {
                let [a, b, c] = corners.map(|corner| alphas[corner]);
                // Equal ones stay what they are, for a cutoff's sake.
                (a + (b - a) * u + (c - a) * v).clamp(0.0, 1.0)
            }
        };
        let Some(&alpha) = self.triangle_alphas.get(index) else { return vertices };
        let [a, b, c] = corners.map(|corner| self.uvs.get(corner).copied().unwrap_or_default());
        self.alphas[alpha as usize].opacity_times(a * (1.0 - u - v) + b * u + c * v, vertices)
    }

    /// The box around all vertices that a triangle uses.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let used = self.triangles.iter().flatten();
        Bounds::of_balls(used.map(|&corner| (self.positions[corner as usize], 0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alpha::AlphaTexture;

    fn triangle() -> TriangleMesh {
        TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap()
    }

    #[test]
    fn meshes_no_scene_can_have_are_refused() {
        for odd in [f32::NAN, f32::INFINITY, 2e18] {
            let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, odd, 0.0)];
            let error = TriangleMesh::new(positions, vec![[0, 1, 2]]).unwrap_err();
            assert!(error.to_string().starts_with("vertex 2: "), "{error}");
        }
        let error = TriangleMesh::new(vec![Vec3::ZERO], vec![[0, 0, 0], [0, 1, 0]]).unwrap_err();
        assert_eq!(error.to_string(), "face 1: vertex 1 is out of range: there are 1");
        let unused = vec![Vec3::ZERO, Vec3::X, Vec3::NAN, Vec3::Y];
        let mesh = TriangleMesh::new(unused, vec![[0, 1, 3]]).unwrap();
        assert!(mesh.bounds().max.is_finite());
        assert!(triangle().with_uvs(vec![Vec2::ZERO]).is_err());
        assert!(triangle().with_alphas(vec![Alpha::default()], vec![]).is_err());
        assert!(triangle().with_alphas(vec![Alpha::default()], vec![1]).is_err());
    }

    #[test]
    fn opacity_is_looked_up_where_the_triangle_is_hit() {
        let mut texture = AlphaTexture::new(2, 1, [0, 255].as_slice()).unwrap();
        texture.nearest = true;
        let texture = Some(texture);
        let alpha = Alpha { mode: AlphaMode::Blend, factor: 0.5, texture };
        let mesh = triangle()
            .with_uvs(vec![Vec2::ZERO, Vec2::new(0.9, 0.0), Vec2::Y])
            .unwrap()
            .with_alphas(vec![alpha], vec![0])
            .unwrap();
        assert_eq!(mesh.opacity(0, 0.1, 0.1), 0.0);
        assert_eq!(mesh.opacity(0, 0.9, 0.0), 0.5);
        assert_eq!(triangle().opacity(0, 0.1, 0.1), 1.0);
    }

    #[test]
    fn alphas_of_vertices_are_a_factor_where_the_material_heeds_alpha() {
        let varied = || triangle().with_vertex_alphas(vec![1.0, 0.5, 0.0]).unwrap();
        let of = |mode, factor| {
            let alpha = Alpha { mode, factor, texture: None };
            let mesh = varied().with_alphas(vec![alpha], vec![0]).unwrap();
            (mesh.opacity(0, 0.5, 0.25), mesh.is_even())
        };
        assert_eq!(varied().opacity(0, 0.5, 0.25), 0.5);
        assert_eq!(of(AlphaMode::Opaque, 0.5), (1.0, true));
        assert_eq!(of(AlphaMode::Blend, 0.5), (0.25, false));
        assert_eq!(of(AlphaMode::Blend, 1.0), (0.5, false));
        assert_eq!(of(AlphaMode::Mask(0.4), 1.0), (1.0, false));
        assert_eq!(of(AlphaMode::Mask(0.6), 1.0), (0.0, false));
        let whole = triangle().with_vertex_alphas(vec![1.0; 3]).unwrap();
        assert!(whole.is_even() && whole.vertex_alphas().is_empty());
        // Rounding outside the triangle's corners stays in [0, 1].
        assert_eq!(varied().opacity(0, -0.1, -0.1), 1.0);
        for odd in [-0.1, 1.1, f32::NAN] {
            let error = triangle().with_vertex_alphas(vec![1.0, odd, 1.0]).unwrap_err();
            assert!(error.to_string().starts_with("vertex 1: "), "{error}");
        }
        assert!(triangle().with_vertex_alphas(vec![1.0]).is_err());
    }
}
