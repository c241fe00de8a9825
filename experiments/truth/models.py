"""Models made here, around the origin and about 1 in radius, each from a fixed seed."""

import numpy as np

from geometry import MASK, Material, Mesh, Strands, unit

GROUND = -1.0
GROUND_HALF = 1.6


def quad(centre, right, up):
    """The corners of a rectangle with these half axes."""
    centre, right, up = (np.asarray(v, float) for v in (centre, right, up))
    return np.array([centre - right - up, centre + right - up, centre + right + up, centre - right + up])


def quads(corners, uvs=None, material=None, opacity=(1.0, 1.0, 1.0)):
    """A mesh of rectangles, (n, 4, 3)."""
    corners = np.asarray(corners)
    first = 4 * np.arange(len(corners))[:, None]
    triangles = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]], 1).reshape(-1, 3)
    if uvs is not None:
        uvs = np.tile(np.asarray(uvs, "f4"), (len(corners), 1))
    positions = corners.reshape(-1, 3).astype("f4")
    return Mesh(positions, triangles.astype("u4"), opacity, uvs, material or Material())


def ground(half=GROUND_HALF, height=GROUND):
    return quads([quad((0, height, 0), (half, 0, 0), (0, 0, -half))])


def merged(meshes):
    shifts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes[:-1]])
    triangles = [mesh.triangles + np.uint32(shift) for mesh, shift in zip(meshes, shifts, strict=True)]
    return Mesh(np.concatenate([mesh.positions for mesh in meshes]), np.concatenate(triangles))


def surface_of(point, columns, rows):
    """A closed surface: `point` of (u, v) in [0, 1)², both of which come round again."""
    u, v = np.meshgrid(np.arange(columns) / columns, np.arange(rows) / rows, indexing="ij")
    positions = point(u.ravel(), v.ravel()).astype("f4")
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    a = i * rows + j
    b, c = (i + 1) % columns * rows + j, (i + 1) % columns * rows + (j + 1) % rows
    d = i * rows + (j + 1) % rows
    return Mesh(positions, np.stack([a, b, c, a, c, d], -1).reshape(-1, 3).astype("u4"))


def ball(centre, radius, columns=64, rows=32):
    """A sphere of triangles; its poles are small holes."""

    def point(u, v):
        across, along = 2 * np.pi * u, np.pi * (v * rows + 0.5) / rows
        flat = np.sin(along)
        return radius * np.stack([flat * np.cos(across), np.cos(along), flat * np.sin(across)], -1) + centre

    made = surface_of(point, columns, rows)
    # The last row does not meet the first.
    keep = ~np.logical_and((made.triangles % rows == 0).any(1), (made.triangles % rows == rows - 1).any(1))
    made.triangles = made.triangles[keep]
    return made


def knot(turns=400, around=24, thickness=0.17):
    """A closed (2, 3) torus knot of triangles."""

    def line(t):
        angle = 2 * np.pi * t
        radius = 0.58 + 0.24 * np.cos(3 * angle)
        return np.stack([radius * np.cos(2 * angle), 0.24 * np.sin(3 * angle), radius * np.sin(2 * angle)], -1)

    def point(u, v):
        step = 1e-4
        tangent = unit(line(u + step) - line(u - step))
        side = unit(np.cross(tangent, [0.0, 1.0, 0.0]))
        other = np.cross(tangent, side)
        angle = 2 * np.pi * v[:, None]
        return line(u) + thickness * (np.cos(angle) * side + np.sin(angle) * other)

    made = surface_of(point, turns, around)
    tilt = np.radians(35)
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    made.positions = (made.positions @ turn.T).astype("f4")
    return made


def tuft(strands=2500, points=12, seed=1):
    """Curled strands on the upper half of a ball of radius 0.5, which hang down from it."""
    random = np.random.default_rng(seed)
    roots = unit(random.normal(size=(strands, 3)))
    roots[:, 1] = np.abs(roots[:, 1]) * 0.9 + 0.1
    roots = unit(roots)
    along = np.linspace(0, 1, points)[None, :, None]
    curl = random.uniform(6, 12, (strands, 1, 1)) * along + random.uniform(0, 2 * np.pi, (strands, 1, 1))
    side = unit(np.cross(roots, [0.3, 1.0, 0.2]))[:, None]
    other = np.cross(roots[:, None], side)
    length = random.uniform(0.35, 0.6, (strands, 1, 1))
    path = roots[:, None] * (0.5 + length * along) - np.array([0.0, 0.9, 0.0]) * length * along**2
    path = path + 0.04 * along * (np.cos(curl) * side + np.sin(curl) * other)
    return Strands(path.reshape(-1, 3).astype("f4"), np.full(strands, points), 0.004, (0.6, 0.6, 0.6))


def leaf_alpha(size=128):
    """A lobed leaf with a few holes: 1 inside, 0 outside, with the ramp of a texel between."""
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * 2 - 1
    angle, radius = np.arctan2(y, x), np.hypot(x, y)
    edge = 0.72 + 0.2 * np.cos(5 * angle)
    inside = (edge - radius) * size / 2
    for hole in ((0.25, 0.2, 0.12), (-0.3, -0.15, 0.1), (0.05, -0.4, 0.08)):
        inside = np.minimum(inside, (np.hypot(x - hole[0], y - hole[1]) - hole[2]) * size / 2)
    return np.round(np.clip(inside + 0.5, 0, 1) * 255).astype("f4") / 255


def leaves(count=2500, seed=2):
    """Leaves turned every way in a crown, cut out of rectangles by an alpha texture."""
    random = np.random.default_rng(seed)
    centre = unit(random.normal(size=(count, 3))) * random.uniform(0.05, 1, (count, 1)) ** (1 / 3)
    centre = centre * [0.8, 0.6, 0.8] + [0, 0.2, 0]
    right = unit(random.normal(size=(count, 3)) + [0, 0, 0.3])
    up = unit(np.cross(right, random.normal(size=(count, 3))))
    size = random.uniform(0.05, 0.09, (count, 1))
    corners = np.stack([centre - size * (right + up), centre + size * (right - up)], 1)
    corners = np.concatenate([corners, np.stack([centre + size * (right + up), centre - size * (right - up)], 1)], 1)
    material = Material(MASK, 0.5, 1.0, leaf_alpha())
    return quads(corners, [[0, 1], [1, 1], [1, 0], [0, 0]], material)


def trunk(seed=3):
    """A trunk and branches of boxes that lean."""
    random = np.random.default_rng(seed)
    parts = [box((0, -0.45, 0), (0.06, 0.55, 0.06))]
    for number in range(7):
        angle = 2 * np.pi * number / 7 + random.uniform(-0.3, 0.3)
        parts.append(box((0.2 * np.cos(angle), 0.15, 0.2 * np.sin(angle)), (0.025, 0.3, 0.025), (angle, 0.7)))
    return merged(parts)


def box(centre, half, lean=None):
    """A closed box; `lean` is an angle around the vertical and how far it then leans outwards."""
    axes = np.diag(np.asarray(half, float))
    if lean:
        around, out = lean
        turn = np.array([[np.cos(around), 0, np.sin(around)], [0, 1, 0], [-np.sin(around), 0, np.cos(around)]])
        fall = np.array([[np.cos(out), np.sin(out), 0], [-np.sin(out), np.cos(out), 0], [0, 0, 1]])
        axes = axes @ (turn.T @ fall).T
    x, y, z = axes
    faces = [(x, y, z), (-x, z, y), (y, z, x), (-y, x, z), (z, x, y), (-z, y, x)]
    return quads([quad(np.asarray(centre) + normal, a, b) for normal, a, b in faces])


def panes(count=64):
    """A stack of level panes, a fiftieth apart."""
    return quads([quad((0, 0.02 * i - 0.5, 0), (0.8, 0, 0), (0, 0, -0.8)) for i in range(count)], opacity=(0.05,) * 3)


def cards(count=14, seed=4):
    """Opaque cards that cross each other."""
    random = np.random.default_rng(seed)
    made = []
    for _ in range(count):
        right = unit(random.normal(size=3))
        up = unit(np.cross(right, random.normal(size=3)))
        centre = random.uniform(-0.35, 0.35, 3)
        made.append(quad(centre, right * random.uniform(0.2, 0.5), up * random.uniform(0.2, 0.5)))
    return quads(made)


def room(seed=5):
    """A floor, three walls and boxes in between; it is open above and in front."""
    random = np.random.default_rng(seed)
    parts = [
        box((-1.15, -0.4, 0), (0.05, 0.6, 1.2)),
        box((1.15, -0.4, 0), (0.05, 0.6, 1.2)),
        box((0, -0.4, -1.15), (1.1, 0.6, 0.05)),
    ]
    for _ in range(12):
        half = random.uniform(0.06, 0.22, 3)
        x, z = random.uniform(-0.9, 0.9, 2)
        y = GROUND + half[1] + random.uniform(0, 0.3)
        parts.append(box((x, y, z), half, (random.uniform(0, np.pi), 0.0)))
    return merged(parts)


def glass():
    """Six coloured panes that lean, with the opacities of each."""
    made = []
    colours = [(0.9, 0.3, 0.1), (0.2, 0.8, 0.3), (0.1, 0.4, 0.9), (0.6, 0.6, 0.1), (0.5, 0.1, 0.7), (0.3, 0.9, 0.9)]
    for number, colour in enumerate(colours):
        angle = number * 1.1
        right = np.array([np.cos(angle), 0.35 * np.sin(angle), np.sin(angle)]) * 0.6
        up = np.array([-np.sin(angle), 0.4, np.cos(angle)]) * 0.6
        centre = (0.2 * np.cos(angle), 0.18 * number - 0.5, 0.2 * np.sin(angle))
        made.append(quads([quad(centre, right, up)], opacity=colour))
    return made


def cloud(side=64):
    """Densities in a ball with billows, on `side`³ voxels that fill [−1, 1]³."""
    at = (np.arange(side) + 0.5) / side * 2 - 1
    x, y, z = np.meshgrid(at, at, at, indexing="ij")
    billows = np.sin(5 * x + 1) * np.sin(6 * y) * np.sin(5.5 * z + 2) + 0.5 * np.sin(11 * x) * np.sin(13 * y + 1)
    return np.clip(0.85 - np.hypot(np.hypot(x, y), z) + 0.25 * billows, 0, 0.5).astype("f4")
