"""Bakes files of many kinds as other programs write them, and compares the light that is stopped with what it must be.

check_models.py --tools PROGRAM [--files N] [--only WORD] [--write PAGE]

For each kind N files are made at random, with the light that they must stop: of models the light comes from their
polygons, before they are written, of volumes from their voxels, of deep images from their samples. Another reader is
given the same file, and the light of what it reads is compared, too; readers of models that know no opacity are
compared with the polygons taken for opaque. Prints a row of a table for each kind, into PAGE below its mark if one is
named, and exits with 1 if the program is wrong anywhere, whatever others read. Volumes need pyopenvdb, of a Python on
this machine: else they are left out, and a line says so.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import animation_made
import gltf_made
import images_made
import models_made
import readers
import stages_made
import strands_made
import volumes_made
from models_made import stopped
from tool import Failed, Tool

SIDE = 32
# Of both sums over places: 64 a pixel of the program's, 256 x 256 of ours.
TOLERANCE = 0.006
# Of values at points.
EXACT = 1e-5

MARK = "<!-- check_models.py writes what follows -->\n"

SCENE = """
[light]
eye = [0, 0, 5]
target = [0, 0, 0]
up = [0, 1, 0]
projection = "orthographic"
extent = 2.0

[[object]]
{} = "{}"
{}"""


def by_program(tool, path, folder, key, keys, samples=64, tolerance=0):
    scene, output = folder / "scene.toml", folder / "map.dsm"
    scene.write_text(SCENE.format(key, path.name, keys))
    size = ("--resolution", f"{SIDE}x{SIDE}", "--samples", samples, "--tolerance", tolerance)
    tool.expect("bake", scene, "-o", output, "--quiet", *size)
    at = np.arange(SIDE) + 0.5
    x, y = (axis.ravel() for axis in np.meshgrid(at, at))
    points = np.stack([x, y, np.full_like(x, 1e6)], 1)
    return 1 - tool.lookup(output, points, folder, "--space", "raster").mean()


def of_models(make, read, key="mesh", is_opaque=True):
    """A check of a file made of polygons: the program's error, and the reader's or None."""

    def check(tool, seed, folder):
        path, polygons, *keys = make(np.random.default_rng(seed), folder)
        keys = keys[0] if keys else ""
        error = abs(by_program(tool, path, folder, key, keys) - stopped(polygons))
        whole = stopped([(corners, 1.0 if is_opaque else opacity) for corners, opacity in polygons])
        return error, lambda: abs(read(path, keys) - whole)

    return check, TOLERANCE


def of_volumes(kind, interpreter):
    def check(tool, seed, folder):
        path, want, keys, read = volumes_made.make(interpreter, kind, seed, folder)
        # Every sample of a volume has a vertex a voxel.
        found = by_program(tool, path, folder, "volume", keys, 9, 1e-3)
        return abs(found - want), lambda: abs(read - want)

    return check, TOLERANCE


def of_images(make):
    def check(tool, seed, folder):
        asked = make(np.random.default_rng(seed), folder)
        output = folder / "map.dsm"
        tool.expect("convert", asked.path, output, "--tolerance", "0", "--quiet", *asked.switches)
        found = tool.lookup(output, asked.points, folder, "--space", asked.space, "--filter", "point")
        other = None if asked.read is None else lambda: np.abs(asked.read - asked.want).max(initial=0)
        return np.abs(found - asked.want).max(initial=0), other

    return check, EXACT


def kinds():
    """(kind, name of the other reader, check, tolerance)."""
    found = []

    def add(group, made, reader, of):
        found.extend((f"{group}: {name}", reader, *of(make)) for name, make in made.items())

    add("OBJ", models_made.OBJ, "trimesh", lambda make: of_models(make, readers.by_trimesh))
    add("PLY", models_made.PLY, "plyfile", lambda make: of_models(make, readers.by_plyfile, is_opaque=False))
    known = {"nodes", "trees", "strips", "factor", "vertex alpha", "mask", "glossiness", "lights required", "custom attributes"}
    by_trimesh = {name: make for name, make in gltf_made.KINDS.items() if name in known}
    rest = {name: make for name, make in gltf_made.KINDS.items() if name not in known}
    add("glTF", by_trimesh, "trimesh", lambda make: of_models(make, readers.by_trimesh))
    add("glTF", rest, "pygltflib", lambda make: of_models(make, readers.by_pygltflib))
    add("glTF, animated", animation_made.KINDS, "pygltflib", lambda make: of_models(make, readers.by_pygltflib))
    add("USD", stages_made.KINDS, "usd-core", lambda make: of_models(make, readers.by_usd_core, "usd", False))
    add("HAIR", strands_made.KINDS, "the format's text", lambda make: of_models(make, readers.by_struct, "curves"))
    add("deep EXR", images_made.KINDS, "OpenEXR", of_images)
    interpreter = volumes_made.python()
    if interpreter:
        add("OpenVDB", {kind: kind for kind in volumes_made.KINDS}, "pyopenvdb", lambda kind: of_volumes(kind, interpreter))
    else:
        print("SKIPPED: OpenVDB, no Python here has pyopenvdb", file=sys.stderr)
    return found


def row(tool, kind, reader, check, tolerance, files):
    """The row of a kind, and how many of its files the program has right."""
    right, largest, others, asked = 0, 0.0, 0, 0
    for seed in range(files):
        with tempfile.TemporaryDirectory() as folder:
            try:
                error, other = check(tool, seed, Path(folder))
            except Failed as failed:
                print(f"{kind}, file {seed}: {failed}", file=sys.stderr)
                error, other = 1.0, None
            if error > tolerance:
                print(f"{kind}, file {seed}: off by {error:.3g}", file=sys.stderr)
            right, largest = right + (error <= tolerance), max(largest, error)
            if other is not None:
                asked += 1
                try:
                    others += other() <= tolerance
                except Exception as failed:
                    # Whatever another program's reader stumbles over is its own.
                    print(f"{kind}, file {seed}: {reader}: {failed!r}", file=sys.stderr)
    read = f"{reader}: {others} of {asked}" if asked else "—"
    return f"| {kind} | {right} of {files} | {largest:.1e} | {read} |", right


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tools", required=True, type=Path, help="the program dsm-tools")
    parser.add_argument("--files", type=int, default=10, help="of each kind")
    parser.add_argument("--only", default="", help="kinds whose names have this in them")
    parser.add_argument("--write", type=Path, help="the page whose table is written")
    arguments = parser.parse_args()
    tool, right, all_files = Tool(arguments.tools), 0, 0
    lines = ["| kind | right | largest error | read the same by |", "|---|---|---|---|"]
    print("\n".join(lines))
    for kind, *check in kinds():
        if arguments.only not in kind:
            continue
        line, right_here = row(tool, kind, *check, arguments.files)
        print(line, flush=True)
        lines.append(line)
        right, all_files = right + right_here, all_files + arguments.files
    lines += ["", f"In all {right} of {all_files} are right."]
    print(lines[-1])
    if arguments.write:
        head = arguments.write.read_text().split(MARK)[0]
        arguments.write.write_text(head + MARK + "\n" + "\n".join(lines) + "\n")
    sys.exit(0 if right == all_files > 0 else 1)


if __name__ == "__main__":
    main()
