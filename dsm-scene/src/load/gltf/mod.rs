//! glTF 2.0 and GLB.

mod accessors;
mod buffers;
mod collected;
mod container;
mod extensions;
mod json;
mod keys;
mod material;
mod meshopt;
mod nodes;
mod pose;
mod skin;
#[cfg(test)]
mod tests;
mod vertices;

use std::path::Path;

use self::buffers::Buffers;
use self::collected::{Collected, Placement};
use self::json::Root;
use self::material::Materials;
use self::nodes::Nodes;
use self::pose::Pose;
use self::skin::Skin;
use self::vertices::Vertices;
use super::library::Library;
use super::warnings::Warnings;
use super::{AnimationTime, extension, read_file};
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;

/// Reads a file as it stands, or as its animation has it at a time.
pub(super) fn load(
    path: &Path,
    time: Option<&AnimationTime>,
    library: &Library,
    warnings: &mut Warnings,
) -> Result<TriangleMesh> {
    let bytes = read_file(path)?;
    if extension(path).as_deref() == Some("glb") && !bytes.starts_with(b"glTF") {
        return Err(Error::malformed(Place::Header, "not a GLB file: must begin with glTF"));
    }
    parse(&bytes, path, time, library, warnings)
}

fn parse(
    bytes: &[u8],
    path: &Path,
    time: Option<&AnimationTime>,
    library: &Library,
    warnings: &mut Warnings,
) -> Result<TriangleMesh> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let (root, blob) = container::open(bytes)?;
    extensions::check(&root, warnings)?;
    let buffers = Buffers::new(&root, blob, folder);
    let pose = match time {
        Some(time) => Pose::at(time, &buffers, warnings)?,
        None => Pose::default(),
    };
    if time.is_none() && !root.animations.is_empty() {
        warnings.add("animations are not applied: everything stands as its nodes say");
    }
    let materials = Materials { buffers: &buffers, path, library };
    let nodes = Nodes::place(&root, &pose)?;
    let mut mesh = Collected::new(materials, bytes.len());
    for &index in &nodes.drawn {
        let Some(shape) = root.nodes[index].mesh else { continue };
        add_mesh(&mut mesh, &nodes, &buffers, [index, shape.0], warnings)?;
    }
    mesh.into_mesh()
}

/// Adds the mesh of a node.
fn add_mesh<'a>(
    collected: &mut Collected<'a>,
    nodes: &Nodes<'a>,
    buffers: &'a Buffers<'a>,
    [node, mesh]: [usize; 2],
    warnings: &mut Warnings,
) -> Result<()> {
    let root: &Root = buffers.root;
    let Some(shape) = root.meshes.get(mesh) else {
        return Err(Error::malformed(
            Place::Named(format!("node {node}")),
            format!("no mesh {mesh}"),
        ));
    };
    let skin = match root.nodes[node].skin {
        Some(skin) => Some(Skin::load(skin.0, nodes, buffers)?),
        None => None,
    };
    let instances = nodes.instances(node, buffers)?;
    let weights = nodes.weights(node).unwrap_or(&shape.weights);
    for (index, primitive) in shape.primitives.iter().enumerate() {
        let name = shape.name.as_ref().map_or(String::new(), |name| format!(" ({name:.60})"));
        let vertices = Vertices { primitive, buffers, weights };
        let placement = Placement { skin: skin.as_ref(), instances: &instances };
        collected
            .add(&vertices, &placement, warnings)
            .map_err(|error| at_place(error, &format!("mesh {mesh}{name} primitive {index}")))?;
    }
    Ok(())
}

fn malformed(reason: String) -> Error {
    Error::malformed(Place::Whole, reason)
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
