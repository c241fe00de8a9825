//! glTF 2.0 and GLB.

use std::collections::HashMap;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Affine2, DMat4, Mat4, Vec2};
use gltf::accessor::{DataType, Dimensions};
use gltf::json::texture::{MagFilter, WrappingMode};
use gltf::material::AlphaMode as GltfAlphaMode;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Material, Node, Primitive, Semantic};

use super::image::{Channel, decode};
use super::{MOST_PRIMITIVES, extension, read_file};
use crate::alpha::{Alpha, AlphaMode, AlphaTexture, Wrap};
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;

/// An accessor without data is all zeros; no more than these.
const MOST_ZEROS: usize = 1 << 24;

pub(super) fn load(path: &Path) -> Result<TriangleMesh> {
    let bytes = read_file(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    if extension(path).as_deref() == Some("glb") && !bytes.starts_with(b"glTF") {
        return Err(Error::malformed(Place::Header, "not a GLB file: it begins with glTF"));
    }
    parse(&bytes, folder)
}

fn parse(bytes: &[u8], folder: &Path) -> Result<TriangleMesh> {
    if bytes.starts_with(b"glTF") {
        // The parser subtracts the header's length from what the file states.
        let stated = bytes.get(8..12).map_or(0, unsigned);
        if stated < 20 || u64::from(stated) > bytes.len() as u64 {
            let reason = format!("{} of {stated} bytes are there", bytes.len());
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
        let reason = format!("there is no accessor {index}");
        return Err(Error::malformed(Place::Whole, reason));
    }
    let gltf = Document::from_json(json).map_err(broken)?;
    let buffers = load_buffers(&gltf, loaded.blob.as_deref(), folder)?;
    let file = GltfFile { buffers, folder, document: &gltf };
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
            return Err(Error::malformed(place(), "it stands in the tree twice"));
        }
        let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4();
        if let Some(shape) = node.mesh() {
            for primitive in shape.primitives() {
                file.add(&primitive, &world, &mut mesh).map_err(|error| {
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

/// The same error, with where it happened in front.
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

#[derive(Default)]
struct Collected {
    positions: Vec<glam::Vec3>,
    uvs: Vec<Vec2>,
    has_uvs: bool,
    triangles: Vec<[u32; 3]>,
    triangle_alphas: Vec<u32>,
    alphas: Vec<Alpha>,
    /// Which material became which of `alphas`.
    materials: HashMap<Option<usize>, u32>,
}

struct GltfFile<'a> {
    document: &'a Document,
    buffers: Vec<Vec<u8>>,
    folder: &'a Path,
}

impl GltfFile<'_> {
    fn add(&self, primitive: &Primitive<'_>, world: &DMat4, mesh: &mut Collected) -> Result<()> {
        let strip = match primitive.mode() {
            Mode::Triangles => None,
            Mode::TriangleStrip => Some(false),
            Mode::TriangleFan => Some(true),
            _ => return Ok(()),
        };
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        let first = mesh.positions.len();
        let positions = self.floats::<3>(&positions)?;
        let count = positions.len();
        check_count("vertices", first, count)?;
        mesh.positions.extend(positions.into_iter().map(|position| {
            world.transform_point3(glam::Vec3::from(position).as_dvec3()).as_vec3()
        }));

        let material = primitive.material();
        let alpha = match mesh.materials.get(&material.index()) {
            Some(&alpha) => alpha,
            None => {
                let alpha = self.alpha(&material)?;
                mesh.alphas.push(alpha);
                let index = mesh.alphas.len() as u32 - 1;
                mesh.materials.insert(material.index(), index);
                index
            }
        };
        let set = uv_set(&material);
        let uvs = primitive.get(&Semantic::TexCoords(set));
        let textured = mesh.alphas[alpha as usize].texture.is_some();
        if let Some(uvs) = uvs.filter(|_| textured) {
            let uvs = self.floats::<2>(&uvs)?;
            if uvs.len() != count {
                let reason = "texture coordinates must be as many as vertices";
                return Err(Error::malformed(Place::Whole, reason));
            }
            mesh.uvs.extend(uvs.into_iter().map(Vec2::from));
            mesh.has_uvs = true;
        } else if textured {
            let reason = "its opacity needs texture coordinates, and there are none";
            return Err(Error::malformed(Place::Whole, reason));
        }
        mesh.uvs.resize(mesh.positions.len(), Vec2::ZERO);

        let corners = match primitive.indices() {
            Some(indices) => self.indices(&indices)?,
            None => (0..count as u32).collect(),
        };
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            let reason = format!("there is no vertex {corner}, only {count}");
            return Err(Error::malformed(Place::Whole, reason));
        }
        check_count("triangles", mesh.triangles.len(), corners.len())?;
        let moved = |t: [u32; 3]| t.map(|corner| corner + first as u32);
        match strip {
            None => mesh.triangles.extend(corners.as_chunks::<3>().0.iter().map(|&t| moved(t))),
            Some(false) => {
                mesh.triangles.extend(corners.windows(3).map(|t| moved([t[0], t[1], t[2]])))
            }
            Some(true) => mesh
                .triangles
                .extend(corners.windows(2).skip(1).map(|t| moved([corners[0], t[0], t[1]]))),
        }
        mesh.triangle_alphas.resize(mesh.triangles.len(), alpha);
        Ok(())
    }

    /// The opacity that a material's base colour stands for. Its image is read
    /// only if it matters.
    fn alpha(&self, material: &Material<'_>) -> Result<Alpha> {
        let mode = match material.alpha_mode() {
            GltfAlphaMode::Opaque => return Ok(Alpha::default()),
            GltfAlphaMode::Mask => AlphaMode::Mask(material.alpha_cutoff().unwrap_or(0.5)),
            GltfAlphaMode::Blend => AlphaMode::Blend,
        };
        let colour = material.pbr_metallic_roughness();
        let factor = colour.base_color_factor()[3];
        let texture = match colour.base_color_texture() {
            None => None,
            Some(info) => {
                let index = info.texture().source().index();
                let texture = self.image(index)?;
                texture.map(|texture| sampled(texture, &info))
            }
        };
        Ok(Alpha { mode, factor, texture })
    }

    fn image(&self, index: usize) -> Result<Option<AlphaTexture>> {
        let place = || Place::Named(format!("image {index}"));
        let image = self.document.as_json().images.get(index);
        let uri = image.and_then(|image| image.uri.as_deref());
        let view = image.and_then(|image| image.buffer_view);
        match (uri, view.and_then(|view| self.document.views().nth(view.value()))) {
            (_, Some(view)) => {
                let bytes =
                    self.view(&view).map_err(|error| at_place(error, &place().to_string()))?;
                decode(bytes, Channel::Alpha)
            }
            (Some(uri), None) => decode(&load_uri(uri, self.folder)?, Channel::Alpha),
            (None, None) => Err(Error::malformed(Place::Whole, "there is no image")),
        }
        .map_err(|error| at_place(error, &place().to_string()))
    }

    fn view(&self, view: &gltf::buffer::View<'_>) -> Result<&[u8]> {
        let buffer = self.buffers.get(view.buffer().index());
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| buffer?.get(view.offset()..end)).ok_or_else(|| {
            Error::malformed(Place::Whole, "a buffer view reaches over its buffer's end")
        })
    }

    /// The bytes of every element: `count` of them, `size` bytes each.
    fn elements<'s>(
        &'s self,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        size: usize,
        count: usize,
    ) -> Result<impl Iterator<Item = &'s [u8]> + use<'s>> {
        let bytes = self.view(view)?;
        let stride = view.stride().unwrap_or(size);
        let last = count.saturating_sub(1).checked_mul(stride);
        let end = last.and_then(|last| last.checked_add(size)?.checked_add(offset));
        if stride < size || (count > 0 && end.is_none_or(|end| end > bytes.len())) {
            let reason = "an accessor reaches over its buffer view's end";
            return Err(Error::malformed(Place::Whole, reason));
        }
        Ok((0..count).map(move |index| &bytes[offset + index * stride..][..size]))
    }

    /// The elements of an accessor with its sparse ones in place, each as
    /// `decode` reads it.
    fn values<T: Clone + Default>(
        &self,
        accessor: &Accessor<'_>,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let (count, size) = (accessor.count(), accessor.size());
        let mut values: Vec<T> = match accessor.view() {
            Some(view) => {
                self.elements(&view, accessor.offset(), size, count)?.map(&decode).collect()
            }
            None if count <= MOST_ZEROS => vec![T::default(); count],
            None => {
                let limit = MOST_ZEROS as u64;
                return Err(Error::TooLarge { what: "zeros", count: count as u64, limit });
            }
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, count) = (sparse.indices(), sparse.count());
            let size_of_index = indices.index_type().size();
            let places = self.elements(&indices.view(), indices.offset(), size_of_index, count)?;
            let replaced = sparse.values();
            let replaced = self.elements(&replaced.view(), replaced.offset(), size, count)?;
            for (place, value) in places.zip(replaced) {
                let Some(target) = values.get_mut(unsigned(place) as usize) else {
                    let reason = "a sparse accessor replaces what is not there";
                    return Err(Error::malformed(Place::Whole, reason));
                };
                *target = decode(value);
            }
        }
        Ok(values)
    }

    fn floats<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>> {
        let dimensions = if N == 3 { Dimensions::Vec3 } else { Dimensions::Vec2 };
        if accessor.dimensions() != dimensions {
            return Err(Error::malformed(Place::Whole, "an accessor has another dimension"));
        }
        let (size, part) = match accessor.data_type() {
            DataType::F32 => (4, 1.0),
            DataType::U8 if accessor.normalized() => (1, 1.0 / 255.0),
            DataType::U16 if accessor.normalized() => (2, 1.0 / 65535.0),
            _ => return Err(Error::malformed(Place::Whole, "an accessor has another type")),
        };
        let float = |bytes: &[u8]| match bytes {
            &[a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            bytes => unsigned(bytes) as f32 * part,
        };
        let decode =
            |bytes: &[u8]| std::array::from_fn(|at| float(&bytes[at * size..(at + 1) * size]));
        // Arrays have a default up to a length only.
        let values = self.values(accessor, |bytes| Some(decode(bytes)))?;
        Ok(values.into_iter().map(|value| value.unwrap_or([0.0; N])).collect())
    }

    fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>> {
        let integer = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !integer {
            return Err(Error::malformed(Place::Whole, "indices have to be whole numbers"));
        }
        self.values(accessor, unsigned)
    }
}

fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

fn check_count(what: &'static str, before: usize, more: usize) -> Result<()> {
    let count = before as u64 + more as u64;
    if count > MOST_PRIMITIVES {
        return Err(Error::TooLarge { what, count, limit: MOST_PRIMITIVES });
    }
    Ok(())
}

/// Which set of texture coordinates the base colour takes.
fn uv_set(material: &Material<'_>) -> u32 {
    let colour = material.pbr_metallic_roughness();
    colour.base_color_texture().map_or(0, |info| {
        let moved = info.texture_transform().and_then(|transform| transform.tex_coord());
        moved.unwrap_or_else(|| info.tex_coord())
    })
}

fn sampled(mut texture: AlphaTexture, info: &gltf::texture::Info<'_>) -> AlphaTexture {
    let sampler = info.texture().sampler();
    texture.wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|wrap| match wrap {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    });
    texture.nearest = sampler.mag_filter() == Some(MagFilter::Nearest);
    if let Some(transform) = info.texture_transform() {
        let scale = Vec2::from(transform.scale());
        let (sin, cos) = libm::sincosf(transform.rotation());
        // Counterclockwise where v goes down.
        let rotation = glam::Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        let matrix = rotation * glam::Mat2::from_diagonal(scale);
        texture.uv_transform =
            Affine2::from_mat2_translation(matrix, Vec2::from(transform.offset()));
    }
    texture
}

fn load_buffers(gltf: &Document, blob: Option<&[u8]>, folder: &Path) -> Result<Vec<Vec<u8>>> {
    let load = |buffer: gltf::Buffer<'_>| {
        let bytes = match buffer.source() {
            // One chunk of bytes, for the first buffer: copies of it could be many.
            gltf::buffer::Source::Bin => {
                blob.filter(|_| buffer.index() == 0).map(<[u8]>::to_vec).ok_or_else(|| {
                    Error::malformed(Place::Whole, "its bytes are not in the file")
                })?
            }
            gltf::buffer::Source::Uri(uri) => load_uri(uri, folder)?,
        };
        if bytes.len() < buffer.length() {
            let reason = format!("{} of {} bytes are there", bytes.len(), buffer.length());
            return Err(Error::malformed(Place::Whole, reason));
        }
        Ok(bytes)
    };
    gltf.buffers()
        .map(|buffer| {
            let place = format!("buffer {}", buffer.index());
            load(buffer).map_err(|error| at_place(error, &place))
        })
        .collect()
}

/// The bytes that a URI stands for: data in base 64, or a file beside this one.
fn load_uri(uri: &str, folder: &Path) -> Result<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err(Error::malformed(Place::Whole, "a data URI has to be in base 64"));
        };
        return STANDARD
            .decode(text)
            .map_err(|error| Error::malformed(Place::Whole, format!("base 64: {error}")));
    }
    if uri.contains("://") {
        let reason = format!("{uri} is no file beside this one");
        return Err(Error::malformed(Place::Whole, reason));
    }
    let path = folder.join(percent_decoded(uri));
    read_file(&path).map_err(|error| error.in_file(&path))
}

/// %20 and its like as what they stand for.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let digits = tail.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        let escaped = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match escaped.filter(|_| *first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A triangle in a file: three positions, three indices as bytes, and
    /// whatever else a test wants to say.
    fn file(material: &str, images: &str, nodes: &str, primitive: &str) -> String {
        let mut bytes = Vec::new();
        for value in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0, 1, 2, 0]);
        for value in [0.0_f32, 0.0, 1.0, 0.0, 0.0, 1.0] {
            bytes.extend(value.to_le_bytes());
        }
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
            "nodes": [{nodes}], "meshes": [{{"primitives": [{{"attributes":
            {{"POSITION": 0, "TEXCOORD_0": 2}}, "indices": 1, "material": 0 {primitive}}}]}}],
            "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [1, 1, 1, 0.5]
            {material}}}], {images}
            "buffers": [{{"byteLength": 64, "uri": "data:application/octet-stream;base64,{}"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}},
            {{"buffer": 0, "byteOffset": 36, "byteLength": 4}},
            {{"buffer": 0, "byteOffset": 40, "byteLength": 24}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}},
            {{"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}},
            {{"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"}}]}}"#,
            STANDARD.encode(bytes)
        )
    }

    fn parse_text(text: &str) -> Result<TriangleMesh> {
        parse(text.as_bytes(), Path::new("/nowhere"))
    }

    const BLEND: &str = r#"}, "alphaMode": "BLEND""#;
    const NODE: &str = r#"{"mesh": 0}"#;
    const TEXTURED: &str = r#", "baseColorTexture": {"index": 0}}, "alphaMode": "MASK""#;
    const IMAGES: &str = r#""textures": [{"source": 0}], "images": [{"uri": "no%20leaf.png"}],"#;

    #[test]
    fn nodes_are_placed() {
        let nodes = r#"{"children": [1, 2], "translation": [1, 0, 0]},
            {"mesh": 0, "scale": [2, 3, 1]}, {"mesh": 0, "rotation": [0, 0, 1, 0]}"#;
        let mesh = parse_text(&file(BLEND, "", nodes, "")).unwrap();
        assert_eq!(mesh.corners(0), [Vec3::X, Vec3::X * 3.0, Vec3::new(1.0, 3.0, 0.0)]);
        let turned = mesh.corners(1)[1];
        assert!((turned - Vec3::ZERO).length() < 1e-6, "{turned}");
        assert_eq!(mesh.opacity(1, 0.2, 0.2), 0.5);
        let opaque = parse_text(&file("}", "", nodes, "")).unwrap();
        assert!(opaque.alphas().is_empty());
    }

    #[test]
    fn an_image_is_missed_only_where_alpha_needs_it() {
        let needed = file(TEXTURED, IMAGES, NODE, "");
        let error = parse_text(&needed).unwrap_err();
        assert!(error.to_string().contains("no leaf.png: cannot open"), "{error}");
        assert!(parse_text(&needed.replace("MASK", "OPAQUE")).is_ok());
        // Half of the texture is opaque, and the cutoff is applied after.
        let folder = tempfile::tempdir().unwrap();
        let image = std::fs::File::create(folder.path().join("no leaf.png")).unwrap();
        let mut encoder = png::Encoder::new(image, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[0, 0, 0, 255, 0, 0, 0, 150]).unwrap();
        writer.finish().unwrap();
        let sampler = r#""samplers": [{"magFilter": 9728}], "textures": [{"sampler": 0, "#;
        let cut = needed.replace(r#""textures": [{"#, sampler);
        let mesh = parse(cut.as_bytes(), folder.path()).unwrap();
        let opacities = [0.1, 0.9].map(|u| mesh.opacity(0, u, 0.05));
        assert_eq!(opacities, [1.0, 0.0]);
        let mesh = parse(cut.replace("MASK", "BLEND").as_bytes(), folder.path()).unwrap();
        assert_eq!(mesh.opacity(0, 0.1, 0.05), 0.5);
    }

    #[test]
    fn broken_files_are_refused() {
        let whole = file(BLEND, "", NODE, "");
        assert!(parse_text(&whole).is_ok());
        for (from, to) in [
            (r#""byteLength": 36"#, r#""byteLength": 35"#),
            (r#""byteLength": 36"#, r#""byteLength": 18446744073709551615"#),
            (r#""byteOffset": 36"#, r#""byteOffset": 18446744073709551615"#),
            (r#""byteLength": 64"#, r#""byteLength": 65"#),
            (r#""count": 3, "type": "VEC3""#, r#""count": 4, "type": "VEC3""#),
            (r#""count": 3, "type": "VEC3""#, r#""count": 2, "type": "VEC3""#),
            (r#""count": 3, "type": "VEC3""#, r#""count": 1152921504606846976, "type": "VEC3""#),
            (r#""type": "VEC3""#, r#""type": "VEC2""#),
            (
                r#""componentType": 5126, "count": 3, "type": "VEC3""#,
                r#""componentType": 5123, "count": 3, "type": "VEC3""#,
            ),
            (r#""componentType": 5121"#, r#""componentType": 5126"#),
            (
                r#"{"bufferView": 0, "componentType": 5126, "count": 3"#,
                r#"{"componentType": 5126, "count": 1152921504606846976"#,
            ),
            (r#"{"mesh": 0}"#, r#"{"mesh": 0, "children": [0]}"#),
            (r#"{"mesh": 0}"#, r#"{"children": [1, 1]}, {"mesh": 0}"#),
            (r#"{"mesh": 0}"#, r#"{"mesh": 7}"#),
            (r#""POSITION": 0"#, r#""POSITION": 3"#),
            (r#""TEXCOORD_0": 2"#, r#""TEXCOORD_0": 3"#),
            (r#""indices": 1"#, r#""indices": 3"#),
            (r#"{"mesh": 0}"#, r#"{"mesh": 0, "scale": [1e300, 1, 1]}"#),
            ("octet-stream;base64,", "octet-stream;base64,!"),
            ("data:application/octet-stream;base64,", "http://example.org/"),
            (r#""uri": "data"#, r#""name": "data"#),
        ] {
            assert!(whole.contains(from), "{from}");
            assert!(parse_text(&whole.replace(from, to)).is_err(), "{to}");
        }
        for length in (0..whole.len()).step_by(7) {
            assert!(parse_text(&whole[..length]).is_err(), "{length} bytes");
        }
        for stated in [0, 11, 12, 19, 20, 21, u32::MAX] {
            let header = [b"glTF\x02\0\0\0".as_slice(), &u32::to_le_bytes(stated)].concat();
            let glb = [header, vec![0; 8]].concat();
            assert!(parse(&glb, Path::new("")).is_err(), "{stated}");
        }
    }

    #[test]
    fn strips_and_fans_are_triangles_and_lines_are_not() {
        let of_mode = |mode: u32| {
            let primitive = format!(r#", "mode": {mode}"#);
            parse_text(&file(BLEND, "", NODE, &primitive)).unwrap().triangles().len()
        };
        assert_eq!([0, 1, 4, 5, 6].map(of_mode), [0, 0, 1, 1, 1]);
    }

    #[test]
    fn sparse_elements_take_their_places() {
        let text = file(BLEND, "", NODE, "").replace(
            r#"{"bufferView": 1, "componentType": 5121, "count": 3"#,
            r#"{"bufferView": 1, "componentType": 5121, "sparse": {"count": 1, "indices":
            {"bufferView": 1, "byteOffset": 1, "componentType": 5121},
            "values": {"bufferView": 1, "byteOffset": 2}}, "count": 3"#,
        );
        assert_eq!(parse_text(&text).unwrap().triangles(), [[0, 2, 2]]);
        let beyond = text
            .replace(r#""byteOffset": 1, "componentType""#, r#""byteOffset": 4, "componentType""#);
        assert!(parse_text(&beyond).is_err());
    }
}
