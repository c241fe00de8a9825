//! What is known of the extensions that a file names.

use super::json::Root;
use super::malformed;
use crate::error::Result;
use crate::load::warnings::Warnings;

/// Extensions that are followed where they change opacity or place.
const FOLLOWED: [&str; 9] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Extensions, by how their names begin, that change neither: lights, colours and
/// gloss, images that only matter where opacity is read from them, sound, physics,
/// names of things.
const HARMLESS: [&str; 34] = [
    "ADOBE_materials_",
    "AGI_",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "EXT_texture_",
    "FB_",
    "GODOT_",
    "GRIFFEL_",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_collision_shapes",
    "KHR_environment_map",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_",
    "KHR_texture_",
    "KHR_xmp",
    "MSFT_lod",
    "MSFT_packing_",
    "MSFT_physics",
    "MSFT_texture_dds",
    "NV_materials_",
    "OMI_",
    "VRM",
];

/// Refuses a file that can't be read without an extension that is not known, and
/// warns of others.
pub(super) fn check(root: &Root, warnings: &mut Warnings) -> Result<()> {
    let is_known = |name: &str| {
        FOLLOWED.contains(&name) || HARMLESS.iter().any(|begin| name.starts_with(begin))
    };
    if let Some(name) = root.extensions_required.iter().find(|name| !is_known(name)) {
        return Err(malformed(format!("needs extension {name:.80}, which is not supported")));
    }
    for name in root.extensions_used.iter().filter(|name| !is_known(name)) {
        warnings.add(format!("extension {name:.80} is not known and left out"));
    }
    Ok(())
}
