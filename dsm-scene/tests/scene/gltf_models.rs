//! glTF files as programs write them, by the light that they stop.

use serde_json::json;

use crate::document::{Document, bytes_of};

#[track_caller]
fn check(document: Document, want: [f64; 2]) {
    let found = document.stopped();
    let near = (0..2).all(|half| (found.halves[half] - want[half]).abs() <= 0.004);
    assert!(near && found.warnings.is_empty(), "{want:?} and not {found:?}");
}

const LEFT: [f64; 2] = [1.0, 0.0];
const RIGHT: [f64; 2] = [0.0, 1.0];

#[test]
fn extensions_without_a_say_are_accepted() {
    for extension in [
        "KHR_lights_punctual",
        "KHR_materials_unlit",
        "KHR_materials_ior",
        "KHR_materials_emissive_strength",
        "KHR_materials_variants",
        "KHR_materials_specular",
        "KHR_materials_clearcoat",
        "KHR_materials_sheen",
        "KHR_materials_iridescence",
        "KHR_materials_volume",
        "KHR_materials_dispersion",
        "KHR_materials_anisotropy",
        "KHR_texture_transform",
        "KHR_texture_basisu",
        "KHR_xmp_json_ld",
        "EXT_texture_webp",
        "EXT_structural_metadata",
    ] {
        let mut document = Document::new();
        document.require(extension);
        document.json["extensions"][extension] = json!({"lights": [{"type": "point"}]});
        document.material(json!({"extensions": {extension: {"any": [1, "thing"]}}}));
        document.json["nodes"][0]["extensions"][extension] = json!({"light": 0});
        check(document, LEFT);
    }
    let mut document = Document::new();
    document.require("EXT_of_nobody");
    assert!(document.error().contains("needs extension EXT_of_nobody, which is not supported"));
    let mut document = Document::new();
    document.json["extensionsUsed"] = json!(["EXT_of_nobody"]);
    assert!(document.stopped().warnings[0].contains("EXT_of_nobody"));
    let mut document = Document::new();
    let transmission = json!({"KHR_materials_transmission": {"transmissionFactor": 0.9}});
    document.material(json!({"name": "glass", "extensions": transmission}));
    let found = document.stopped();
    assert_eq!(found.halves, LEFT);
    assert!(found.warnings[0].contains("material 0 (glass): transmission"), "{found:?}");
}

#[test]
fn what_is_not_needed_may_be_odd() {
    let mut document = Document::new();
    let values = document.floats("SCALAR", &[0.0; 4]);
    document.attribute("_TEMPERATURE", values);
    document.attribute("COLOR_7", 99);
    document.json["meshes"][0]["extras"] = json!({"any": null});
    document.json["cameras"] = json!(3);
    check(document, LEFT);
    for texture in [
        json!({}),
        json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}),
        json!({"extensions": {"EXT_texture_avif": {"source": 7}}, "sampler": 9}),
    ] {
        let mut document = Document::new();
        document.json["images"] = json!([{"uri": "colour.ktx2", "mimeType": "image/ktx2"}]);
        document.json["textures"] = json!([texture]);
        let colour = json!({"baseColorTexture": {"index": 0}});
        document.material(json!({"pbrMetallicRoughness": colour}));
        check(document, LEFT);
    }
    // Whole numbers as doubles.
    let mut document = Document::new();
    document.json["nodes"][0]["mesh"] = json!(0.0);
    document.json["accessors"][0]["count"] = json!(4.0);
    check(document, LEFT);
}

#[test]
fn draco_is_refused_by_the_name_of_the_mesh() {
    let mut document = Document::new();
    document.require("KHR_draco_mesh_compression");
    document.json["meshes"][0]["name"] = json!("oak");
    document.json["accessors"][0]["bufferView"].take();
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    document.json["meshes"][0]["primitives"][0]["extensions"] = draco;
    let error = document.error();
    assert!(
        error.ends_with("mesh 0 (oak) primitive 0: Draco compression is not supported"),
        "{error}"
    );
    // One that is not drawn, and one that has its vertices otherwise, too.
    let mut document = Document::new();
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    document.json["meshes"][0]["primitives"][0]["extensions"] = draco;
    check(document, LEFT);
}

#[test]
fn nodes_are_placed_hidden_and_repeated() {
    let mut document = Document::new();
    document.json["nodes"] = json!([
        {"translation": [1, 0, 0], "children": [1]},
        {"mesh": 0},
    ]);
    check(document, RIGHT);
    for (visible, want) in [(false, LEFT), (true, [1.0, 1.0])] {
        let mut document = Document::new();
        document.json["scenes"][0]["nodes"] = json!([0, 1]);
        document.json["nodes"] = json!([
            {"mesh": 0},
            {"children": [2], "extensions": {"KHR_node_visibility": {"visible": visible}}},
            {"mesh": 0, "translation": [1, 0, 0]},
        ]);
        check(document, want);
    }
    let mut document = Document::new();
    document.require("EXT_mesh_gpu_instancing");
    let places = document.floats("VEC3", &[-0.5, 0.5, 0.0, 0.0, -0.5, 0.0]);
    let scales = document.floats("VEC3", &[0.5, 0.5, 1.0, -0.5, 0.5, 1.0]);
    // By a half turn, as normalised integers: about y.
    let turns = document.accessor("VEC4", 5122, 2, &bytes_of(&[0, 32767, 0, 0, 0, 0, 0, 32767]));
    let attributes = json!({"TRANSLATION": places, "SCALE": scales, "ROTATION": turns});
    document.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    // x from −0.5 to 0 and y from 0 to 1; x from 0 to 0.5 and y from −1 to 0.
    check(document, [0.25, 0.25]);
}

#[test]
fn quantised_meshes_are_read() {
    for (component, corners, normalized, scale) in [
        (
            5122,
            bytes_of(&[
                0x8001, 0x8001, 0, 0, 0, 0x8001, 0, 0, 0, 0x7fff, 0, 0, 0x8001, 0x7fff, 0, 0,
            ]),
            true,
            1.0,
        ),
        (
            5122,
            bytes_of(&[0xff9c, 0xff9c, 0, 0, 0, 0xff9c, 0, 0, 0, 100, 0, 0, 0xff9c, 100, 0, 0]),
            false,
            0.01,
        ),
        (5120, vec![0x81, 0x81, 0, 0, 0, 0x81, 0, 0, 0, 127, 0, 0, 0x81, 127, 0, 0], true, 1.0),
    ] {
        let mut document = Document::new();
        document.require("KHR_mesh_quantization");
        let size = corners.len() / 4;
        let positions = document.accessor("VEC3", component, 4, &corners);
        document.json["accessors"][positions]["normalized"] = json!(normalized);
        let view = document.json["accessors"][positions]["bufferView"].as_u64().unwrap();
        document.json["bufferViews"][view as usize]["byteStride"] = json!(size);
        document.attribute("POSITION", positions);
        document.json["nodes"][0]["scale"] = json!([scale, scale, 1.0]);
        check(document, LEFT);
    }
}

#[test]
fn skins_and_morph_targets_are_at_rest() {
    let right = [1.0, 0.0, 0.0].repeat(4);
    for (mesh, node, want) in [
        (json!([1.0]), None, RIGHT),
        (json!([]), None, LEFT),
        (json!([1.0]), Some(json!([0.0])), LEFT),
        (json!([0.0]), Some(json!([1.0])), RIGHT),
    ] {
        let mut document = Document::new();
        let target = document.floats("VEC3", &right);
        document.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
        document.json["meshes"][0]["weights"] = mesh;
        if let Some(weights) = node {
            document.json["nodes"][0]["weights"] = weights;
        }
        check(document, want);
    }
    // A target in a sparse accessor that has no others.
    let mut document = Document::new();
    let values = document.floats("VEC3", &right);
    let indices = document.accessor("SCALAR", 5121, 4, &[0, 1, 2, 3]);
    let view = |accessor: usize| document.json["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({"count": 4, "values": {"bufferView": view(values)},
        "indices": {"bufferView": view(indices), "componentType": 5121}});
    document.json["accessors"][values]["sparse"] = sparse;
    document.json["accessors"][values].as_object_mut().unwrap().remove("bufferView");
    document.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": values}]);
    document.json["meshes"][0]["weights"] = json!([1.0]);
    check(document, RIGHT);
    // The joint moves by 2, the bind pose back by 1; the mesh's own node counts for nothing.
    let mut document = Document::new();
    let joints = document.accessor("VEC4", 5121, 4, &[0, 1, 0, 0].repeat(4));
    let weights = document.accessor("VEC4", 5121, 4, &[255, 0, 0, 0].repeat(4));
    document.json["accessors"][weights]["normalized"] = json!(true);
    let mut unbind = glam::Mat4::from_translation(-glam::Vec3::X).to_cols_array().to_vec();
    unbind.extend([0.0; 16]);
    let unbind = document.floats("MAT4", &unbind);
    document.attribute("JOINTS_0", joints);
    document.attribute("WEIGHTS_0", weights);
    document.json["scenes"][0]["nodes"] = json!([1]);
    document.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [0, 9, 0]},
        {"children": [0, 2], "translation": [1, 0, 0]},
        {"translation": [1, 0, 0], "children": [3]},
        {},
    ]);
    document.json["skins"] = json!([{"joints": [2, 3], "inverseBindMatrices": unbind}]);
    check(document, RIGHT);
}

#[test]
fn alpha_comes_from_the_factor_the_texture_and_the_vertices() {
    let quarter = [1.0, 0.5, 0.0, 0.25].repeat(4);
    for (mode, factor, want) in [
        (json!({"alphaMode": "BLEND"}), 1.0, 0.25),
        (json!({"alphaMode": "BLEND"}), 0.5, 0.125),
        (json!({"alphaMode": "MASK"}), 1.0, 0.0),
        (json!({"alphaMode": "MASK", "alphaCutoff": 0.25}), 1.0, 1.0),
        (json!({"alphaMode": "OPAQUE"}), 0.5, 1.0),
        (json!({}), 0.5, 1.0),
    ] {
        let mut document = Document::new();
        let colours = document.floats("VEC4", &quarter);
        document.attribute("COLOR_0", colours);
        let mut material = mode.clone();
        material["pbrMetallicRoughness"] = json!({"baseColorFactor": [1, 1, 1, factor]});
        document.material(material);
        check(document, [want, 0.0]);
    }
    let mut document = Document::new();
    let colours = document.accessor("VEC4", 5123, 4, &bytes_of(&[0, 0, 0, 13107].repeat(4)));
    document.json["accessors"][colours]["normalized"] = json!(true);
    document.attribute("COLOR_0", colours);
    document.material(json!({"alphaMode": "BLEND"}));
    check(document, [0.2, 0.0]);
    // Colours without alpha; and none where there is no material.
    let mut document = Document::new();
    let colours = document.floats("VEC3", &[0.1; 12]);
    document.attribute("COLOR_0", colours);
    document.material(json!({"alphaMode": "BLEND"}));
    check(document, LEFT);
    let gloss = json!({"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 1, 1, 0.75]}});
    let mut document = Document::new();
    document.require("KHR_materials_pbrSpecularGlossiness");
    document.material(json!({"alphaMode": "BLEND", "extensions": gloss,
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.1]}}));
    check(document, [0.75, 0.0]);
}

#[test]
fn textures_are_moved_and_of_several_formats() {
    // Opaque above, half below.
    let pixels: Vec<u8> =
        (0..64 * 64).flat_map(|at| [0, 0, 0, if at < 64 * 32 { 255 } else { 51 }]).collect();
    for (format, extension) in
        [(image::ImageFormat::Png, None), (image::ImageFormat::WebP, Some("EXT_texture_webp"))]
    {
        for (transform, want) in [
            (json!({}), 0.6),
            (json!({"offset": [0, 0.5], "scale": [1, 0.5]}), 0.2),
            (json!({"offset": [0, 0.25], "scale": [1, 0.25]}), 1.0),
            (json!({"texCoord": 1}), 0.2),
        ] {
            let mut encoded = std::io::Cursor::new(Vec::new());
            let rgba = image::ExtendedColorType::Rgba8;
            image::write_buffer_with_format(&mut encoded, &pixels, 64, 64, rgba, format).unwrap();
            let mut document = Document::new();
            let encoded = encoded.into_inner();
            let bytes = document.accessor("SCALAR", 5121, encoded.len(), &encoded);
            let below = document.floats("VEC2", &[0.5, 0.75].repeat(4));
            document.attribute("TEXCOORD_1", below);
            document.json["images"] = json!([{"bufferView": bytes}]);
            document.json["samplers"] = json!([{"magFilter": 9728}]);
            document.json["textures"] = match extension {
                None => json!([{"source": 0, "sampler": 0}]),
                Some(name) => json!([{"sampler": 0, "extensions": {name: {"source": 0}}}]),
            };
            let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
            document.material(json!({"alphaMode": "BLEND",
                "pbrMetallicRoughness": {"baseColorTexture": info}}));
            check(document, [want, 0.0]);
        }
    }
    // One that is needed, and has no image.
    let mut document = Document::new();
    document.json["textures"] = json!([{}]);
    document.material(json!({"alphaMode": "BLEND",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    assert!(document.stopped().warnings[0].contains("texture 0 has no image"));
}

#[test]
fn strips_fans_and_what_is_no_surface() {
    for (mode, corners, want) in [
        (4, vec![0_u16, 1, 2, 0, 2, 3], LEFT),
        (5, vec![0, 1, 3, 2], LEFT),
        (6, vec![0, 1, 2, 3], LEFT),
    ] {
        let mut document = Document::new();
        let indices = document.accessor("SCALAR", 5123, corners.len(), &bytes_of(&corners));
        document.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        document.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        check(document, want);
    }
    for mode in 0..4 {
        let mut document = Document::new();
        document.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let found = document.stopped();
        assert_eq!(found.halves, [0.0; 2]);
        assert!(found.warnings[0].contains("no surface"), "{found:?}");
    }
    let mut document = Document::new();
    document.json["animations"] = json!([{"channels": [], "samplers": []}]);
    assert!(document.stopped().warnings[0].contains("animations are not applied"));
}
