"""Receivers: places on what a scene has, by kind, drawn from the geometry itself."""

from dataclasses import dataclass

import numpy as np

from geometry import Mesh, Strands, Volume, unit

KINDS = ("ground", "lit side", "grazing", "turned away", "strands", "in media")
# How far receivers stand off their surface, of the scene's radius: which side they are on has to be known.
LIFT = 2.0**-12
# The cosine to the light's centre below which light grazes a surface.
GRAZING = 0.2
# Density, of the largest, from which a place counts as within a medium.
DENSE = 0.05


@dataclass
class Receivers:
    """Points of one kind, with what each lies on: the geometry, and the first and the last segment of its own."""

    kind: str
    points: np.ndarray
    own: np.ndarray


def draw(scene, light, count, seed=11):
    """Receivers of every kind that the scene has, `count` of each."""
    random = np.random.default_rng(seed)
    found = {kind: [] for kind in KINDS}
    tracked = 0
    for thing in scene.things:
        for geometry in thing.geometry:
            if isinstance(geometry, Volume):
                found["in media"].append((in_medium(geometry, count, random), np.full((count, 3), -1)))
                continue
            if isinstance(geometry, Strands):
                found["strands"].append(on_strands(geometry, tracked, count, random))
            elif thing.receiver == "ground":
                points = on_ground(geometry, count, random)
                found["ground"].append((points, np.full((count, 3), -1)))
            tracked += 1
    for kind, points in on_surfaces(scene, light, count, random).items():
        found[kind].append((points, np.full((len(points), 3), -1)))
    made = []
    for kind, parts in found.items():
        if parts:
            points, own = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
            pick = random.permutation(len(points))[:count]
            made.append(Receivers(kind, points[pick], own[pick]))
    return [receivers for receivers in made if len(receivers.points)]


def on_ground(mesh, count, random):
    """Points over a level rectangle around the origin, a tenth off its edges."""
    half = mesh.positions.max(0) * 0.9
    x, z = random.uniform(-1, 1, (2, count))
    return np.stack([x * half[0], np.full(count, mesh.positions[0, 1] + LIFT), z * half[2]], -1)


def on_strands(strands, number, count, random):
    """Points on the middle lines of strands, as many as they are long."""
    first, strand = strands.segments()
    a, b = strands.points[first].astype(float), strands.points[first + 1].astype(float)
    length = np.linalg.norm(b - a, axis=1)
    chosen = random.choice(len(first), count, p=length / length.sum())
    along = random.uniform(0, 1, (count, 1))
    before = np.maximum(chosen - 1, 0)
    after = np.minimum(chosen + 1, len(first) - 1)
    before = np.where(strand[before] == strand[chosen], before, chosen)
    after = np.where(strand[after] == strand[chosen], after, chosen)
    own = np.stack([np.full(count, number), before, after], -1)
    return a[chosen] * (1 - along) + b[chosen] * along, own


def in_medium(volume, count, random):
    """Points where a medium is dense."""
    high = volume.origin + (np.array(volume.values.shape) - 1) * volume.voxel
    least = DENSE * volume.values.max() * volume.density
    found = np.empty((0, 3))
    while len(found) < count:
        tried = random.uniform(volume.origin, high, (4 * count, 3))
        found = np.concatenate([found, tried[volume.at(tried) > least]])
    return found[:count]


def on_surfaces(scene, light, count, random):
    """Points beside surfaces by how they face the light's centre, on either side or, of closed ones, outside."""
    corners, outside, meshes, index, triangle = [], [], [], [], []
    for thing in scene.things:
        for mesh in thing.geometry:
            if isinstance(mesh, Mesh) and thing.receiver == "surface":
                own = mesh.corners()
                corners.append(own)
                outside.append(np.full(len(own), outward(own) if thing.closed else 0.0))
                index.append(np.full(len(own), len(meshes)))
                triangle.append(np.arange(len(own)))
                meshes.append(mesh)
    if not meshes:
        return {}
    corners, outside, index, triangle = (np.concatenate(part) for part in (corners, outside, index, triangle))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    found = {kind: np.empty((0, 3)) for kind in ("lit side", "grazing", "turned away")}
    for _ in range(20):
        chosen = random.choice(len(corners), 4 * count, p=area / area.sum())
        u, v = random.uniform(0, 1, (2, 4 * count))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        weights = np.stack([1 - u - v, u, v], -1)
        points = np.einsum("ij,ijk->ik", weights, corners[chosen])
        opaque = np.array([
            float(opacity_at(meshes[index[c]], triangle[c], w)) for c, w in zip(chosen, weights, strict=True)
        ])  # fmt: skip
        side = np.where(outside[chosen] == 0, random.choice([-1.0, 1.0], 4 * count), outside[chosen])
        facing = unit(normal[chosen]) * side[:, None]
        points = points + LIFT * facing
        cosine = np.einsum("ij,ij->i", facing, unit(light.eye - points))
        kinds = np.where(cosine > GRAZING, "lit side", np.where(cosine < -GRAZING, "turned away", "grazing"))
        for kind in found:
            found[kind] = np.concatenate([found[kind], points[(kinds == kind) & (opaque > 0.5)]])
        if all(len(points) >= count for points in found.values()):
            break
    return found


def opacity_at(mesh, triangle, weights):
    if mesh.material.alpha is None:
        return 1.0
    return mesh.material.at((weights @ mesh.uvs[mesh.triangles[triangle]])[None])[0]


def outward(corners):
    """1 if triangles wind so that their normals point out of the body, else −1."""
    middle = corners.mean((0, 1))
    a, b, c = (corners[:, i] - middle for i in range(3))
    return 1.0 if np.einsum("ij,ij->i", a, np.cross(b, c)).sum() >= 0 else -1.0
