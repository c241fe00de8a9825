//! Stanford PLY.

mod header;
#[cfg(test)]
mod tests;
mod values;
mod vertices;

use std::path::Path;

use self::header::{Element, Header};
use self::values::Values;
use self::vertices::Vertices;
use super::polygon::PolygonCutter;
use super::read_file;
use super::warnings::Warnings;
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;

pub(super) fn load(path: &Path, warnings: &mut Warnings) -> Result<TriangleMesh> {
    parse(&read_file(path)?, warnings)
}

fn parse(bytes: &[u8], warnings: &mut Warnings) -> Result<TriangleMesh> {
    let header = Header::read(bytes)?;
    let mut values = Values::new(&bytes[header.length..], header.encoding);
    let mut vertices = None;
    let (mut faces, mut strips) = (Lists::default(), Lists::default());
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" if vertices.is_none() => {
                vertices = Some(Vertices::read(element, &mut values)?);
            }
            "face" => faces.read(element, &mut values)?,
            "tristrips" => strips.read(element, &mut values)?,
            name => {
                if element.corners().is_ok() && element.count > 0 {
                    warnings
                        .add(format!("element {name} is left out: only faces and tristrips count"));
                }
                rows(element, &mut values, None, |_, _| {})?;
            }
        }
    }
    let Some(vertices) = vertices else {
        return Err(Error::malformed(Place::Header, "no element vertex"));
    };
    let mut triangles = Vec::new();
    let mut cutter = PolygonCutter::default();
    let mut places = Vec::new();
    for (index, face) in faces.iter() {
        let corners = vertices.corners(face, index)?;
        places.clear();
        places.extend(corners.iter().map(|&corner| vertices.positions[corner as usize]));
        let cut = cutter.cut(&places)?.iter();
        triangles.extend(cut.map(|triangle| triangle.map(|at| corners[at as usize])));
    }
    for (index, strip) in strips.iter() {
        // −1 ends a strip and begins another.
        for strip in strip.split(|&corner| corner == -1) {
            let corners = vertices.corners(strip, index)?;
            triangles.extend(corners.windows(3).map(|t| [t[0], t[1], t[2]]));
        }
    }
    vertices.into_mesh(triangles, warnings)
}

/// Calls `take` for each row with the number of each property, 0 for a list, and the
/// list of property `kept`.
fn rows(
    element: &Element,
    values: &mut Values<'_>,
    kept: Option<usize>,
    mut take: impl FnMut(&[f64], &[f64]),
) -> Result<()> {
    let mut numbers = vec![0.0; element.properties.len()];
    let mut list = Vec::new();
    for row in 0..element.count {
        let broken =
            |reason| Error::malformed(Place::Named(format!("{} {row}", element.name)), reason);
        for (index, property) in element.properties.iter().enumerate() {
            match property.length {
                None => numbers[index] = values.next(property.kind).map_err(broken)?,
                Some(length) => {
                    let count = values.length(length, property.kind).map_err(broken)?;
                    if kept == Some(index) {
                        list.clear();
                    }
                    for _ in 0..count {
                        let number = values.next(property.kind).map_err(broken)?;
                        if kept == Some(index) {
                            list.push(number);
                        }
                    }
                }
            }
        }
        take(&numbers, &list);
    }
    Ok(())
}

/// The corners of polygons or strips.
#[derive(Default)]
struct Lists {
    corners: Vec<i64>,
    ends: Vec<usize>,
}

impl Lists {
    fn read(&mut self, element: &Element, values: &mut Values<'_>) -> Result<()> {
        let kept = element.corners()?;
        rows(element, values, Some(kept), |_, list| {
            self.corners.extend(list.iter().map(|&corner| corner as i64));
            self.ends.push(self.corners.len());
        })
    }

    fn iter(&self) -> impl Iterator<Item = (u64, &[i64])> {
        let begins = [0].into_iter().chain(self.ends.iter().copied());
        (0..).zip(begins.zip(&self.ends).map(|(begin, &end)| &self.corners[begin..end]))
    }
}
