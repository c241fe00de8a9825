"""Bakes models of many kinds, and compares the light that is stopped with what it must be, and with trimesh.

check_models.py --tools PROGRAM [--files N]

For each kind N models are made (see models_made.py); the light that a model must stop comes from its polygons, before
they are written. trimesh (and pygltflib, which opens every glTF) reads the same file: its triangles, all opaque, are
compared with the polygons taken for opaque. Prints a row of a table for each kind, and exits with 1 if the program is
wrong anywhere.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
import pygltflib
import trimesh

from models_made import KINDS, stopped
from tool import Failed, Tool

SIDE = 32
# Of both sums over places: 64 a pixel of the program's, 256 x 256 of ours.
TOLERANCE = 0.006

SCENE = """
[light]
eye = [0, 0, 5]
target = [0, 0, 0]
up = [0, 1, 0]
projection = "orthographic"
extent = 2.0

[[object]]
mesh = "{}"
"""


def by_program(tool, path, folder):
    scene, output = folder / "scene.toml", folder / "map.dsm"
    scene.write_text(SCENE.format(path.name))
    size = ("--resolution", f"{SIDE}x{SIDE}", "--samples", "64", "--tolerance", "0")
    tool.expect("bake", scene, "-o", output, "--quiet", *size)
    at = np.arange(SIDE) + 0.5
    x, y = (axis.ravel() for axis in np.meshgrid(at, at))
    points = np.stack([x, y, np.full_like(x, 1e6)], 1)
    return 1 - tool.lookup(output, points, folder, "--space", "raster").mean()


def by_trimesh(path):
    loaded = trimesh.load(path, process=False)
    mesh = loaded.to_mesh() if isinstance(loaded, trimesh.Scene) else loaded
    return stopped([(triangle[:, :2], 1.0) for triangle in np.asarray(mesh.triangles)])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tools", required=True, type=Path)
    parser.add_argument("--files", type=int, default=10)
    arguments = parser.parse_args()
    tool, all_right = Tool(arguments.tools), True
    print("| kind | files | right | largest error | right by trimesh |")
    print("|---|---|---|---|---|")
    for kind, make in KINDS.items():
        right, largest, others = 0, 0.0, 0
        for seed in range(arguments.files):
            with tempfile.TemporaryDirectory() as folder:
                folder = Path(folder)
                path, polygons = make(np.random.default_rng(seed), folder)
                try:
                    error = abs(by_program(tool, path, folder) - stopped(polygons))
                except Failed as failed:
                    print(failed, file=sys.stderr)
                    error = 1.0
                right, largest = right + (error <= TOLERANCE), max(largest, error)
                if path.suffix != ".obj" and path.suffix != ".ply":
                    pygltflib.GLTF2().load(str(path))
                try:
                    whole = stopped([(corners, 1.0) for corners, _ in polygons])
                    others += abs(by_trimesh(path) - whole) <= TOLERANCE
                except Exception as failed:
                    print(f"{kind}: trimesh: {failed!r}", file=sys.stderr)
        all_right &= right == arguments.files
        print(f"| {kind} | {arguments.files} | {right} | {largest:.4f} | {others} |", flush=True)
    sys.exit(0 if all_right else 1)


if __name__ == "__main__":
    main()
