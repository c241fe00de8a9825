"""The memory that commands take for what is large only by what a file states.

memory.py --tools PROGRAM [--side PIXELS] [--texture PIXELS] [--json OUT]

Maps of every kind that are empty but for a speck, read by every command; models of 40 materials on one texture.
"""

import argparse
import json
import os
import resource
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

# MiB that each may take.
EMPTY_LIMIT = 64
TEXTURE_LIMIT = 400
MATERIALS = 40

SCENE = """
[light]
eye = [0, 0, 5]
target = [0, 0, 0]
fov = 40.0
shape = "rectangle"
size = [0.5, 0.5]
[[object]]
mesh = "speck.obj"
"""


def peak(command, folder):
    """MiB at the most, and the status, of one run."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, cwd=folder)
    stderr = child.stderr.read().decode(errors="replace")
    _, status, usage = os.wait4(child.pid, 0)
    return usage.ru_maxrss / 1024, os.waitstatus_to_exitcode(status), stderr


def png(side):
    """A PNG of so many grey pixels a side, in squares of 64."""
    rows = [b"\0" + bytes(255 if (x // 64) % 2 == turn else 0 for x in range(side)) for turn in (1, 0)]
    # Row by row: this process' own peak is a floor of what is measured.
    packer = zlib.compressobj()
    packed = b"".join(packer.compress(rows[y // 64 % 2]) for y in range(side)) + packer.flush()

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def write_model(folder, side):
    """An OBJ of 40 quads, each with a material of its own, on one texture."""
    (folder / "leaf.png").write_bytes(png(side))
    (folder / "leaves.mtl").write_text("".join(f"newmtl m{i}\nmap_d leaf.png\n" for i in range(MATERIALS)))
    lines = ["mtllib leaves.mtl", "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    for index in range(MATERIALS):
        x, y = index % 8, index // 8
        lines += [f"v {x + dx} {y + dy} 0" for dx, dy in ((0, 0), (0.9, 0), (0.9, 0.9), (0, 0.9))]
        corners = " ".join(f"{4 * index + corner}/{corner}" for corner in (1, 2, 3, 4))
        lines += [f"usemtl m{index}", f"f {corners}"]
    (folder / "leaves.obj").write_text("\n".join(lines) + "\n")


def empty_maps(program, folder, side):
    """Bakes maps of `side` pixels that hold next to nothing; their names by kind."""
    (folder / "speck.obj").write_text("v 0 0 0\nv 0.0001 0 0\nv 0 0.0001 0\nf 1 2 3\n")
    (folder / "scene.toml").write_text(SCENE)
    (folder / "points.csv").write_text("x,y,z\n0.5,0.5,-1\n0.00001,0.00001,-0.5\n")
    maps = {}
    for kind in ("deep", "layers", "mtsm", "fragments"):
        name = f"{kind}.dsm"
        command = [program, "bake", "scene.toml", "--kind", kind, "-o", name, "--quiet"]
        subprocess.run([*command, "--resolution", str(side), "--samples", "1"], cwd=folder, check=True)
        maps[kind] = name
    return maps


def commands(kind, name):
    found = [
        ["inspect", name],
        ["inspect", name, "--pixel", "5,5"],
        ["verify", name],
        ["lookup", name, "--points", "points.csv"],
    ]
    if kind == "deep":
        found += [
            ["inspect", name, "--slice", "4", "--image", "slice.png"],
            ["mip", name, "-o", "out.dsm"],
            ["convert", name, "out.dsm"],
            ["convert", name, "out.exr"],
            ["diff", name, name],
            ["merge", name, name, "-o", "out.dsm"],
        ]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tools", required=True, help="the program")
    parser.add_argument("--side", type=int, default=16384, help="pixels along the side of the empty maps")
    parser.add_argument("--texture", type=int, default=8192, help="pixels along the side of the texture")
    parser.add_argument("--json", help="where to write the figures")
    arguments = parser.parse_args()
    program = os.path.abspath(arguments.tools)
    rows, failed = [], 0

    def run(what, limit, command, folder):
        nonlocal failed
        mebibytes, status, stderr = peak([program, *command], folder)
        is_right = status == 0 and mebibytes <= limit
        failed += not is_right
        rows.append({"what": what, "command": " ".join(command), "mebibytes": round(mebibytes), "limit": limit})
        print(f"{mebibytes:7.0f} of {limit} MiB  {what}: {' '.join(command)}"
              + ("" if is_right else f"  WRONG, status {status} {stderr[-200:]}"))

    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        write_model(folder, arguments.texture)
        bake = ["bake", "leaves.obj", "-o", "leaves.dsm", "--resolution", "64", "--quiet"]
        run(f"{MATERIALS} materials on one {arguments.texture}² texture", TEXTURE_LIMIT, bake, folder)
        for kind, name in empty_maps(program, folder, arguments.side).items():
            for command in commands(kind, name):
                run(f"{kind}, {arguments.side}² pixels", EMPTY_LIMIT, command, folder)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=1) + "\n")
    # A parent's own peak is a floor of what Linux reports of a child.
    floor = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{len(rows)} runs, {failed} wrong; no figure can be below {floor:.0f} MiB")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
