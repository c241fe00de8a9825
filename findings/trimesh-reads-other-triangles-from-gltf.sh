#!/usr/bin/env bash
# trimesh 5.2.0 (PyPI), its glTF reader.
#
# A square of core glTF 2.0, as two triangles and as a fan; with a point moved by a sparse accessor; with positions in
# 16-bit integers (KHR_mesh_quantization, normalised, required); three times by EXT_mesh_gpu_instancing (required).
# Guess: each is read as the specification says, or refused where an extension that the file requires is not known.
# Seen:  none is refused or warned of, and four of five are other surfaces: the fan has no area, the moved point stays
#        where it was, 16-bit positions are 32767 times too large, instances stand there once.
. "$(dirname "$0")/lib.sh"
python_with trimesh==5.2.0 numpy==2.4.6
cat > "$work/square.py" <<'PY'
import base64, json, struct
import numpy as np, trimesh
from verdict import verdict

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], "<f4")

class File:
    """A glTF file with one node, put together from accessors."""

    def __init__(self):
        self.data, self.views, self.accessors = b"", [], []

    def view(self, values):
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.tobytes() + bytes(-values.nbytes % 4)
        return len(self.views) - 1

    def add(self, values, component, kind, **more):
        self.accessors.append({"bufferView": self.view(values), "componentType": component, "count": len(values),
                               "type": kind, **more})
        return len(self.accessors) - 1

    def area(self, primitive, node=None, required=()):
        document = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, **(node or {})}],
            "meshes": [{"primitives": [primitive]}], "bufferViews": self.views, "accessors": self.accessors,
            "extensionsUsed": list(required), "extensionsRequired": list(required),
            "buffers": [{"byteLength": len(self.data),
                         "uri": "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()}],
        }
        if not required:
            del document["extensionsUsed"], document["extensionsRequired"]
        path = "square.gltf"
        json.dump(document, open(path, "w"))
        return round(float(trimesh.load(path).to_geometry().area), 4)

def points(file, values=SQUARE, component=5126, **more):
    return file.add(values, component, "VEC3", min=values.min(0).tolist(), max=values.max(0).tolist(), **more)

def triangles(file):
    return file.add(np.array([0, 1, 2, 0, 2, 3], "<u2"), 5123, "SCALAR")

seen = {}
file = File()
seen["triangles"] = file.area({"attributes": {"POSITION": points(file)}, "indices": triangles(file)})
file = File()
seen["fan"] = file.area({"attributes": {"POSITION": points(file)}, "mode": 6})
file = File()
at = points(file)
file.accessors[at]["sparse"] = {
    "count": 1,
    "indices": {"bufferView": file.view(np.array([2], "<u2")), "componentType": 5123},
    "values": {"bufferView": file.view(np.array([(3, 3, 0)], "<f4"))},
}
file.accessors[at]["max"] = [3, 3, 0]
seen["sparse"] = file.area({"attributes": {"POSITION": at}, "indices": triangles(file)})
file = File()
short = np.zeros((4, 4), "<i2")
short[:, :3] = SQUARE * 32767
at = file.add(short, 5122, "VEC3", min=[0, 0, 0], max=[32767, 32767, 0], normalized=True)
file.views[-1]["byteStride"] = 8
seen["normalised"] = file.area({"attributes": {"POSITION": at}, "indices": triangles(file)},
                               required=["KHR_mesh_quantization"])
file = File()
moves = np.array([(0, 0, 0), (2, 0, 0), (4, 0, 0)], "<f4")
at = file.add(moves, 5126, "VEC3")
seen["instances"] = file.area(
    {"attributes": {"POSITION": points(file)}, "indices": triangles(file)},
    {"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": at}}}},
    ["EXT_mesh_gpu_instancing"],
)
verdict("the areas", "1, 1, 3, 1, 3", seen,
        {"triangles": 1.0, "fan": 0.0, "sparse": 1.0, "normalised": 1073676289.0, "instances": 1.0})
PY
cd "$work" && "$python" square.py
