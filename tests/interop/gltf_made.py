"""glTF files of many kinds, as models_made.py has OBJ and PLY; of animated ones a time and what is there at that time.

`KINDS` maps a name to a function of a random generator and a folder, which returns a path, polygons, and the keys of a
scene's object.
"""

import base64
import json
import struct

import numpy as np

PARTS = {"u1": 5121, "i1": 5120, "u2": 5123, "i2": 5122, "f4": 5126}


class Document:
    def __init__(self):
        self.views, self.accessors, self.data = [], [], b""
        self.extra = {}

    def view(self, data, **more):
        self.data += b"\0" * (-len(self.data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more})
        self.data += data
        return len(self.views) - 1

    def accessor(self, kind, array, part="f4", **more):
        array = np.ascontiguousarray(array, "<" + part)
        entry = {"bufferView": self.view(array.tobytes()), "componentType": PARTS[part], "count": len(array), "type": kind}
        if kind == "VEC3" and part == "f4":
            entry |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        self.accessors.append(entry | more)
        return len(self.accessors) - 1

    def write(self, path, nodes, primitive, roots=None, mesh=None, **more):
        root = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": roots or list(range(len(nodes)))}],
            "nodes": nodes,
            "meshes": [{"primitives": [primitive], **(mesh or {})}],
            "accessors": self.accessors,
            "bufferViews": self.views,
            **more,
        }
        if path.suffix == ".gltf":
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
            root["buffers"] = [{"byteLength": len(self.data), "uri": uri}]
            path.write_text(json.dumps(root))
            return path
        root["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(root).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
        path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)
        return path


BOX = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def placed(rng):
    """A node in the plane, and what it makes of the box."""
    angle, scale, move = rng.uniform(0, 6), rng.uniform(0.2, 0.7), rng.uniform(-0.5, 0.5, 2)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    node = {
        "translation": [*move, 0.0],
        "rotation": [0, 0, np.sin(angle / 2), np.cos(angle / 2)],
        "scale": [scale] * 3,
    }
    return node, scale * BOX @ turn + move


def gltf(rng, folder, kind):
    document = Document()
    corners = np.concatenate([BOX, np.zeros((4, 1))], 1)
    primitive = {"attributes": {}, "indices": None}
    indices, more, mesh, roots, opacity = [0, 1, 2, 0, 2, 3], {}, None, None, 1.0
    nodes, polygons = [], []
    for _ in range(int(rng.integers(1, 4))):
        node, polygon = placed(rng)
        nodes.append({"mesh": 0, **node})
        polygons.append(polygon)
    if kind == "strips":
        indices, primitive["mode"] = [0, 1, 3, 2], 5
    if kind == "fans":
        indices, primitive["mode"] = [0, 1, 2, 3], 6
    if kind == "quantised":
        data = np.zeros((4, 4), "<i2")
        data[:, :3] = np.round(corners * 32767)
        view = document.view(data.tobytes(), byteStride=8)
        document.accessors.append(
            {"bufferView": view, "componentType": 5122, "count": 4, "type": "VEC3", "normalized": True}
        )
        primitive["attributes"]["POSITION"] = 0
        more["extensionsUsed"] = more["extensionsRequired"] = ["KHR_mesh_quantization"]
    elif kind == "sparse":
        wrong = corners.copy()
        wrong[1:3] = 9
        at = document.accessor("VEC3", wrong)
        places = document.view(np.array([1, 2], "<u2").tobytes())
        values = document.view(corners[1:3].astype("<f4").tobytes())
        document.accessors[at]["sparse"] = {
            "count": 2,
            "indices": {"bufferView": places, "componentType": 5123},
            "values": {"bufferView": values},
        }
        primitive["attributes"]["POSITION"] = at
    else:
        moved = corners - [9, 9, 0] if kind in ("morph targets", "skins") else corners
        primitive["attributes"]["POSITION"] = document.accessor("VEC3", moved)
    if kind == "morph targets":
        target = document.accessor("VEC3", np.tile([18.0, 18, 0], (4, 1)))
        primitive["targets"], mesh = [{"POSITION": target}], {"weights": [0.5]}
    if kind == "skins":
        # Bound 9 to the left and below; the joint stands where the first node would.
        unbind = np.eye(4, dtype=np.float32)
        unbind[3, :2] = 9
        skin = document.accessor("MAT4", unbind.reshape(1, 16))
        primitive["attributes"]["JOINTS_0"] = document.accessor("VEC4", np.zeros((4, 4)), "u1")
        weights = np.tile([255, 0, 0, 0], (4, 1))
        primitive["attributes"]["WEIGHTS_0"] = document.accessor("VEC4", weights, "u1", normalized=True)
        joint = {key: value for key, value in nodes[0].items() if key != "mesh"}
        nodes, polygons = [{"mesh": 0, "skin": 0, "translation": [3, 4, 5]}, joint], polygons[:1]
        more["skins"] = [{"joints": [1], "inverseBindMatrices": skin}]
    if kind == "instances":
        columns = [np.array([node[key] for node in nodes]) for key in ("translation", "rotation", "scale")]
        kinds = zip(("TRANSLATION", "ROTATION", "SCALE"), ("VEC3", "VEC4", "VEC3"), columns)
        attributes = {name: document.accessor(width, column) for name, width, column in kinds}
        nodes = [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]
        more["extensionsUsed"] = more["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    if kind == "visibility":
        nodes[-1]["extensions"] = {"KHR_node_visibility": {"visible": False}}
        more["extensionsUsed"], polygons = ["KHR_node_visibility"], polygons[:-1]
    if kind == "trees":
        # A chain: each stands on the one before.
        nodes, polygons, inner = [], [], np.eye(3)
        for depth in range(3):
            node, _ = placed(rng)
            angle, scale = 2 * np.arctan2(node["rotation"][2], node["rotation"][3]), node["scale"][0]
            scale = node["scale"][0] = scale + 0.4
            node["scale"] = [scale] * 3
            move = node["translation"][:2]
            cos, sin = scale * np.cos(angle), scale * np.sin(angle)
            inner = inner @ np.array([[cos, -sin, move[0]], [sin, cos, move[1]], [0, 0, 1]])
            if depth < 2:
                node["children"] = [depth + 1]
            nodes.append(node)
        nodes[2]["mesh"], roots = 0, [0]
        polygons = [(inner @ np.concatenate([BOX, np.ones((4, 1))], 1).T).T[:, :2]]
    if kind in ("vertex alpha", "mask", "factor", "glossiness"):
        opacity = round(float(rng.uniform(0.1, 0.9)), 3)
        material = {"alphaMode": "BLEND"}
        if kind in ("vertex alpha", "mask"):
            colours = np.tile([1, 0.5, 0, opacity], (4, 1))
            primitive["attributes"]["COLOR_0"] = document.accessor("VEC4", colours)
        if kind == "mask":
            material = {"alphaMode": "MASK", "alphaCutoff": 0.5}
            opacity = float(opacity >= 0.5)
        if kind == "factor":
            material["pbrMetallicRoughness"] = {"baseColorFactor": [1, 1, 1, opacity]}
        if kind == "glossiness":
            gloss = {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 1, 1, opacity]}}
            material["extensions"], more["extensionsUsed"] = gloss, list(gloss)
        more["materials"], primitive["material"] = [material], 0
    if kind == "lights required":
        more["extensionsUsed"] = more["extensionsRequired"] = ["KHR_lights_punctual"]
        more["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
        nodes.append({"extensions": {"KHR_lights_punctual": {"light": 0}}})
    if kind == "custom attributes":
        primitive["attributes"]["_HEAT"] = document.accessor("SCALAR", np.arange(4))
    primitive["indices"] = document.accessor("SCALAR", indices, "u2")
    name = "a.gltf" if rng.integers(2) else "a.glb"
    path = document.write(folder / name, nodes, primitive, roots, mesh, **more)
    return path, [(polygon, opacity) for polygon in polygons]


KINDS = {
    kind: (lambda rng, folder, kind=kind: gltf(rng, folder, kind))
    for kind in (
        "nodes",
        "trees",
        "strips",
        "fans",
        "quantised",
        "sparse",
        "morph targets",
        "skins",
        "instances",
        "visibility",
        "factor",
        "vertex alpha",
        "mask",
        "glossiness",
        "lights required",
        "custom attributes",
    )
}
