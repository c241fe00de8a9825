"""OBJ and PLY files of many kinds with the light that each must stop, made from random polygons.

Every model lies near the plane z = 0 in [-1, 1]^2. `OBJ` and `PLY` map a name to a function of a random generator and a
folder, which writes a file and returns it with the polygons it stands for: (corners n x 2, opacity) pairs.
"""

import struct

import numpy as np


def star(rng, centre=None, size=None, corners=None):
    """A polygon without crossings, as often concave as not."""
    corners = corners or int(rng.integers(4, 14))
    angles = np.sort(rng.random(corners) + np.arange(corners)) * 2 * np.pi / corners
    radius = rng.uniform(0.3, 1, corners) * (size or rng.uniform(0.3, 0.6))
    centre = rng.uniform(-0.4, 0.4, 2) if centre is None else np.asarray(centre)
    return centre + radius[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)


def quad(rng):
    """A parallelogram that no other overlaps: one of four cells."""
    return star(rng, corners=4)


def stopped(polygons, side=256):
    """1 - V(infinity) on a grid of places, by crossings of each polygon's sides."""
    at = (np.arange(side) + 0.5) / side * 2 - 1
    x, y = np.meshgrid(at, at)
    left = np.ones_like(x)
    for corners, opacity in polygons:
        inside = np.zeros(x.shape, bool)
        for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, 0)):
            if ay != by:
                crosses = (ay > y) != (by > y)
                inside ^= crosses & (ax + (y - ay) / (by - ay) * (bx - ax) > x)
        left *= np.where(inside, 1 - opacity, 1)
    return 1 - left.mean()


def obj(rng, folder, *, line="\n", mark="", face=lambda f, total: f, z=0.0, comment="", material=None, roll=True):
    polygons, text, total = [], mark, 0
    opacity = 1.0
    if material:
        opacity = round(float(rng.uniform(0.1, 0.9)), 2)
        (folder / "m.mtl").write_bytes(material(opacity).encode("latin-1"))
        text += f"mtllib m.mtl{line}usemtl gr\xfcn{line}"
    for _ in range(int(rng.integers(1, 4))):
        corners = star(rng)
        if roll:
            corners = np.roll(corners, int(rng.integers(len(corners))), 0)
        for place in corners:
            text += f"v {place[0]:.6f} {place[1]:.6f} {rng.uniform(-z, z):.6f}{line}"
        total += len(corners)
        indices = range(total - len(corners) + 1, total + 1)
        text += f"f {' '.join(face(index, total) for index in indices)}{comment}{line}"
        polygons.append((corners, opacity))
    path = folder / "a.obj"
    path.write_bytes(text.encode("latin-1" if mark == "" else "utf-8"))
    return path, polygons


def plain(index, _total):
    return str(index)


OBJ = {
    "polygons, concave": lambda r, f: obj(r, f, face=plain),
    "not in a plane": lambda r, f: obj(r, f, face=plain, z=0.1),
    "relative indices": lambda r, f: obj(r, f, face=lambda i, total: str(i - total - 1)),
    "missing normals": lambda r, f: obj(r, f, face=lambda i, _: f"{i}//{i}"),
    "empty parts": lambda r, f: obj(r, f, face=lambda i, _: f"{i}//"),
    "comments after faces": lambda r, f: obj(r, f, face=plain, comment=" # a face"),
    "continued lines": lambda r, f: obj(r, f, face=lambda i, _: f"{i} \\\n"),
    "CR": lambda r, f: obj(r, f, face=plain, line="\r"),
    "CR LF": lambda r, f: obj(r, f, face=plain, line="\r\n"),
    "byte order mark": lambda r, f: obj(r, f, face=plain, mark="\ufeff"),
    "Latin-1 names, d": lambda r, f: obj(r, f, face=plain, material=lambda o: f"newmtl gr\xfcn\nd {o}\n"),
    "Tr": lambda r, f: obj(r, f, face=plain, material=lambda o: f"newmtl gr\xfcn\nTr {1 - o:.2f}\n"),
    "d and Tr": lambda r, f: obj(r, f, face=plain, material=lambda o: f"newmtl gr\xfcn\nTr {1 - o:.2f}\nd {o}\n"),
}


def ply(rng, folder, *, order="<", text=False, strips=False, faces_first=False, wrapped=False, alpha=False):
    polygons, corners, lists = [], [], []
    opacity = int(rng.integers(20, 250)) if alpha else 255
    for _ in range(int(rng.integers(1, 4))):
        if strips:
            x, y, w, h = *rng.uniform(-0.9, 0, 2), *rng.uniform(0.1, 0.8, 2)
            polygon = np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
            lists += [[len(corners), len(corners) + 1, len(corners) + 3, len(corners) + 2]]
        else:
            polygon = star(rng)
            lists += [list(range(len(corners), len(corners) + len(polygon)))]
        corners += polygon.tolist()
        polygons.append((polygon, opacity / 255))
    if strips:
        lists = [sum(([*one, -1] for one in lists), [])[:-1]]
    kind = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    name = "tristrips" if strips else "face"
    vertex = f"element vertex {len(corners)}\nproperty double x\nproperty short extra\nproperty float y\nproperty float z\n"
    vertex += "property uchar alpha\n" if alpha else ""
    element = f"element {name} {len(lists)}\nproperty list ushort int vertex_indices\nproperty uchar flags\n"
    elements = [element, vertex] if faces_first else [vertex, element]
    head = f"ply\nformat {'ascii' if text else kind} 1.0\ncomment made\n{''.join(elements)}end_header\n"
    one = "dhff" + ("B" if alpha else "")
    rows = [[(one, (x, 7, y, 0.0, *([opacity] if alpha else [])))] for x, y in corners]
    more = [[(f"H{len(at)}iB", (len(at), *at, 3))] for at in lists]
    data = b""
    for (form, values), in more + rows if faces_first else rows + more:
        if text:
            words = "\n" if wrapped else " "
            data += (words.join(f"{value:.9g}" for value in values) + "\n").encode()
        else:
            data += struct.pack(order + form, *values)
    path = folder / "a.ply"
    path.write_bytes(head.encode() + data)
    return path, polygons


PLY = {
    "little endian": lambda r, f: ply(r, f),
    "big endian": lambda r, f: ply(r, f, order=">"),
    "text": lambda r, f: ply(r, f, text=True),
    "faces first": lambda r, f: ply(r, f, faces_first=True),
    "wrapped rows": lambda r, f: ply(r, f, text=True, wrapped=True),
    "tristrips": lambda r, f: ply(r, f, strips=True),
    "alpha": lambda r, f: ply(r, f, alpha=True),
}
