#!/usr/bin/env bash
# gltfpack 1.3.0, @gltf-transform/core and extensions 4.5.1, meshoptimizer 1.3.0 (npm).
#
# One mesh packed with -c, -cc and -cz, which the help calls compression, higher and higher still.
# Guess: three degrees of one format, EXT_meshopt_compression; a reader of the first reads all.
# Seen:  -c and -cc require EXT_meshopt_compression, -cz requires KHR_meshopt_compression (another version of the codec
#        behind another name), which glTF-Transform with all its extensions and the newest decoder refuses.
. "$(dirname "$0")/lib.sh"
node_with gltfpack@1.3.0 @gltf-transform/core@4.5.1 @gltf-transform/extensions@4.5.1 meshoptimizer@1.3.0
cd "$work"
cat > mesh.py <<'PY'
import base64, json, struct

points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (2, 0, 1), (2, 1, 1)]
indices = [0, 1, 2, 2, 1, 3, 1, 4, 3, 3, 4, 5]
data = b"".join(struct.pack("<3f", *point) for point in points) + struct.pack("<12H", *indices)
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": len(data),
                 "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    "bufferViews": [{"buffer": 0, "byteLength": 72}, {"buffer": 0, "byteOffset": 72, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3", "min": [0, 0, 0],
                   "max": [2, 1, 1]}, {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
}, open("mesh.gltf", "w"))
PY
python3 mesh.py
cat > node/read.mjs <<'JS'
import { readFileSync } from 'node:fs';
import { NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import { MeshoptDecoder } from 'meshoptimizer';
await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({ 'meshopt.decoder': MeshoptDecoder });
const seen = {};
for (const degree of ['c', 'cc', 'cz']) {
    try {
        const document = await io.readBinary(new Uint8Array(readFileSync(`../${degree}.glb`)));
        const used = document.getRoot().listExtensionsUsed().map(extension => extension.extensionName);
        const indices = document.getRoot().listMeshes()[0].listPrimitives()[0].getIndices().getCount();
        seen[degree] = `${used.find(name => name.includes('meshopt'))}, ${indices} indices`;
    } catch (error) {
        seen[degree] = error.message;
    }
}
console.log(JSON.stringify(seen));
JS
for degree in c cc cz; do
    (cd node && node node_modules/gltfpack/cli.js -i ../mesh.gltf -o "../$degree.glb" "-$degree")
done
(cd node && node read.mjs) > seen.json
python3 - <<'PY'
import json
from verdict import verdict

verdict("what glTF-Transform reads of -c, -cc, -cz", "EXT_meshopt_compression, 12 indices, three times",
        json.load(open("seen.json")),
        {"c": "EXT_meshopt_compression, 12 indices", "cc": "EXT_meshopt_compression, 12 indices",
         "cz": 'Missing required extension, "KHR_meshopt_compression".'})
PY
