//! Meshes: cages as they are, their polygons cut into triangles.

use glam::Vec3;

use super::attributes::{Primvar, Spread, broken, indices};
use super::{Geometry, Reader};
use crate::error::Result;
use crate::load::polygon::PolygonCutter;
use crate::load::usd::stage::Prim;

impl Reader<'_, '_> {
    pub(super) fn mesh(&mut self, prim: &Prim, opacity: Option<&Primvar>) -> Result<Geometry> {
        let points = self.vectors(prim, "points")?.unwrap_or_default();
        let read = |name: &str| match self.numbers(prim, name)? {
            Some(numbers) => indices(prim, name, &numbers),
            None => Ok(Vec::new()),
        };
        let (counts, corners) = (read("faceVertexCounts")?, read("faceVertexIndices")?);
        let holes = read("holeIndices")?;
        let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        if total != corners.len() as u64 {
            let reason = format!("its faces have {total} corners, and {} are there", corners.len());
            return Err(broken(prim, reason));
        }
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= points.len()) {
            let reason = format!("point {corner} is out of range: there are {}", points.len());
            return Err(broken(prim, reason));
        }
        let points: Vec<Vec3> =
            points.into_iter().map(|point| Vec3::from(point.map(|x| x as f32))).collect();
        let opacity = opacity.and_then(|opacity| {
            let expected = match opacity.spread {
                Spread::Constant => return None,
                Spread::Uniform => counts.len(),
                Spread::Varying | Spread::Vertex => points.len(),
                Spread::FaceVarying => corners.len(),
            };
            let fits = opacity.data.len() == expected;
            if !fits {
                let line = format!(
                    "{}: {} opacities for {expected} places are left out",
                    prim.path,
                    opacity.data.len()
                );
                self.stage.warnings.add(line);
            }
            fits.then_some(opacity)
        });
        let is_hole = {
            let mut is_hole = vec![false; counts.len()];
            for hole in holes {
                if let Some(face) = is_hole.get_mut(hole as usize) {
                    *face = true;
                }
            }
            is_hole
        };
        // Opacities of faces and corners need vertices of their own.
        let is_split = opacity
            .is_some_and(|opacity| matches!(opacity.spread, Spread::Uniform | Spread::FaceVarying));
        let mut mesh = MeshBuilder { cutter: PolygonCutter::default(), triangles: Vec::new() };
        let mut first = 0;
        let mut opacities = Vec::new();
        for (face, &count) in counts.iter().enumerate() {
            let end = first + count as usize;
            if !is_hole[face] {
                let around = &corners[first..end];
                mesh.add(around, &points, is_split.then_some(first as u32))?;
            }
            if let Some(opacity) = opacity.filter(|_| is_split) {
                opacities.extend((first..end).map(|corner| match opacity.spread {
                    Spread::Uniform => opacity.data[face] as f32,
                    _ => opacity.data[corner] as f32,
                }));
            }
            first = end;
        }
        let positions = if is_split {
            corners.iter().map(|&corner| points[corner as usize]).collect()
        } else {
            points
        };
        if let Some(opacity) = opacity.filter(|_| !is_split) {
            opacities = opacity.data.iter().map(|&value| value as f32).collect();
        }
        Ok(Geometry::Mesh { positions, triangles: mesh.triangles, opacities })
    }
}

struct MeshBuilder {
    cutter: PolygonCutter,
    triangles: Vec<[u32; 3]>,
}

impl MeshBuilder {
    /// Adds a polygon around these points. With `first`, its vertices are its own, one
    /// after the other.
    fn add(&mut self, around: &[u32], points: &[Vec3], first: Option<u32>) -> Result<()> {
        let corners: Vec<Vec3> = around.iter().map(|&corner| points[corner as usize]).collect();
        let vertex = |corner: u32| match first {
            Some(first) => first + corner,
            None => around[corner as usize],
        };
        self.triangles.extend(self.cutter.cut(&corners)?.iter().map(|cut| cut.map(vertex)));
        Ok(())
    }
}
