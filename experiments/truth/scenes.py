"""The scenes, each about 1 in radius around the origin, and the ways in which they are varied."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

import files
import models
import vdb
from geometry import Light, Mesh, Strands, Volume

DATA = Path(__file__).parents[3] / "shared" / "data"
EYE = np.array([1.6, 5.0, 1.2])
TARGET = np.array([0.0, -0.3, 0.0])


@dataclass
class Thing:
    """An object of a scene: what its file has, and where that stands in the scene."""

    key: str  # mesh, curves or volume
    name: str  # the file's name, written by `write`, or a path that is there
    geometry: list
    scale: float = 1.0
    translate: tuple = (0.0, 0.0, 0.0)
    opacity: tuple = (1.0, 1.0, 1.0)
    closed: bool = False  # of a mesh: it is seen from outside only
    receiver: str = "surface"  # or ground, or none

    def write(self, folder):
        """The path of its file."""
        if Path(self.name).is_absolute():
            return Path(self.name)
        path = Path(folder) / self.name
        if path.suffix == ".obj":
            files.write_obj(path, self.geometry[0])
        elif path.suffix == ".hair":
            files.write_hair(path, self.geometry[0])
        elif path.suffix == ".glb":
            files.write_glb(path, self.geometry[0])
        elif path.suffix == ".vdb":
            vdb.write(path, self.geometry[0].values, self.geometry[0].voxel)
        return path


@dataclass
class Camera:
    """Where pictures are taken from."""

    eye: tuple = (-2.6, 2.2, 4.0)
    target: tuple = (0.0, -0.3, 0.0)
    fov: float = 35.0  # vertical
    resolution: tuple = (96, 72)

    def numbers(self):
        """The eye, and the vectors from it to the middle and from there to the right and the upper edge."""
        eye, target = np.array(self.eye), np.array(self.target)
        ahead = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(ahead, [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        high = np.tan(np.radians(self.fov) / 2)
        wide = high * self.resolution[0] / self.resolution[1]
        return np.concatenate([eye, ahead, right * wide, np.cross(right, ahead) * high])


@dataclass
class Scene:
    """Objects under a light."""

    name: str
    what: str
    things: list
    light: Light = field(default_factory=lambda: Light(EYE, TARGET, "rectangle", 1.0, 50.0))
    camera: Camera = field(default_factory=Camera)

    def geometries(self):
        return [geometry for thing in self.things for geometry in thing.geometry]

    def has_media(self):
        return any(isinstance(geometry, Volume) for geometry in self.geometries())

    def channels(self):
        return 3 if any(len(set(thing.opacity)) > 1 for thing in self.things) else 1


@dataclass(frozen=True)
class Variant:
    """A scene's light, and where and how large the whole of it is."""

    name: str
    size: float = 1.0
    shape: str = "rectangle"
    scale: float = 1.0
    offset: tuple = (0.0, 0.0, 0.0)

    def light(self, light):
        return replace(light, size=light.size * self.size, shape=self.shape)


BASE = Variant("as it is")
SMALL_LIGHT = Variant("light × 0.1", size=0.1)
VARIANTS = (
    BASE,
    SMALL_LIGHT,
    Variant("light × 4", size=4.0),
    Variant("disk", shape="disk"),
    Variant("sphere", shape="sphere"),
    Variant("scale 10⁻⁴", scale=1e-4),
    Variant("scale 10⁴", scale=1e4),
    Variant("10⁴ off", offset=(1e4, 0.0, -1e4)),
)


def ground(height=models.GROUND):
    return Thing("mesh", "ground.obj", [models.ground(height=height)], receiver="ground")


def mesh(name, made, **rest):
    return Thing("mesh", f"{name}.obj", [made], opacity=made.opacity, **rest)


def generated():
    """The scenes that need no file."""
    head = mesh("ball", models.ball((0, 0, 0), 0.5), closed=True)
    hair = models.tuft()
    yield Scene(
        "hair", "2,500 curled strands of opacity 0.6 on a ball",
        [Thing("curves", "tuft.hair", [hair], opacity=hair.opacity), head, ground()],
    )  # fmt: skip
    leaves = models.leaves()
    yield Scene(
        "tree", "2,500 leaves cut out by an alpha texture, and branches",
        [Thing("mesh", "leaves.glb", [leaves]), mesh("trunk", models.trunk(), closed=True), ground()],
    )  # fmt: skip
    values, voxel = models.cloud(), 2 / 64
    cloud = Volume(values, np.full(3, -1 + voxel / 2), voxel, 6.0)
    yield Scene(
        "smoke", "a cloud of 64³ voxels with a ball in it",
        [
            Thing("volume", "cloud.vdb", [cloud], translate=tuple(cloud.origin)),
            mesh("ball", models.ball((0.25, 0.1, 0.1), 0.3), closed=True),
            ground(),
        ],
    )  # fmt: skip
    yield Scene("panes", "64 level panes of opacity 0.05", [mesh("panes", models.panes()), ground()])
    yield Scene("cards", "14 opaque cards that cross", [mesh("cards", models.cards()), ground()])
    yield Scene("knot", "a closed knot of 19,200 triangles", [mesh("knot", models.knot(), closed=True), ground()])
    yield Scene("room", "walls and 12 boxes", [mesh("room", models.room(), closed=True), ground()])
    glass = [mesh(f"glass{number}", made) for number, made in enumerate(models.glass())]
    yield Scene("glass", "six coloured panes that lean", [*glass, ground()])


def fitted(low, high):
    """The scale and the translation that bring a box to the height of 2 above the ground, or a width of 2.4."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    scale = min(2 / (high[1] - low[1]), 2.4 / max(high[0] - low[0], high[2] - low[2]))
    middle = (low + high) / 2
    return scale, tuple(-scale * np.array([middle[0], low[1], middle[2]]) + [0.0, models.GROUND, 0.0])


def placed(mesh, scale, translate):
    """A mesh as it stands in the scene."""
    return replace(mesh, positions=(mesh.positions * scale + np.array(translate)).astype("f4"))


def real():
    """The scenes of downloaded models."""
    for name, thickness in (("ponytail", 0.06), ("sintel", 0.0003)):
        hair = files.read_hair(DATA / "hair" / f"{name}.hair", thickness)
        head = files.read_obj(DATA / "hair" / f"{name}_head.obj")
        both = np.concatenate([hair.points, head.positions])
        scale, translate = fitted(both.min(0), both.max(0))
        points = (hair.points * scale + np.array(translate)).astype("f4")
        strands = Strands(points, hair.counts, thickness * scale)
        yield Scene(
            name, f"{len(hair.counts):,} opaque strands on a head of {len(head.triangles):,} triangles",
            [
                Thing("curves", f"{name}.hair", [strands]),
                mesh(f"{name}_head", placed(head, scale, translate), closed=True),
                ground(),
            ],
        )  # fmt: skip
    path = DATA / "mesh" / "eztree_oak_medium.glb"
    parts = files.read_glb(path)
    every = np.concatenate([part.positions for part in parts])
    scale, translate = fitted(every.min(0), every.max(0))
    parts = [placed(part, scale, translate) for part in parts]
    yield Scene(
        "oak", f"{sum(len(part.triangles) for part in parts):,} triangles, masked leaves",
        [Thing("mesh", str(path), parts, scale, translate), ground()],
    )  # fmt: skip
    # In the pose of its vertices: its skin is no matter of shadows.
    (fox,) = files.read_glb(DATA / "mesh" / "Fox.glb")
    scale, translate = fitted(fox.positions.min(0), fox.positions.max(0))
    fox = placed(Mesh(fox.positions, fox.triangles), scale, translate)
    yield Scene("fox", f"a character of {len(fox.triangles):,} triangles", [mesh("fox", fox, closed=True), ground()])
    path = DATA / "volume" / "smoke.vdb"
    values, origin, voxel = vdb.read(path)
    far = origin + voxel * (np.array(values.shape) - 1)
    scale, translate = fitted(origin, far)
    smoke = Volume(values, origin * scale + np.array(translate), voxel * scale, 6.0)
    yield Scene(
        "real smoke", "a simulated plume of a million voxels with a ball in it",
        [
            Thing("volume", str(path), [smoke], scale, translate),
            mesh("ball", models.ball((0.05, -0.5, 0.0), 0.2), closed=True),
            ground(),
        ],
    )  # fmt: skip
