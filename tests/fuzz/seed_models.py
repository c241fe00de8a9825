#!/usr/bin/env python3
"""Writes models for the fuzz targets to begin with, one of each kind that tests/interop makes, and some strands.

    tests/fuzz/seed_models.py FOLDER [--gltfpack PROGRAM]

FOLDER is tests/data/fuzz. With gltfpack there are models that it packed, too.
"""

import argparse
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
import animation_made  # noqa: E402
import gltf_made  # noqa: E402
import models_made  # noqa: E402

BETWEEN_FILES = b"\n-----\n"
PACKINGS = {
    "packed_none": ["-noq"],
    "packed_quantised": [],
    "packed_c": ["-c"],
    "packed_cc": ["-cc"],
    "packed_cf": ["-cf"],
    "packed_floats": ["-c", "-vpf"],
    "packed_khr": ["-cc", "-ce", "khr"],
    "packed_instances": ["-c", "-mi"],
}


def name_of(kind):
    return re.sub(r"\W+", "_", kind).strip("_").lower()


def strands(flags, counts, transparency):
    points = sum(count + 1 for count in counts)
    regular = 0 if flags & 1 else counts[0]
    head = struct.pack("<4s4I5f", b"HAIR", len(counts), points, flags, regular, 0.1, transparency, 1, 1, 1)
    rng = np.random.default_rng(flags)
    columns = [
        np.array(counts, "<u2") if flags & 1 else None,
        rng.uniform(-1, 1, 3 * points).astype("<f4"),
        rng.uniform(0, 0.2, points).astype("<f4") if flags & 4 else None,
        rng.uniform(0, 1, points).astype("<f4") if flags & 8 else None,
        rng.uniform(0, 1, 3 * points).astype("<f4") if flags & 16 else None,
    ]
    return head.ljust(128, b" ") + b"".join(column.tobytes() for column in columns if column is not None)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--gltfpack", help="the program gltfpack")
    arguments = parser.parse_args()
    for target in ("gltf", "obj", "ply", "hair"):
        (arguments.folder / target).mkdir(parents=True, exist_ok=True)
    animated = {f"animated_{kind}": make for kind, make in animation_made.KINDS.items()}
    groups = (("gltf", gltf_made.KINDS | animated), ("obj", models_made.OBJ), ("ply", models_made.PLY))
    for target, kinds in groups:
        for kind, make in kinds.items():
            with tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                path, *_ = make(np.random.default_rng(1), folder)
                files = [path] + ([folder / "m.mtl"] if (folder / "m.mtl").exists() else [])
                data = BETWEEN_FILES.join(file.read_bytes() for file in files)
            (arguments.folder / target / name_of(kind)).write_bytes(data)
    # A mask of 2 x 2 pixels, in grey.
    mask = struct.pack("<3B5x4H2B", 0, 0, 3, 0, 0, 2, 2, 8, 32) + bytes([0, 90, 180, 255])
    text = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl m\nf 1/1 2/2 3/3\n"
    mtl = b"newmtl m\nd 0.5\nmap_d -imfchan m -clamp on -mm 0 1 -o .5 0 -s 2 2 t.tga\n"
    (arguments.folder / "obj" / "textured").write_bytes(BETWEEN_FILES.join([text, mtl, mask]))
    for flags, counts in ((2, [3, 3]), (3, [1, 4, 2]), (7, [2, 2]), (15, [5, 1, 3]), (30, [2, 2, 2])):
        (arguments.folder / "hair" / f"columns_{flags}").write_bytes(strands(flags, counts, 0.25))
    if arguments.gltfpack:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            path, *_ = gltf_made.gltf(np.random.default_rng(2), folder, "skins")
            for name, switches in PACKINGS.items():
                packed = folder / f"{name}.glb"
                subprocess.run([arguments.gltfpack, "-i", path, "-o", packed, *switches], check=True)
                (arguments.folder / "gltf" / name).write_bytes(packed.read_bytes())


if __name__ == "__main__":
    main()
