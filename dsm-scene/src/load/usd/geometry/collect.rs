//! Shapes and their places as objects of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};

use super::{Geometry, Item};
use crate::alpha::{Alpha, AlphaMode, AlphaTexture, Wrap};
use crate::curves::Curves;
use crate::error::{Error, Result};
use crate::load::warnings::Warnings;
use crate::mesh::TriangleMesh;
use crate::scene::{Object, Shape};
use crate::transform::{Motion, Transform};
use dsm_core::Rgb;

/// Triangles and points that are copied rather than shared: rays ask each object.
const MOST_SMALL: u64 = 1 << 22;
/// Those that are copied where they can't be shared.
const MOST_COPIED: u64 = 1 << 24;

/// The objects of a stage: one of all surfaces and one of all strands, and copies of
/// large shapes that share them.
pub(in crate::load::usd) fn objects(
    items: Vec<Item>,
    warnings: &mut Warnings,
) -> Result<Vec<Object>> {
    let mut uses: HashMap<*const Geometry, u64> = HashMap::new();
    for item in &items {
        *uses.entry(Arc::as_ptr(&item.shape)).or_default() += 1;
    }
    let total = items.iter().fold(0_u64, |total, item| total.saturating_add(item.shape.size()));
    let mut merged = Merged::default();
    let mut shared: HashMap<*const Geometry, Arc<Shape>> = HashMap::new();
    let mut objects = Vec::new();
    let mut copied = 0;
    for item in &items {
        let pointer = Arc::as_ptr(&item.shape);
        if total > MOST_SMALL
            && uses[&pointer] > 1
            && let Some(transform) = similarity(&item.to_world)
        {
            let shape = match shared.get(&pointer) {
                Some(shape) => Arc::clone(shape),
                None => {
                    let mut own = Merged::default();
                    own.add(
                        &Item { to_world: DAffine3::IDENTITY, inherited: None, ..item.clone() },
                        warnings,
                    )?;
                    let Some(shape) = own.into_shapes()?.pop() else { continue };
                    let shape = Arc::new(shape);
                    shared.insert(pointer, Arc::clone(&shape));
                    shape
                }
            };
            let opacity = item.inherited.unwrap_or(1.0);
            let opacity = Rgb::new(opacity, opacity, opacity);
            let motion = vec![Motion::still(transform)];
            objects.push(Object { shape, opacity, density: 1.0, motion });
            continue;
        }
        if uses[&pointer] > 1 {
            copied += item.shape.size();
        }
        if copied > MOST_COPIED {
            let (count, limit) = (copied, MOST_COPIED);
            return Err(Error::TooLarge { what: "copied triangles and points", count, limit });
        }
        merged.add(item, warnings)?;
    }
    objects.extend(merged.into_shapes()?.into_iter().map(Object::new));
    Ok(objects)
}

impl Geometry {
    /// Vertices and triangles, or points.
    pub(super) fn size(&self) -> u64 {
        match self {
            Self::Mesh { positions, triangles, .. } => (positions.len() + triangles.len()) as u64,
            Self::Strands { points, .. } => points.len() as u64,
        }
    }
}

/// All surfaces and all strands, in the world.
#[derive(Default)]
struct Merged {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    surface_opacities: Vec<f32>,
    points: Vec<Vec3>,
    radii: Vec<f32>,
    lengths: Vec<u32>,
    strand_opacities: Vec<f32>,
}

impl Merged {
    fn add(&mut self, item: &Item, warnings: &mut Warnings) -> Result<()> {
        let to_world = &item.to_world;
        let place = |point: &Vec3| to_world.transform_point3(point.as_dvec3()).as_vec3();
        let even = item.inherited.unwrap_or(1.0);
        match &*item.shape {
            Geometry::Mesh { positions, triangles, opacities } => {
                let first = self.positions.len();
                if u32::try_from(first + positions.len()).is_err() {
                    let count = (first + positions.len()) as u64;
                    return Err(Error::TooLarge {
                        what: "vertices",
                        count,
                        limit: u32::MAX.into(),
                    });
                }
                self.positions.extend(positions.iter().map(place));
                let moved = |triangle: &[u32; 3]| triangle.map(|corner| corner + first as u32);
                self.triangles.extend(triangles.iter().map(moved));
                extend(&mut self.surface_opacities, opacities, even, self.positions.len());
            }
            Geometry::Strands { points, radii, opacities, lengths } => {
                let scale = to_world.matrix3.determinant().abs().cbrt();
                if !points.is_empty() && !is_even(&to_world.matrix3) {
                    warnings.add(format!(
                        "{}: its widths are scaled alike in all directions",
                        item.path
                    ));
                }
                self.points.extend(points.iter().map(place));
                self.radii.extend(radii.iter().map(|&radius| (f64::from(radius) * scale) as f32));
                self.lengths.extend(lengths);
                extend(&mut self.strand_opacities, opacities, even, self.points.len());
            }
        }
        Ok(())
    }

    fn into_shapes(self) -> Result<Vec<Shape>> {
        let mut shapes = Vec::new();
        if !self.triangles.is_empty() {
            let count = self.triangles.len();
            let mesh = TriangleMesh::new(self.positions, self.triangles)?;
            shapes.push(Shape::Mesh(if self.surface_opacities.iter().all(|&part| part == 1.0) {
                mesh
            } else {
                let uvs = self.surface_opacities.iter().map(|&opacity| ramp_uv(opacity));
                mesh.with_uvs(uvs.collect())?.with_alphas(vec![ramp()?], vec![0; count])?
            }));
        }
        if !self.points.is_empty() {
            let curves = Curves::new(self.points, self.radii, self.lengths)?;
            shapes.push(Shape::Curves(if self.strand_opacities.iter().all(|&part| part == 1.0) {
                curves
            } else {
                curves.with_opacities(self.strand_opacities)?
            }));
        }
        Ok(shapes)
    }
}

/// Adds opacities up to `length`: their own, or `even` ones.
fn extend(all: &mut Vec<f32>, own: &[f32], even: f32, length: usize) {
    all.extend(own);
    all.resize(length, even);
}

/// A texture whose alpha goes from 0 to 1 where u goes from 0.25 to 0.75, so that
/// texture coordinates carry an opacity that goes linearly between vertices.
fn ramp() -> Result<Alpha> {
    let mut texture = AlphaTexture::new(2, 1, vec![0, 255])?;
    texture.wrap = [Wrap::Clamp; 2];
    Ok(Alpha { mode: AlphaMode::Blend, factor: 1.0, texture: Some(texture) })
}

fn ramp_uv(opacity: f32) -> Vec2 {
    Vec2::new(0.25 + 0.5 * opacity, 0.5)
}

/// True if lengths grow alike in all directions, but for rounding.
fn is_even(matrix: &DMat3) -> bool {
    let lengths = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length_squared);
    let [x, y, z] = lengths;
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.max(b);
    let [u, v, w] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let is_right = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-9 * x.max(y).max(z);
    near(x, y) && near(y, z) && is_right(u, v) && is_right(v, w) && is_right(w, u)
}

/// The matrix as a similarity, if it is one of this handedness.
fn similarity(matrix: &DAffine3) -> Option<Transform> {
    let axes = &matrix.matrix3;
    let scale = axes.determinant().cbrt();
    if !(is_even(axes) && (1e-18..=1e18).contains(&scale)) {
        return None;
    }
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis / scale);
    // The matrix is Rz · Ry · Rx.
    let sin = -x.z.clamp(-1.0, 1.0);
    let cos = x.x.hypot(x.y);
    let about_y = libm::atan2(sin, cos);
    let (about_x, about_z) = if cos > 1e-9 {
        (libm::atan2(y.z, z.z), libm::atan2(x.y, x.x))
    } else {
        (libm::atan2(-z.y, y.y), 0.0)
    };
    let rotate = DVec3::new(about_x, about_y, about_z).map(f64::to_degrees);
    let transform = Transform { translate: matrix.translation, rotate, scale };
    transform.check().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similarities_are_told_from_other_matrices() {
        for rotate in [[20.0, 30.0, 40.0], [0.0, 90.0, 25.0], [170.0, -90.0, 0.0], [0.0; 3]] {
            let transform = Transform {
                translate: DVec3::new(1.0, -2.0, 3.0),
                rotate: rotate.into(),
                scale: 2.5,
            };
            let found = similarity(&transform.matrix()).unwrap();
            assert!(found.matrix().abs_diff_eq(transform.matrix(), 1e-12), "{rotate:?}");
        }
        for scale in [[1.0, 1.0, -1.0], [1.0, 1.0, 1.001], [0.0; 3]] {
            assert!(similarity(&DAffine3::from_scale(scale.into())).is_none());
        }
        let mut shear = DAffine3::IDENTITY;
        shear.matrix3.y_axis.x = 0.001;
        assert!(similarity(&shear).is_none());
    }

    #[test]
    fn opacities_go_linearly_between_vertices() {
        let alpha = ramp().unwrap();
        for step in 0..=1000 {
            let opacity = step as f32 / 1000.0;
            assert!((alpha.opacity(ramp_uv(opacity)) - opacity).abs() < 1e-6);
        }
    }
}
