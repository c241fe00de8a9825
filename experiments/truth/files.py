"""The models' files, read and written anew here: .obj, .hair and .glb."""

import io
import json
import struct
from pathlib import Path

import numpy as np
from PIL import Image

from geometry import BLEND, MASK, OPAQUE, Material, Mesh, Strands

GL_CLAMP, GL_MIRROR, GL_NEAREST = 33071, 33648, 9728


def read_obj(path):
    positions, triangles = [], []
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            positions.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
            triangles += [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
    return Mesh(np.array(positions, "f4"), np.array(triangles, "u4"))


def write_obj(path, mesh):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.positions.astype(float).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (mesh.triangles + 1).tolist()]
    Path(path).write_text("\n".join(lines) + "\n")


def read_hair(path, thickness):
    data = Path(path).read_bytes()
    strands, points, flags, segments = struct.unpack_from("<4s4I", data)[1:]
    at = 128
    counts = np.full(strands, segments + 1)
    if flags & 1:
        counts = np.frombuffer(data, "<u2", strands, at).astype(int) + 1
        at += 2 * strands
    return Strands(np.frombuffer(data, "<f4", 3 * points, at).reshape(-1, 3), counts, thickness)


def write_hair(path, hair):
    head = struct.pack("<4s4I5f", b"HAIR", len(hair.counts), len(hair.points), 3, 0, hair.thickness, 0, 1, 1, 1)
    segments = (hair.counts - 1).astype("<u2").tobytes()
    Path(path).write_bytes(head + bytes(128 - len(head)) + segments + hair.points.astype("<f4").tobytes())


def read_glb(path):
    """The meshes of a file whose nodes stand where they are: one a primitive."""
    data = Path(path).read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    binary = data[28 + size :]
    if any(key in node for node in document["nodes"] for key in ("matrix", "scale")):
        raise ValueError(f"{path}: nodes with transforms")

    def view(number):
        own = document["bufferViews"][number]
        start = own.get("byteOffset", 0)
        return binary[start : start + own["byteLength"]]

    def accessor(number):
        own = document["accessors"][number]
        dtype = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[own["componentType"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[own["type"]]
        values = np.frombuffer(view(own["bufferView"]), dtype, own["count"] * width, own.get("byteOffset", 0))
        return values.reshape(-1, width) if width > 1 else values

    def material(number):
        own = document["materials"][number] if number is not None else {}
        mode = {"OPAQUE": OPAQUE, "MASK": MASK, "BLEND": BLEND}[own.get("alphaMode", "OPAQUE")]
        pbr = own.get("pbrMetallicRoughness", {})
        made = Material(mode, own.get("alphaCutoff", 0.5), pbr.get("baseColorFactor", [1] * 4)[3])
        if mode != OPAQUE and "baseColorTexture" in pbr:
            texture = document["textures"][pbr["baseColorTexture"]["index"]]
            sampler = document["samplers"][texture["sampler"]] if "sampler" in texture else {}
            image = Image.open(io.BytesIO(view(document["images"][texture["source"]]["bufferView"])))
            made.alpha = np.asarray(image.convert("RGBA"), "f4")[:, :, 3] / 255
            made.nearest = sampler.get("magFilter") == GL_NEAREST
            kinds = {GL_CLAMP: 2, GL_MIRROR: 1}
            made.wrap = tuple(kinds.get(sampler.get(key), 0) for key in ("wrapS", "wrapT"))
        return made

    meshes = []
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            positions = accessor(attributes["POSITION"])
            if "indices" in primitive:
                indices = accessor(primitive["indices"])
            else:
                indices = np.arange(len(positions))
            uvs = accessor(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else None
            triangles = indices.reshape(-1, 3).astype("u4")
            meshes.append(Mesh(positions, triangles, uvs=uvs, material=material(primitive.get("material"))))
    return meshes


def write_glb(path, mesh):
    """One mesh with a masked texture in its colour's alpha."""
    alpha = np.round(mesh.material.alpha * 255).astype("u1")
    rgba = np.full((*alpha.shape, 4), 128, "u1")
    rgba[:, :, 3] = alpha
    png = io.BytesIO()
    Image.fromarray(rgba).save(png, "PNG")
    parts = [mesh.positions.astype("<f4").tobytes(), mesh.uvs.astype("<f4").tobytes()]
    parts += [mesh.triangles.astype("<u4").tobytes(), png.getvalue()]
    views, binary = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + bytes(-len(part) % 4)
    count = len(mesh.positions)
    low, high = mesh.positions.min(0).tolist(), mesh.positions.max(0).tolist()
    leaf = {"alphaMode": "MASK", "alphaCutoff": mesh.material.cutoff, "doubleSided": True}
    leaf["pbrMetallicRoughness"] = {"baseColorTexture": {"index": 0}}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [leaf],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5125, "count": mesh.triangles.size, "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
    Path(path).write_bytes(
        head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )
