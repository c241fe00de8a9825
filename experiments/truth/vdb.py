"""OpenVDB fog volumes: one grid that is not compressed, of floats or half floats, in a tree of 32³, 16³ and 8³."""

import struct
from pathlib import Path

import numpy as np

MAGIC, VERSION = 0x56444220, 224
# The only compression there is here: of a node's values those that are active.
ACTIVE_MASK = 2
# How a node's values are stored: all active, the others 0 (0); all of them (6).
ALL_VALUES = 6


class Cursor:
    """The bytes of a file, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, layout):
        values = struct.unpack_from("<" + layout, self.data, self.at)
        self.at += struct.calcsize("<" + layout)
        return values

    def one(self, layout):
        return self.take(layout)[0]

    def text(self):
        size = self.one("I")
        self.at += size
        return self.data[self.at - size : self.at].decode("latin-1")

    def array(self, dtype, count):
        values = np.frombuffer(self.data, dtype, count, self.at)
        self.at += values.nbytes
        return values

    def mask(self, count):
        return np.unpackbits(self.array("u1", count // 8), bitorder="little").astype(bool)

    def skip_metadata(self):
        for _ in range(self.one("I")):
            self.text(), self.text()
            self.text()


def place(number, log2):
    """Where in a node its `number`th entry stands: z is the fastest."""
    side = (1 << log2) - 1
    return np.array([number >> 2 * log2, number >> log2 & side, number & side])


def read(path):
    """The grid of a file with one: its values over their box, the index of the first, and the voxel's side.

    Voxels that are not active are 0, and no inner node may be active as a whole.
    """
    file = Cursor(Path(path).read_bytes())
    magic, version, _, _, _ = file.take("QIIIB")
    if magic != MAGIC or version < 222:
        raise ValueError(f"{path}: not an OpenVDB file of today's layout")
    file.at += 36
    file.skip_metadata()
    if file.one("I") != 1:
        raise ValueError(f"{path}: more grids than one")
    file.text()
    dtype = "<f2" if file.text().endswith("HalfFloat") else "<f4"
    file.text()
    start, blocks, _ = file.take("QQQ")
    file.at = start
    if file.one("I") & ~ACTIVE_MASK:
        raise ValueError(f"{path}: compressed values")
    file.skip_metadata()
    translation = file.take("3d") if "Translate" in file.text() else (0.0, 0.0, 0.0)
    voxel = file.take("15d")[0]
    leaves = topology(file, dtype)
    file.at = blocks
    values = [leaf_values(file, dtype) for _ in leaves]
    low = np.min(leaves, axis=0)
    box = np.zeros(np.max(leaves, axis=0) - low + 8, "f4")
    for leaf, own in zip(leaves, values, strict=True):
        x, y, z = leaf - low
        box[x : x + 8, y : y + 8, z : z + 8] = own.reshape(8, 8, 8)
    return box, low * voxel + np.array(translation), voxel


def topology(file, dtype):
    """The origins of all leaves, in the order in which they are stored."""
    file.one("I"), file.one("f")
    tiles, roots = file.take("II")
    if tiles:
        raise ValueError("tiles of the root")
    leaves = []
    for _ in range(roots):
        origin = np.array(file.take("3i"))
        for child in inner_node(file, dtype, 5):
            middle = origin + place(child, 5) * 128
            for leaf in inner_node(file, dtype, 4):
                file.mask(512)
                leaves.append(middle + place(leaf, 4) * 8)
    return leaves


def inner_node(file, dtype, log2):
    """The children of a node; what follows it are theirs."""
    count = 1 << 3 * log2
    children, active = file.mask(count), file.mask(count)
    if active.any():
        raise ValueError("an inner node with values")
    node_values(file, dtype, active)
    return np.flatnonzero(children)


def leaf_values(file, dtype):
    return node_values(file, dtype, file.mask(512))


def node_values(file, dtype, active):
    how = file.one("B")
    if how == ALL_VALUES:
        return np.where(active, file.array(dtype, active.size).astype("f4"), 0)
    if how in (2, 4, 5):
        file.array(dtype, 2 if how == 5 else 1)
    if how in (3, 4, 5):
        file.mask(active.size)
    values = np.zeros(active.size, "f4")
    values[active] = file.array(dtype, int(active.sum()))
    return values


def write(path, values, voxel):
    """Writes floats whose first stands at the origin of the file's space; sides are multiples of 8, at most 128."""
    assert all(side % 8 == 0 and side <= 128 for side in values.shape)
    counts = [side // 8 for side in values.shape]
    numbers = [x << 8 | y << 4 | z for x, y, z in np.ndindex(*counts)]
    full = b"\xff" * 64

    def text(string):
        return struct.pack("<I", len(string)) + string.encode()

    head = struct.pack("<QIIIB", MAGIC, VERSION, 9, 0, 1) + b"0" * 36 + struct.pack("<II", 0, 1)
    head += text("density") + text("Tree_float_5_4_3") + text("")
    scale = [voxel, voxel, 1 / voxel, 1 / voxel**2, 0.5 / voxel]
    body = struct.pack("<II", ACTIVE_MASK, 0) + text("UniformScaleMap")
    body += struct.pack("<15d", *np.repeat(scale, 3))
    body += struct.pack("<IfII", 1, 0.0, 0, 1) + struct.pack("<3i", 0, 0, 0)
    for log2, children in ((5, [0]), (4, numbers)):
        mask = np.zeros(1 << 3 * log2, bool)
        mask[children] = True
        body += np.packbits(mask, bitorder="little").tobytes() + bytes(mask.size // 8) + b"\0"
    body += full * len(numbers)
    leaves = b""
    for x, y, z in np.ndindex(*counts):
        own = values[8 * x : 8 * x + 8, 8 * y : 8 * y + 8, 8 * z : 8 * z + 8]
        leaves += full + b"\0" + np.ascontiguousarray(own, "<f4").tobytes()
    start = len(head) + 24
    offsets = struct.pack("<QQQ", start, start + len(body), start + len(body) + len(leaves))
    Path(path).write_bytes(head + offsets + body + leaves)
