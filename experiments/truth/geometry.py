"""What a scene is made of: triangles, strands and voxels, in the scene's own units, around its origin."""

from dataclasses import dataclass, field

import numpy as np

OPAQUE, MASK, BLEND = 0, 1, 2


@dataclass
class Material:
    """How opaque a surface is by its texture: `alpha` in rows from the top, interpolated or not, repeated."""

    mode: int = OPAQUE
    cutoff: float = 0.5
    factor: float = 1.0
    alpha: np.ndarray | None = None
    nearest: bool = False
    wrap: tuple[int, int] = (0, 0)

    def at(self, uv):
        """The opacity at texture coordinates, an array of (u, v)."""
        value = np.full(len(uv), self.factor)
        if self.mode == OPAQUE:
            return np.ones(len(uv))
        if self.alpha is not None:
            value = value * self._texture(uv)
        return (value >= self.cutoff).astype(float) if self.mode == MASK else np.clip(value, 0, 1)

    def _texture(self, uv):
        height, width = self.alpha.shape
        x, y = uv[:, 0] * width, uv[:, 1] * height

        def texel(i, j):
            return self.alpha[wrapped(j, height, self.wrap[1]), wrapped(i, width, self.wrap[0])]

        if self.nearest:
            return texel(np.floor(x).astype(int), np.floor(y).astype(int))
        i, j = np.floor(x - 0.5).astype(int), np.floor(y - 0.5).astype(int)
        a, b = x - 0.5 - i, y - 0.5 - j
        above = (1 - a) * texel(i, j) + a * texel(i + 1, j)
        return (1 - b) * above + b * ((1 - a) * texel(i, j + 1) + a * texel(i + 1, j + 1))


def wrapped(index, size, wrap):
    """Indices into a row of `size` texels: repeated (0), mirrored (1) or held at its ends (2)."""
    if wrap == 2:
        return np.clip(index, 0, size - 1)
    period = 2 * size if wrap == 1 else size
    index = np.mod(index, period)
    return np.where(index < size, index, period - 1 - index)


@dataclass
class Mesh:
    """Triangles with their material and a share of it that they stop, one number or three."""

    positions: np.ndarray
    triangles: np.ndarray
    opacity: tuple = (1.0, 1.0, 1.0)
    uvs: np.ndarray | None = None
    material: Material = field(default_factory=Material)

    def corners(self):
        return self.positions[self.triangles].astype(float)


@dataclass
class Strands:
    """Strands of `counts` points each, as thick everywhere."""

    points: np.ndarray
    counts: np.ndarray
    thickness: float
    opacity: tuple = (1.0, 1.0, 1.0)

    def segments(self):
        """The first point of each segment, and which strand it is of."""
        starts = np.concatenate([[0], np.cumsum(self.counts)[:-1]])
        first = np.concatenate([np.arange(s, s + n - 1) for s, n in zip(starts, self.counts, strict=True)])
        strand = np.repeat(np.arange(len(self.counts)), self.counts - 1)
        return first.astype(np.uint32), strand.astype(np.uint32)


@dataclass
class Volume:
    """Voxels at whole numbers from `origin` on, `voxel` apart, of `density` per unit where a value is 1.

    Trilinear between them, and 0 a voxel beyond them.
    """

    values: np.ndarray  # x, y, z
    origin: np.ndarray  # the first voxel's position
    voxel: float
    density: float

    def at(self, points):
        """Extinction at points."""
        padded = np.pad(self.values.astype(float), 1)
        index = (points - self.origin) / self.voxel + 1
        low = np.clip(np.floor(index).astype(int), 0, np.array(padded.shape) - 2)
        share = np.clip(index - low, 0, 1)
        total = np.zeros(len(points))
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, share, 1 - share), axis=1)
            total += weight * padded[tuple((low + corner).T)]
        inside = np.all((index >= 0) & (index <= np.array(padded.shape) - 1), axis=1)
        return np.where(inside, total * self.density, 0)


@dataclass
class Light:
    """An area light whose outline stands across the line from `eye` to `target`."""

    eye: np.ndarray
    target: np.ndarray
    shape: str
    size: float  # full width and height; the diameter
    fov: float  # degrees
    up: tuple = (0.0, 0.0, 1.0)

    def half_axes(self):
        ahead = unit(self.target - self.eye)
        right = unit(np.cross(ahead, self.up))
        return right * self.size / 2, np.cross(right, ahead) * self.size / 2


def unit(vectors):
    vectors = np.asarray(vectors, float)
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
