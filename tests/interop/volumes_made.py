"""OpenVDB files of many kinds, written and read by OpenVDB itself: pyopenvdb, which Debian has.

volumes_made.py KIND SEED FILE

runs under the Python that has pyopenvdb, writes FILE, and beside it FILE.npz with the values that the file must have and
those that pyopenvdb reads from it. The rest is for the check, which has no pyopenvdb.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

KINDS = (
    "floats",
    "halves",
    "booleans",
    "tiles",
    "outside the active",
    "scaled",
    "rotated",
    "sheared",
    "by name",
    "by number",
)


def write(kind, seed, path):
    import pyopenvdb as vdb

    rng = np.random.default_rng(seed)
    shape, origin = rng.integers(5, 20, 3), rng.integers(-9, 3, 3)
    # A ball's worth of noise, with holes.
    values = rng.uniform(0, 2, shape).astype(np.float32)
    values[rng.random(shape) < 0.4] = 0
    if kind == "halves":
        values = values.astype(np.float16).astype(np.float32)
    background = 0.0
    grid = vdb.BoolGrid() if kind == "booleans" else vdb.FloatGrid(background)
    if kind == "booleans":
        values = (values > 0.7).astype(np.float32)
        grid.copyFromArray(values > 0, tuple(map(int, origin)))
    elif kind == "tiles":
        # Whole leaves of one value, and a lonely voxel.
        origin, shape = np.array([-8, -8, -8]), np.array([16, 16, 16])
        values = np.zeros(shape, np.float32)
        for _ in range(4):
            at, value = rng.integers(0, 2, 3) * 8, float(np.float32(rng.uniform(0.1, 0.6)))
            values[tuple(slice(one, one + 8) for one in at)] = value
            low = at + origin
            grid.fill(tuple(map(int, low)), tuple(map(int, low + 7)), value, True)
        values[3, 4, 5] = 3.0
        grid.getAccessor().setValueOn(tuple(map(int, np.array([3, 4, 5]) + origin)), 3.0)
        grid.prune()
    else:
        grid.copyFromArray(values, tuple(map(int, origin)))
        if kind == "outside the active":
            # Samplers read what inactive voxels hold.
            accessor = grid.getAccessor()
            for at in np.argwhere(values > 1)[:40]:
                accessor.setActiveState(tuple(map(int, at + origin)), False)
    size = 1.6 / float(max(shape))
    scale = np.full(3, size)
    if kind == "scaled":
        scale *= rng.uniform(0.3, 1, 3)
    matrix = np.diag([*scale, 1.0])
    if kind in ("rotated", "sheared"):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        matrix[:3, :3] = (turn if kind == "rotated" else np.eye(3) + np.tril(rng.uniform(-0.5, 0.5, (3, 3)), -1)) @ np.diag(scale)
    # OpenVDB's vectors are rows; the middle lies at the origin of the world.
    middle = (origin + (shape - 1) / 2) @ matrix[:3, :3]
    matrix[3, :3] = -middle
    grid.transform = vdb.createLinearTransform(matrix.tolist())
    grid.name = "density"
    grid.saveFloatAsHalf = kind == "halves"
    grids = [grid]
    if kind in ("by name", "by number"):
        other = vdb.FloatGrid()
        other.fill((-5, -5, -5), (5, 5, 5), 7.0, True)
        other.transform = grid.transform
        other.name, grid.name = ("density", "smoke") if kind == "by name" else ("density", "density")
        grids = [other, grid]
    vdb.write(str(path), grids=grids)
    read = vdb.readAll(str(path))[0][-1] if kind == "by number" else vdb.read(str(path), grid.name)
    found = np.zeros(shape, bool if kind == "booleans" else np.float32)
    read.copyToArray(found, tuple(map(int, origin)))
    corners = [read.transform.indexToWorld(tuple(map(float, axis))) for axis in [(0, 0, 0), *np.eye(3)]]
    read_matrix = np.eye(4)
    read_matrix[:3, :3], read_matrix[3, :3] = np.array(corners[1:]) - corners[0], corners[0]
    np.savez(f"{path}.npz", origin=origin, made=values, matrix=matrix, read=found.astype(np.float32), read_matrix=read_matrix)


def python():
    """A Python with pyopenvdb, or none."""
    for candidate in (sys.executable, "/usr/bin/python3", "python3"):
        try:
            if subprocess.run([candidate, "-c", "import numpy, pyopenvdb"], capture_output=True).returncode == 0:
                return candidate
        except OSError:
            pass
    return None


def make(interpreter, kind, seed, folder):
    """A file, the light that it must stop, the keys of a scene's object, and what stops it by pyopenvdb."""
    path = Path(folder) / "a.vdb"
    subprocess.run([interpreter, __file__, kind, str(seed), str(path)], check=True)
    data = np.load(f"{path}.npz")
    keys = {"by name": 'grid = "smoke"\n', "by number": 'grid = "density:1"\n'}.get(kind, "")
    made, read = (stopped(data[name], data["origin"], data[place]) for name, place in (("made", "matrix"), ("read", "read_matrix")))
    return path, made, keys, read


def stopped(values, origin, matrix, side=64, steps=200):
    """1 - V(infinity) over [-1, 1]^2 along z, trilinear in float64."""
    padded = np.pad(np.asarray(values, float), 1)
    inverse = np.linalg.inv(matrix)
    at = (np.arange(side) + 0.5) / side * 2 - 1
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    low, high = np.array(origin) - 1.0, np.array(origin) + np.array(values.shape)
    box = np.where(corners < 0, low, high) @ matrix[:3, :3] + matrix[3, :3]
    z = box[:, 2].min() + (np.arange(steps) + 0.5) / steps * np.ptp(box[:, 2])
    depth = np.zeros(side * side)
    x, y = (axis.ravel() for axis in np.meshgrid(at, at))
    for height in z:
        place = np.stack([x, y, np.full_like(x, height)], 1) @ inverse[:3, :3] + inverse[3, :3] - origin + 1
        inside = np.all((place >= 0) & (place < np.array(padded.shape) - 1), 1)
        place = place[inside]
        cell = np.floor(place).astype(int)
        part = place - cell
        total = np.zeros(len(place))
        for corner in np.ndindex(2, 2, 2):
            share = np.prod(np.where(corner, part, 1 - part), 1)
            total += share * padded[tuple((cell + corner).T)]
        depth[inside] += total
    return 1 - np.exp(-depth * np.ptp(box[:, 2]) / steps).mean()


if __name__ == "__main__":
    write(sys.argv[1], int(sys.argv[2]), sys.argv[3])
