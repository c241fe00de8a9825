"""Strands in Cem Yuksel's format that stop the same light however they are cut, as models_made.py has models."""

import struct

import numpy as np


def ribbon(first, last, widths):
    """A straight strand as its light sees it: as wide as it is thick, with round ends."""
    way = (last - first) / np.linalg.norm(last - first)
    side = np.array([-way[1], way[0]])
    turn = np.linspace(0, np.pi, 60)[:, None]
    ends = [(first, side, -way, widths[0] / 2), (last, -side, way, widths[1] / 2)]
    return np.concatenate([end - (axis * np.cos(turn) - out * np.sin(turn)) * size for end, axis, out, size in ends])


def strands(rng, folder, *, cuts=(1, 1), doubled=False, tapered=False, columns=True):
    """Straight strands."""
    polygons, places, sizes, counts = [], [], [], []
    opacity = float(np.float32(rng.uniform(0.2, 1)))
    usual = float(np.float32(rng.uniform(0.05, 0.3)))
    for _ in range(int(rng.integers(1, 4))):
        first, last = (np.array([*rng.uniform(-0.8, 0.8, 2), 0.0]) for _ in range(2))
        first[2], last[2] = rng.uniform(-0.2, 0.2, 2)
        count = int(rng.integers(cuts[0], cuts[1] + 1))
        along = np.sort([0, 1, *rng.random(count - 1)])
        if doubled:
            along = np.sort([*along, *rng.choice(along, 3)])
        thick = np.array([rng.uniform(0.05, 0.3), rng.uniform(0.05, 0.3)]) if tapered else np.full(2, usual)
        places += [first + (last - first) * part for part in along]
        sizes += [thick[0] + (thick[1] - thick[0]) * part for part in along]
        counts.append(len(along) - 1)
        polygons.append((ribbon(first[:2], last[:2], thick), opacity))
    flags = 1 | 2 | ((4 | 8) if columns or tapered else 0)
    head = struct.pack("<4s4I5f", b"HAIR", len(counts), len(places), flags, 0, usual, 1 - opacity, 1, 1, 1)
    data = np.array(counts, "<u2").tobytes() + np.array(places, "<f4").tobytes()
    if flags & 4:
        data += np.array(sizes, "<f4").tobytes() + np.full(len(places), 1 - opacity, "<f4").tobytes()
    path = folder / "a.hair"
    path.write_bytes(head.ljust(128, b"\0") + data)
    return path, polygons


def by_struct(path):
    """What a second reading of the file's columns gives: quadrilaterals of whole strands, all opaque."""
    data = path.read_bytes()
    _, count, points, flags, _, usual = struct.unpack_from("<4s4If", data)
    lengths = np.frombuffer(data, "<u2", count, 128)
    places = np.frombuffer(data, "<f4", 3 * points, 128 + 2 * count).reshape(-1, 3)[:, :2].astype(float)
    sizes = np.full(points, usual)
    if flags & 4:
        sizes = np.frombuffer(data, "<f4", points, 128 + 2 * count + 12 * points).astype(float)
    result, start = [], 0
    for length in lengths:
        end = start + int(length)
        result.append(ribbon(places[start], places[end], sizes[[start, end]]))
        start += int(length) + 1
    return result


KINDS = {
    "one segment": lambda r, f: strands(r, f),
    "cut unevenly": lambda r, f: strands(r, f, cuts=(2, 60)),
    "doubled points": lambda r, f: strands(r, f, cuts=(1, 8), doubled=True),
    "tapered": lambda r, f: strands(r, f, cuts=(1, 30), tapered=True),
    "no columns": lambda r, f: strands(r, f, cuts=(1, 30), columns=False),
}
