//! Shapes from files.
//!
//! No file takes more memory than a multiple of its length: counts that it
//! states are checked against its bytes first.

mod gltf;
mod hair;
mod image;
pub(crate) mod library;
mod obj;
mod ply;
mod polygon;
mod usd;
pub(crate) mod vdb;
pub(crate) mod warnings;

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use self::library::Library;
use self::vdb::choice::GridChoice;
use self::warnings::Warnings;
use crate::curves::Curves;
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;
use crate::scene::{Object, Shape};
use crate::volume::Volume;

/// Vertices and triangles of a mesh, together with its copies.
pub(crate) const MAX_PRIMITIVES: u64 = 100_000_000;

/// An animation of a glTF file at a time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AnimationTime {
    /// Its name, or its number from 0; may be left out where there is one only.
    pub(crate) animation: Option<String>,
    /// In seconds; before its first keyframe and after its last these hold.
    pub(crate) time: f64,
}

/// Reads a mesh: Wavefront `.obj`, Stanford `.ply` (text and binary, either
/// byte order), `.gltf` and `.glb`, by the extension.
///
/// Polygons are cut into triangles that cover what they cover; points and lines are
/// left out. Opacity comes from the dissolve (`d`, `Tr`, `map_d`) of an `.obj`'s
/// materials, from the alpha of a `.ply`'s vertices, and from the alpha of a glTF's
/// base colour, times that of its vertices, where its material is a mask or blends.
/// glTF nodes of the default scene are placed, with their instances; meshes with
/// skins and morph targets stand as at rest, and animations are not applied: a scene
/// file can ask for one at a time.
///
/// # Errors
///
/// [`Error::File`] with the cause: the file can't be read, isn't whole, isn't
/// of its format, needs something that is not supported, or has coordinates that no
/// scene can have; an image is missing that the opacity needs.
pub fn load_mesh(path: &Path) -> Result<TriangleMesh> {
    read_mesh(path, None, &Library::default(), &mut Warnings::default())
}

/// As [`load_mesh`], with what there is to warn of, at a time if it has animations.
pub(crate) fn read_mesh(
    path: &Path,
    time: Option<&AnimationTime>,
    library: &Library,
    warnings: &mut Warnings,
) -> Result<TriangleMesh> {
    library.check_file(path)?;
    let expected = "a mesh is .obj, .ply, .gltf or .glb";
    let mut of_file = Warnings::default();
    let mesh = match extension(path).as_deref() {
        Some("obj" | "ply") if time.is_some() => {
            let reason = "only meshes in glTF have animations";
            Err(Error::malformed(Place::Named("time".into()), reason))
        }
        Some("obj") => obj::load(path, library, &mut of_file),
        Some("ply") => ply::load(path, &mut of_file),
        Some("gltf" | "glb") => gltf::load(path, time, library, &mut of_file),
        _ => Err(unknown(path, expected)),
    };
    let mesh = mesh.map_err(|error| error.in_file(path))?;
    library.add_file(path, mesh.bytes())?;
    if mesh.triangles().is_empty() {
        of_file.add("it has no surface");
    }
    warnings.add_of_file(path, of_file);
    Ok(mesh)
}

/// Reads strands: Cem Yuksel's `.hair`.
///
/// The thickness in the file is a diameter. Its transparency becomes opacity;
/// its colours are left out. Strands without thickness are never met.
///
/// # Errors
///
/// [`Error::File`] with the cause, as [`load_mesh`].
pub fn load_curves(path: &Path) -> Result<Curves> {
    match extension(path).as_deref() {
        Some("hair") => hair::load(path),
        _ => Err(unknown(path, "strands are .hair")),
    }
    .map_err(|error| error.in_file(path))
}

/// As [`load_curves`], counting memory.
pub(crate) fn read_curves(path: &Path, library: &Library) -> Result<Curves> {
    library.check_file(path)?;
    let curves = load_curves(path)?;
    library.add_file(path, curves.bytes())?;
    Ok(curves)
}

/// Reads a medium: OpenVDB `.vdb`, the grid that `choice` names, else `density` in
/// whatever case or the only one there is; numbers, booleans and masks, as halves and
/// packed in every way, placed by any affine map. Voxels count by what they hold,
/// active or not; a background that is not 0 counts up to one voxel beyond the box of
/// the active ones. A level set is refused: it is a surface.
///
/// # Errors
///
/// [`Error::File`] with the cause, as [`load_mesh`].
pub fn load_volume(path: &Path, choice: Option<&GridChoice>) -> Result<Volume> {
    match extension(path).as_deref() {
        Some("vdb") => vdb::load(path, choice),
        _ => Err(unknown(path, "a volume is .vdb")),
    }
    .map_err(|error| error.in_file(path))
}

/// As [`load_volume`], counting memory.
pub(crate) fn read_volume(
    path: &Path,
    choice: Option<&GridChoice>,
    library: &Library,
) -> Result<Volume> {
    library.check_file(path)?;
    let volume = load_volume(path, choice)?;
    library.add_file(path, volume.bytes())?;
    Ok(volume)
}

/// Reads a shape of any kind, by the file's extension. [`open_scene`](crate::open_scene)
/// does, too, and says what the file holds that was not understood.
///
/// ```
/// use dsm_scene::detail::load_shape;
/// use dsm_scene::Shape;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("triangle.obj");
/// std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
/// let Shape::Mesh(mesh) = load_shape(&path)? else { panic!("an OBJ is a mesh") };
/// assert_eq!(mesh.triangles(), [[0, 1, 2]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Error::File`] with the cause, as [`load_mesh`].
pub fn load_shape(path: &Path) -> Result<Shape> {
    read_shape(path, &Library::default(), &mut Warnings::default())
}

/// As [`load_shape`], with what there is to warn of.
pub(crate) fn read_shape(path: &Path, library: &Library, warnings: &mut Warnings) -> Result<Shape> {
    match extension(path).as_deref() {
        Some("hair") => read_curves(path, library).map(Shape::Curves),
        Some("vdb") => read_volume(path, None, library).map(Shape::Volume),
        Some("obj" | "ply" | "gltf" | "glb") => {
            read_mesh(path, None, library, warnings).map(Shape::Mesh)
        }
        _ if is_stage(path) => {
            let expected = "a stage has many shapes: a scene is opened from it";
            Err(unknown(path, expected).in_file(path))
        }
        _ => {
            let expected = "a model is .obj, .ply, .gltf, .glb, .hair or .vdb";
            Err(unknown(path, expected).in_file(path))
        }
    }
}

/// True for a USD stage by its extension.
pub(crate) fn is_stage(path: &Path) -> bool {
    matches!(extension(path).as_deref(), Some("usd" | "usda" | "usdc" | "usdz"))
}

/// Reads the objects of a USD stage: text (`.usda`), binary (`.usdc`), either (`.usd`) or
/// packed (`.usdz`), at `time`, or at its default time, where attributes without a
/// default have their earliest sample.
///
/// Composed are sublayers, inheritance, variants, references, payloads and
/// specialisation. Drawn are the defined, active, visible prims of purpose default and
/// render: meshes as their cages, basis curves, points as discs that face the ray,
/// instances and point instancers. Opacity is `primvars:displayOpacity`. Materials,
/// lights, cameras, skeletons, volumes and other shapes are not read.
///
/// # Errors
///
/// [`Error::File`] with the cause, as [`load_mesh`].
pub(crate) fn read_stage(
    path: &Path,
    time: Option<f64>,
    library: &Library,
    warnings: &mut Warnings,
) -> Result<Vec<Object>> {
    library.check_file(path)?;
    let mut of_file = Warnings::default();
    let objects = usd::load(path, time, &mut of_file).map_err(|error| error.in_file(path))?;
    let shapes: HashMap<_, _> =
        objects.iter().map(|object| (Arc::as_ptr(&object.shape), &object.shape)).collect();
    library.add_file(path, shapes.values().map(|shape| shape.memory()).sum())?;
    if objects.is_empty() {
        of_file.add("nothing in it is drawn");
    }
    warnings.add_of_file(path, of_file);
    Ok(objects)
}

pub(crate) fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_string_lossy().to_ascii_lowercase())
}

fn unknown(path: &Path, expected: &'static str) -> Error {
    Error::UnknownFormat { extension: extension(path), expected }
}

/// All bytes of a regular file: pipes and devices may have no end.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let io = |action| move |error| Error::Io { action, error };
    // Opening a pipe would wait for its writer.
    let metadata = std::fs::metadata(path).map_err(io("open"))?;
    if !metadata.is_file() {
        let error = std::io::Error::other("not a regular file");
        return Err(Error::Io { action: "read", error });
    }
    let mut file = File::open(path).map_err(io("open"))?.take(metadata.len());
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(io("read"))?;
    Ok(bytes)
}
