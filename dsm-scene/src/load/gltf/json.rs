//! The parts of a glTF document that say where surfaces are and how opaque.
//!
//! Everything else is passed over, known or not. No index is checked here.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize as Derive;
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, Visitor};

/// A whole number that is not negative: an index, a length, an offset. JSON may write
/// it as 12, 12.0 or 1.2e1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Whole(pub(super) usize);

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Number;
        impl Visitor<'_> for Number {
            type Value = Whole;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number that is not negative")
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Whole, E> {
                usize::try_from(value).map(Whole).map_err(E::custom)
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Whole, E> {
                // Those that a double holds exactly.
                if value.fract() == 0.0 && (0.0..=9e15).contains(&value) {
                    self.visit_u64(value as u64)
                } else {
                    Err(E::custom(format!("{value} is not a whole number of that kind")))
                }
            }
        }
        deserializer.deserialize_any(Number)
    }
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Root {
    pub(super) asset: Asset,
    pub(super) scene: Option<Whole>,
    pub(super) scenes: Vec<Scene>,
    pub(super) nodes: Vec<Node>,
    pub(super) meshes: Vec<Mesh>,
    pub(super) skins: Vec<Skin>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) buffer_views: Vec<BufferView>,
    pub(super) buffers: Vec<Buffer>,
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    pub(super) samplers: Vec<Sampler>,
    pub(super) images: Vec<Image>,
    /// Read when one is asked for, as [`Animation`].
    pub(super) animations: Vec<serde_json::Value>,
    pub(super) extensions_used: Vec<String>,
    pub(super) extensions_required: Vec<String>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Asset {
    pub(super) version: String,
    pub(super) min_version: Option<String>,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct Scene {
    pub(super) nodes: Vec<Whole>,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct Node {
    pub(super) children: Vec<Whole>,
    pub(super) mesh: Option<Whole>,
    pub(super) skin: Option<Whole>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) weights: Option<Vec<f32>>,
    pub(super) extensions: NodeExtensions,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub(super) visibility: Option<Visibility>,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct Instancing {
    pub(super) attributes: BTreeMap<String, Whole>,
}

#[derive(Debug, Derive)]
#[serde(default)]
pub(super) struct Visibility {
    pub(super) visible: bool,
}

impl Default for Visibility {
    fn default() -> Self {
        Self { visible: true }
    }
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    pub(super) primitives: Vec<Primitive>,
    pub(super) weights: Vec<f32>,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<String, Whole>,
    pub(super) indices: Option<Whole>,
    pub(super) material: Option<Whole>,
    pub(super) mode: Option<Whole>,
    pub(super) targets: Vec<BTreeMap<String, Whole>>,
    pub(super) extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<IgnoredAny>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Skin {
    pub(super) joints: Vec<Whole>,
    pub(super) inverse_bind_matrices: Option<Whole>,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct Animation {
    pub(super) channels: Vec<Channel>,
    pub(super) samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Derive)]
pub(super) struct Channel {
    pub(super) sampler: Whole,
    pub(super) target: ChannelTarget,
}

#[derive(Debug, Derive)]
pub(super) struct ChannelTarget {
    pub(super) node: Option<Whole>,
    pub(super) path: String,
    #[serde(default)]
    pub(super) extensions: ChannelExtensions,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct ChannelExtensions {
    #[serde(rename = "KHR_animation_pointer")]
    pub(super) pointer: Option<Pointer>,
}

#[derive(Debug, Derive)]
pub(super) struct Pointer {
    pub(super) pointer: String,
}

#[derive(Debug, Derive)]
pub(super) struct AnimationSampler {
    pub(super) input: Whole,
    pub(super) output: Whole,
    pub(super) interpolation: Option<String>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<Whole>,
    pub(super) byte_offset: Whole,
    pub(super) component_type: Whole,
    pub(super) normalized: bool,
    pub(super) count: Whole,
    #[serde(rename = "type")]
    pub(super) dimensions: String,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Debug, Derive)]
pub(super) struct Sparse {
    pub(super) count: Whole,
    pub(super) indices: SparseView,
    pub(super) values: SparseView,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseView {
    pub(super) buffer_view: Whole,
    #[serde(default)]
    pub(super) byte_offset: Whole,
    #[serde(default)]
    pub(super) component_type: Whole,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: Whole,
    pub(super) byte_offset: Whole,
    pub(super) byte_length: Whole,
    pub(super) byte_stride: Option<Whole>,
    pub(super) extensions: ViewExtensions,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<Meshopt>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Meshopt {
    pub(super) buffer: Whole,
    pub(super) byte_offset: Whole,
    pub(super) byte_length: Whole,
    pub(super) byte_stride: Whole,
    pub(super) count: Whole,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) byte_length: Whole,
    pub(super) uri: Option<String>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Material {
    pub(super) name: Option<String>,
    pub(super) alpha_mode: Option<String>,
    pub(super) alpha_cutoff: Option<f32>,
    pub(super) pbr_metallic_roughness: MetallicRoughness,
    pub(super) extensions: MaterialExtensions,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct MetallicRoughness {
    pub(super) base_color_factor: Option<[f32; 4]>,
    pub(super) base_color_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(super) specular_glossiness: Option<SpecularGlossiness>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(super) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_diffuse_transmission")]
    pub(super) diffuse_transmission: Option<DiffuseTransmission>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct SpecularGlossiness {
    pub(super) diffuse_factor: Option<[f32; 4]>,
    pub(super) diffuse_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Transmission {
    pub(super) transmission_factor: f32,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct DiffuseTransmission {
    pub(super) diffuse_transmission_factor: f32,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub(super) index: Whole,
    #[serde(default)]
    pub(super) tex_coord: Whole,
    #[serde(default)]
    pub(super) extensions: TextureInfoExtensions,
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<TextureTransform>,
}

#[derive(Debug, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct TextureTransform {
    pub(super) offset: [f32; 2],
    pub(super) rotation: f32,
    pub(super) scale: [f32; 2],
    pub(super) tex_coord: Option<Whole>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct Texture {
    pub(super) sampler: Option<Whole>,
    pub(super) source: Option<Whole>,
    pub(super) extensions: TextureExtensions,
}

/// Other images than `source`, of which one is read.
#[derive(Debug, Default, Derive)]
#[serde(default)]
pub(super) struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub(super) webp: Option<TextureSource>,
    #[serde(rename = "KHR_texture_basisu")]
    pub(super) basis: Option<TextureSource>,
    #[serde(rename = "EXT_texture_avif")]
    pub(super) avif: Option<TextureSource>,
    #[serde(rename = "MSFT_texture_dds")]
    pub(super) dds: Option<TextureSource>,
}

#[derive(Debug, Derive)]
pub(super) struct TextureSource {
    pub(super) source: Option<Whole>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Sampler {
    pub(super) mag_filter: Option<Whole>,
    pub(super) wrap_s: Option<Whole>,
    pub(super) wrap_t: Option<Whole>,
}

#[derive(Debug, Default, Derive)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Image {
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<Whole>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_written_in_several_ways() {
        let read = |text: &str| serde_json::from_str::<Whole>(text).map(|number| number.0);
        for (text, want) in [("12", 12), ("12.0", 12), ("1.2e1", 12), ("0", 0)] {
            assert_eq!(read(text).unwrap(), want, "{text}");
        }
        for text in ["-1", "1.5", "1e300", "-0.5", "\"1\"", "null", "18446744073709551616"] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
