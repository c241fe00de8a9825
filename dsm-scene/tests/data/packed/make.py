#!/usr/bin/env python3
"""Writes source.gltf, a mesh of two materials, and packs it in eight ways.

    make.py GLTFPACK

Made with gltfpack 1.3.0 and numpy 2.4.6.
"""

import base64
import json
import pathlib
import subprocess
import sys

import numpy as np

PACKINGS = {
    "floats": ["-noq"],
    "quantised": [],
    "compressed": ["-c"],
    "compressed_more": ["-cc"],
    "compressed_fallback": ["-cf"],
    "float_positions": ["-c", "-vpf"],
    "float_all": ["-c", "-vpf", "-vtf", "-vnf"],
    "khr": ["-cc", "-ce", "khr"],
}
SIDE = 13


def main():
    rng = np.random.default_rng(14)
    x, y = np.meshgrid(np.linspace(-0.9, 0.8, SIDE), np.linspace(-0.8, 0.9, SIDE))
    places = np.stack([x.ravel(), y.ravel(), rng.uniform(-0.1, 0.1, SIDE * SIDE)], 1)
    places[:, :2] += rng.uniform(-0.03, 0.03, (SIDE * SIDE, 2))
    corners = [[], []]
    for row in range(SIDE - 1):
        for column in range(SIDE - 1):
            at = row * SIDE + column
            if rng.random() < 0.7:
                corners[int(column > row)] += [at, at + 1, at + SIDE, at + 1, at + SIDE + 1, at + SIDE]
    data, views, accessors = b"", [], []
    for array, kind, part in ((places, "VEC3", "<f4"), (corners[0], "SCALAR", "<u2"), (corners[1], "SCALAR", "<u2")):
        array = np.asarray(array, part)
        accessors.append({"bufferView": len(views), "componentType": {"<f4": 5126, "<u2": 5123}[part],
                          "count": len(array), "type": kind})
        if kind == "VEC3":
            accessors[-1] |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        data += array.tobytes() + b"\0" * (-array.nbytes % 4)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "rotation": [0, 0, 0.2588190451, 0.9659258263]}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0}, "indices": 1 + at, "material": at} for at in range(2)
        ]}],
        "materials": [
            {"name": "solid", "doubleSided": True},
            {"name": "glass", "doubleSided": True, "alphaMode": "BLEND",
             "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.4]}},
        ],
        "buffers": [{"byteLength": len(data), "uri": uri}],
        "bufferViews": views,
        "accessors": accessors,
    }
    folder = pathlib.Path(__file__).resolve().parent
    source = folder / "source.gltf"
    source.write_text(json.dumps(document))
    for name, switches in PACKINGS.items():
        packed = folder / f"{name}.glb"
        subprocess.run([sys.argv[1], "-i", source, "-o", packed, *switches], check=True)
    # What readers without the extension would read instead.
    (folder / "compressed_fallback.fallback.bin").unlink()


if __name__ == "__main__":
    main()
