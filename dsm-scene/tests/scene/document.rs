//! glTF documents to be changed.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::light::{Stopped, stopped_by};

/// A document of one mesh over the left half of the square, to be changed.
pub(crate) struct Document {
    pub(crate) json: Value,
    bytes: Vec<u8>,
}

impl Document {
    pub(crate) fn new() -> Self {
        let mut document = Self {
            json: json!({
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {}}]}],
                "accessors": [],
                "bufferViews": [],
            }),
            bytes: Vec::new(),
        };
        let corners = [[-1.0, -1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let positions = document.floats("VEC3", &corners.concat());
        let indices = document.accessor("SCALAR", 5123, 6, &bytes_of(&[0, 1, 2, 0, 2, 3]));
        let uvs = document.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let primitive = &mut document.json["meshes"][0]["primitives"][0];
        primitive["attributes"] = json!({"POSITION": positions, "TEXCOORD_0": uvs});
        primitive["indices"] = json!(indices);
        document
    }

    /// Adds an accessor of these bytes.
    pub(crate) fn accessor(
        &mut self,
        kind: &str,
        component: u32,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(view);
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind}),
        );
        accessors.len() - 1
    }

    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(kind, 5126, values.len() / width, &bytes)
    }

    pub(crate) fn attribute(&mut self, name: &str, accessor: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    pub(crate) fn material(&mut self, material: Value) {
        self.json["materials"] = json!([material]);
        self.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    }

    pub(crate) fn require(&mut self, extension: &str) {
        self.json["extensionsUsed"] = json!([extension]);
        self.json["extensionsRequired"] = json!([extension]);
    }

    pub(crate) fn write(&mut self, path: &Path) {
        let data = STANDARD.encode(&self.bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        self.json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        std::fs::write(path, self.json.to_string()).unwrap();
    }

    pub(crate) fn stopped(mut self) -> Stopped {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        self.write(&path);
        stopped_by(&path).unwrap()
    }

    pub(crate) fn error(mut self) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        self.write(&path);
        stopped_by(&path).unwrap_err().to_string()
    }
}

/// The bytes of integers in a file.
pub(crate) fn bytes_of(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}
