"""What a glTF file draws, from the document that pygltflib reads, in float64."""

import base64
import tomllib

import numpy as np
import pygltflib

from animation_made import matrix, turned_part

TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Reader:
    def __init__(self, path):
        self.gltf = pygltflib.GLTF2().load(str(path))
        uri = self.gltf.buffers[0].uri
        self.data = base64.b64decode(uri.split(",")[1]) if uri else self.gltf.binary_blob()
        self.pose = {}

    def bytes(self, view, offset, kind, width, count):
        view = self.gltf.bufferViews[view]
        kind = np.dtype(kind)
        stride = view.byteStride or kind.itemsize * width
        start = (view.byteOffset or 0) + (offset or 0)
        rows = [np.frombuffer(self.data, kind, width, start + at * stride) for at in range(count)]
        return np.array(rows).reshape(count, width)

    def array(self, index, fractions=False):
        accessor = self.gltf.accessors[index]
        kind, width = TYPES[accessor.componentType], WIDTHS[accessor.type]
        values = np.zeros((accessor.count, width), kind)
        if accessor.bufferView is not None:
            values = self.bytes(accessor.bufferView, accessor.byteOffset, kind, width, accessor.count).copy()
        if accessor.sparse:
            sparse = accessor.sparse
            at = sparse.indices
            places = self.bytes(at.bufferView, at.byteOffset, TYPES[at.componentType], 1, sparse.count)
            at = sparse.values
            values[places.ravel()] = self.bytes(at.bufferView, at.byteOffset, kind, width, sparse.count)
        whole = values.dtype.kind in "iu"
        largest = np.iinfo(values.dtype).max if whole else 1
        values = values.astype(float)
        return np.maximum(values / largest, -1) if whole and (accessor.normalized or fractions) else values

    def set_time(self, keys):
        """Nodes where the scene's keys have them."""
        if "time" not in keys:
            return
        animations = self.gltf.animations
        name = keys.get("animation", "0")
        named = [animation for animation in animations if animation.name == name]
        animation = named[0] if named else animations[int(name)]
        for channel in animation.channels:
            sampler = animation.samplers[channel.sampler]
            times = self.array(sampler.input).ravel()
            values = self.array(sampler.output, fractions=channel.target.path == "rotation")
            mode = sampler.interpolation or "LINEAR"
            parts = 3 if mode == "CUBICSPLINE" else 1
            values = values.reshape(len(times), parts, -1)
            found = interpolated(times, values, keys["time"], mode, channel.target.path)
            self.pose.setdefault(channel.target.node, {})[channel.target.path] = found

    def local(self, index):
        node, pose = self.gltf.nodes[index], self.pose.get(index, {})
        if node.matrix:
            return np.array(node.matrix).reshape(4, 4).T
        usual = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
        parts = [pose.get(key, getattr(node, key) or usual[key]) for key in usual]
        return matrix(*parts)

    def worlds(self):
        """Node to world, and whether it is seen."""
        found = {}

        def visit(index, parent, seen):
            node = self.gltf.nodes[index]
            seen = seen and (node.extensions or {}).get("KHR_node_visibility", {}).get("visible", True)
            found[index] = parent @ self.local(index), seen
            for child in node.children or []:
                visit(child, found[index][0], seen)

        for top in self.gltf.scenes[self.gltf.scene or 0].nodes:
            visit(top, np.eye(4), True)
        return found

    def triangles(self):
        worlds, result = self.worlds(), []
        for index, (world, seen) in worlds.items():
            node = self.gltf.nodes[index]
            if seen and node.mesh is not None:
                for primitive in self.gltf.meshes[node.mesh].primitives:
                    result += self.primitive(index, primitive, world, worlds)
        return result

    def primitive(self, index, primitive, world, worlds):
        node = self.gltf.nodes[index]
        places = self.array(primitive.attributes.POSITION)
        weights = self.gltf.meshes[node.mesh].weights or []
        weights = self.pose.get(index, {}).get("weights", getattr(node, "weights", None) or weights)
        for weight, target in zip(weights, primitive.targets or []):
            target = target if isinstance(target, dict) else vars(target)
            places = places + weight * self.array(target["POSITION"])
        corners = self.array(primitive.indices).astype(int).ravel()
        if primitive.mode == 5:
            faces = [corners[at : at + 3] for at in range(len(corners) - 2)]
        elif primitive.mode == 6:
            faces = [corners[[0, at, at + 1]] for at in range(1, len(corners) - 1)]
        else:
            faces = corners.reshape(-1, 3)
        homogeneous = np.concatenate([places, np.ones((len(places), 1))], 1)
        if node.skin is not None:
            skin = self.gltf.skins[node.skin]
            unbind = self.array(skin.inverseBindMatrices).reshape(-1, 4, 4)
            bones = [worlds[joint][0] @ unbind[at].T for at, joint in enumerate(skin.joints)]
            joints = self.array(primitive.attributes.JOINTS_0).astype(int)
            shares = self.array(primitive.attributes.WEIGHTS_0, fractions=True)
            blend = [sum(w * bones[j] for j, w in zip(*pair)) for pair in zip(joints, shares)]
            copies = [np.einsum("nij,nj->ni", np.array(blend), homogeneous)]
        else:
            copies = [homogeneous @ (world @ place).T for place in self.instances(node)]
        return [copy[face][:, :2] for copy in copies for face in faces]

    def instances(self, node):
        instancing = (node.extensions or {}).get("EXT_mesh_gpu_instancing")
        if not instancing:
            return [np.eye(4)]
        attributes = instancing["attributes"]
        names = ("TRANSLATION", "ROTATION", "SCALE")
        return [matrix(*parts) for parts in zip(*(self.array(attributes[name], name == "ROTATION") for name in names))]


def interpolated(times, values, time, mode, path):
    part = 1 if mode == "CUBICSPLINE" else 0
    if time <= times[0] or time >= times[-1]:
        return values[0 if time <= times[0] else -1, part]
    at = int(np.flatnonzero(times <= time)[-1])
    length = times[at + 1] - times[at]
    t = (time - times[at]) / length
    first, second = values[at, part], values[at + 1, part]
    if mode == "STEP":
        return first
    if mode == "CUBICSPLINE":
        leave, arrive = values[at, 2] * length, values[at + 1, 0] * length
        return first + t * (leave + t * (3 * (second - first) - 2 * leave - arrive + t * (2 * (first - second) + leave + arrive)))
    return turned_part(first, second, t) if path == "rotation" else first * (1 - t) + second * t


def triangles(path, keys):
    """Each as its corners' x and y."""
    reader = Reader(path)
    reader.set_time(tomllib.loads(keys))
    return reader.triangles()
