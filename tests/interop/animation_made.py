"""Animated glTF files: as gltf_made.py, with the time that a scene asks for."""

import numpy as np

from gltf_made import BOX, Document

CORNERS = np.concatenate([BOX, np.zeros((4, 1))], 1)


def matrix(translation, rotation, scale):
    """Acts on columns."""
    x, y, z, w = np.asarray(rotation, float) / np.linalg.norm(rotation)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    result = np.eye(4)
    result[:3, :3] = turn * np.asarray(scale)
    result[:3, 3] = translation
    return result


def turned_part(first, second, part):
    """The rotation `part` of the way from one to the other, by the axis and angle between them."""
    first, second = (q / np.linalg.norm(q) for q in (first, second))
    second = second if first @ second >= 0 else -second
    conjugate = first * [-1, -1, -1, 1]
    between = product(second, conjugate)
    length = np.linalg.norm(between[:3])
    angle = np.arctan2(length, between[3]) * part
    axis = between[:3] / length if length > 0 else np.zeros(3)
    return product(np.array([*(np.sin(angle) * axis), np.cos(angle)]), first)


def product(a, b):
    vector = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    return np.array([*vector, a[3] * b[3] - a[:3] @ b[:3]])


class Track:
    """Random keyframes of one property, and its value at any time in float64."""

    def __init__(self, rng, draw, interpolation, is_rotation=False):
        count = int(rng.integers(1, 5))
        self.times = np.cumsum(rng.uniform(0.1, 1, count)).astype("<f4")
        self.values = np.array([draw() for _ in range(count)]).astype("<f4")
        self.tangents = rng.uniform(-0.4, 0.4, (2, *self.values.shape)).astype("<f4")
        self.interpolation, self.is_rotation = interpolation, is_rotation

    def add(self, document):
        """Its sampler."""
        keys = self.values
        if self.interpolation == "CUBICSPLINE":
            keys = np.stack([self.tangents[0], self.values, self.tangents[1]], 1)
        shape = {3: "VEC3", 4: "VEC4", 1: "SCALAR"}[self.values.shape[-1]]
        times = document.accessor("SCALAR", self.times, min=[float(self.times[0])], max=[float(self.times[-1])])
        values = document.accessor(shape, keys.reshape(-1, self.values.shape[-1]))
        sampler = {"input": times, "output": values}
        return sampler | ({} if self.interpolation == "LINEAR" else {"interpolation": self.interpolation})

    def at(self, time):
        times, values = self.times.astype(float), self.values.astype(float)
        later = int(np.searchsorted(times, time, "right"))
        if later == 0 or later == len(times):
            return values[max(later - 1, 0)]
        length = times[later] - times[later - 1]
        part = (time - times[later - 1]) / length
        first, second = values[later - 1], values[later]
        if self.interpolation == "STEP":
            return first
        if self.interpolation == "LINEAR":
            if self.is_rotation:
                return turned_part(first, second, part)
            return first + (second - first) * part
        # Bézier's form of the Hermite spline.
        before, after = self.tangents.astype(float)
        points = [first, first + length * after[later - 1] / 3, second - length * before[later] / 3, second]
        while len(points) > 1:
            points = [a + (b - a) * part for a, b in zip(points, points[1:])]
        return points[0]


def animated(rng, folder, kind):
    document = Document()
    interpolation = {"steps": "STEP", "splines": "CUBICSPLINE"}.get(kind, "LINEAR")
    tracks = {
        "translation": Track(rng, lambda: [*rng.uniform(-0.4, 0.4, 2), 0], interpolation),
        "rotation": Track(rng, lambda: unit(rng.normal(size=4) * [0.3, 0.3, 1, 1]), interpolation, True),
        "scale": Track(rng, lambda: rng.uniform(0.3, 1.2, 3), interpolation),
    }
    # Before the first keyframe and after the last one, too.
    time = float(np.float32(rng.uniform(-0.1, 3)))
    primitive = {"attributes": {"POSITION": document.accessor("VEC3", CORNERS)}}
    primitive["indices"] = document.accessor("SCALAR", [0, 1, 2, 0, 2, 3], "u2")
    more, mesh, nodes, corners = {}, None, [{"mesh": 0}], CORNERS
    if kind == "weights":
        targets = rng.uniform(-0.5, 0.5, (3, 4, 3)).astype("<f4")
        primitive["targets"] = [{"POSITION": document.accessor("VEC3", target)} for target in targets]
        mesh = {"weights": [9.0, 9, 9]}
        track = Track(rng, lambda: rng.uniform(0, 0.7, 3), rng.choice(["LINEAR", "STEP", "CUBICSPLINE"]))
        corners = CORNERS + np.tensordot(track.at(time), targets.astype(float), 1)
        times, widths = document.accessor("SCALAR", track.times), track.values
        if track.interpolation == "CUBICSPLINE":
            widths = np.stack([track.tangents[0], track.values, track.tangents[1]], 1)
        output = document.accessor("SCALAR", widths.ravel())
        samplers = [{"input": times, "output": output, "interpolation": track.interpolation}]
        channels, placed = [{"sampler": 0, "target": {"node": 0, "path": "weights"}}], np.eye(4)
    else:
        samplers = [track.add(document) for track in tracks.values()]
        node = 1 if kind == "joints" else 0
        targets = [{"node": node, "path": path} for path in tracks]
        channels = [{"sampler": at, "target": target} for at, target in enumerate(targets)]
        placed = matrix(*(track.at(time) for track in tracks.values()))
    if kind == "joints":
        # Half of each vertex hangs on a joint that stands still.
        still = np.eye(4)
        still[:2, 3] = rng.uniform(-0.3, 0.3, 2)
        joints = np.tile([0, 1, 0, 0], (4, 1))
        primitive["attributes"]["JOINTS_0"] = document.accessor("VEC4", joints, "u1")
        primitive["attributes"]["WEIGHTS_0"] = document.accessor("VEC4", np.tile([0.5, 0.5, 0, 0], (4, 1)))
        skin = document.accessor("MAT4", np.tile(np.eye(4).T.ravel(), (2, 1)))
        nodes = [{"mesh": 0, "skin": 0}, {}, {"matrix": still.T.ravel().tolist()}]
        more["skins"] = [{"joints": [1, 2], "inverseBindMatrices": skin}]
        placed = (placed + still) / 2
    more["animations"] = [{"samplers": samplers, "channels": channels}]
    keys = f"time = {time!r}\n"
    if kind == "chosen by name":
        other = {"samplers": [], "channels": [], "name": "other"}
        more["animations"] = [other, more["animations"][0] | {"name": "this one"}]
        keys += f'animation = "{rng.choice(["this one", "1"])}"\n'
    path = document.write(folder / "a.glb", nodes, primitive, None, mesh, **more)
    place = corners @ placed[:3, :3].T + placed[:3, 3]
    # A corner moved out of the plane of the others makes two triangles of it.
    triangles = [place[[0, 1, 2], :2], place[[0, 2, 3], :2]]
    return path, [(triangle, 1.0) for triangle in triangles], keys


def unit(numbers):
    return numbers / np.linalg.norm(numbers)


KINDS = {
    kind: (lambda rng, folder, kind=kind: animated(rng, folder, kind))
    for kind in ("lines", "steps", "splines", "weights", "joints", "chosen by name")
}
