"""Deep OpenEXR images of many kinds, written by the official client, with the transmittance at points.

`KINDS` maps a name to a function of a random generator and a folder, which returns `Asked`.
"""

import struct
from dataclasses import dataclass, field

import numpy as np
import OpenEXR

import deep_truth
from generate import COMPRESSIONS, DeepImage, random_points, random_volumes

COMPRESSIONS = {**COMPRESSIONS, "zstd": OpenEXR.ZSTD_COMPRESSION}


@dataclass
class Asked:
    path: object
    points: np.ndarray
    want: np.ndarray
    space: str = "raster"
    switches: list = field(default_factory=list)
    # What a second reader says of the same points; it need not know layers.
    read: np.ndarray = None


def truth(image, types=()):
    """The part that the samples are, as if it had been read."""
    columns = {name: [] for name in image.names}
    for samples in image.samples:
        for sample in samples:
            for name, value in zip(image.names, sample):
                columns[name].append(np.float16(value) if dict(types).get(name) is np.float16 else np.float32(value))
    counts = np.array([len(samples) for samples in image.samples])
    alphas = {name: np.array(columns[name]) for name in image.names if name not in ("Z", "ZBack")}
    back = np.array(columns["ZBack"]) if "ZBack" in columns else None
    return deep_truth.make_part("", image.width, image.height, counts, np.array(columns["Z"]), back, alphas)


def places(part, rng, count=400):
    """Pixels, and depths a little off those of samples."""
    owner = part.sample_pixels()
    if not owner.size:
        return np.zeros(0, int), np.zeros(0)
    at = rng.integers(0, owner.size, count)
    share = rng.choice([0.9, 0.999, 1.001, 1.2], count)
    depth = np.where(rng.random(count) < 0.5, part.z[at], part.z_back[at]).astype(float) * share
    return owner[at], depth.astype(np.float32).astype(float)


def asked(path, part, rng, switches=(), reads=True):
    pixel, depth = places(part, rng)
    points = np.stack([pixel % part.width + 0.5, pixel // part.width + 0.5, depth], 1)
    want = part.transmittance(pixel, depth)
    read = deep_truth.read_part(path).transmittance(pixel, depth) if reads else None
    return Asked(path, points, want, switches=list(switches), read=read)


def drawn(rng):
    """Names, and a random image of them."""
    names = [("Z", "A"), ("Z", "ZBack", "A"), ("Z", "ZBack", "A", "AR", "AG", "AB")][int(rng.integers(3))]
    image = DeepImage(names, int(rng.integers(3, 20)), int(rng.integers(3, 20)))
    rule = random_points(rng) if len(names) == 2 else random_volumes(rng, len(names) - 2)
    return image.every_pixel(rule)


def written(image, path, names=None, compression="zips", **header):
    names = names or {}
    channels = {names.get(name, name): values for name, values in image.channels({}).items()}
    head = image.header(**header) | {"compression": COMPRESSIONS[compression]}
    with OpenEXR.File(head, channels) as file:
        file.write(str(path))
    return path


def packed(rng, folder, compression):
    image = drawn(rng)
    tile = (int(rng.integers(2, 9)), int(rng.integers(2, 9))) if rng.random() < 0.5 else None
    path = written(image, folder / "a.exr", compression=compression, tile=tile)
    return asked(path, truth(image), rng)


def camera(rng, folder, kind):
    """OpenEXR's camera: left-handed, along +z; NDC in [0, 1] with y down, or as the kind says."""
    image = DeepImage(("Z", "A"), 16, 12).every_pixel(random_points(rng))
    part = truth(image)
    # Right, up and forward are rows, a left-handed frame.
    axes, eye = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3) * 10
    axes *= -np.sign(np.linalg.det(axes))
    flip = -1.0 if kind.startswith("along -z") else 1.0
    to_camera = np.eye(4)
    to_camera[:3, :3] = (axes * np.array([1, 1, flip])[:, None]).T
    to_camera[3, :3] = -eye @ to_camera[:3, :3]
    reach = rng.uniform(0.3, 1.5) * np.array([1, 12 / 16])
    flat = kind.endswith("orthographic")
    screen = "screen" in kind
    lens = np.zeros((4, 4))
    lens[0, 0], lens[1, 1] = 1 / reach
    lens[2, 2], lens[3, 2] = flip * 0.01, 0.0
    if flat:
        lens[3, 3] = 1
    else:
        lens[2, 3] = flip
        lens[3, 2] = -0.1
    if not screen:
        # From [-1, 1] with y up to [0, 1] with y down.
        to_unit = np.eye(4)
        to_unit[0, 0], to_unit[1, 1], to_unit[3, :2] = 0.5, -0.5, 0.5
        lens = lens @ to_unit
    matrices = {"worldToCamera": to_camera.astype(np.float32), "worldToNDC": (to_camera @ lens).astype(np.float32)}
    head = image.header() | {"displayWindow": ((0, 0), (15, 11)), **matrices}
    path = folder / "a.exr"
    with OpenEXR.File(head, image.channels({})) as file:
        file.write(str(path))
    pixel, depth = places(part, rng)
    x, y = ((pixel % 16 + 0.5) / 16) * 2 - 1, 1 - ((pixel // 16 + 0.5) / 12) * 2
    scale = np.ones_like(depth) if flat else depth
    seen = np.stack([x * reach[0] * scale, y * reach[1] * scale, depth], 1)
    points = seen @ axes + eye
    return Asked(path, points, part.transmittance(pixel, depth), "world", read=deep_truth.read_part(path).transmittance(pixel, depth))


def layers(rng, folder, kind):
    image = drawn(rng)
    layer = ["beauty", "a.b", "ViewLayer.Combined", ""][int(rng.integers(4))]
    path, part, switches = folder / "a.exr", truth(image), []
    channels = {f"{layer}.{name}": values for name, values in image.channels({}).items()}
    if kind == "layers, chosen":
        other = DeepImage(image.names, image.width, image.height)
        for pixel, samples in enumerate(image.samples):
            for sample in samples:
                other.add(pixel, *np.array(sample) * 0.5)
        channels |= {f"other.{name}": values for name, values in other.channels({}).items()}
        if rng.random() < 0.5 and layer:
            switches = ["--layer", layer]
        else:
            switches = ["--channels", ",".join(f"{name}={layer}.{name}" for name in image.names)]
    if kind == "layers, alpha only":
        channels = {(name if name.startswith("Z") else f"{layer or 'x'}.{name}"): values for name, values in image.channels({}).items()}
    with OpenEXR.File(image.header(), channels) as file:
        file.write(str(path))
    return asked(path, part, rng, switches, reads=False)


def damaged(rng, folder, kind):
    """The table of the chunks' places lost: zeros in part of it, or all of it."""
    image = drawn(rng)
    path = written(image, folder / "a.exr", compression="zips")
    data = bytearray(path.read_bytes())
    at = 8
    while data[at]:
        at = data.index(0, at) + 1
        at = data.index(0, at) + 1
        at += 4 + struct.unpack_from("<i", data, at)[0]
    table = at + 1
    lost = np.arange(image.height) if kind.endswith("all") else rng.choice(image.height, 1 + image.height // 3, False)
    for chunk in lost:
        struct.pack_into("<q", data, table + 8 * int(chunk), 0)
    path.write_bytes(data)
    try:
        return asked(path, truth(image), rng)
    except Exception:
        return asked(path, truth(image), rng, reads=False)


KINDS = {
    **{f"in {name}": (lambda r, f, name=name: packed(r, f, name)) for name in COMPRESSIONS},
    **{
        f"camera {kind}": (lambda r, f, kind=kind: camera(r, f, kind))
        for kind in ("standard, perspective", "standard, orthographic", "screen, perspective", "screen, orthographic",
                     "along -z, perspective", "along -z, orthographic")
    },
    **{
        kind: (lambda r, f, kind=kind: layers(r, f, kind))
        for kind in ("layers, one", "layers, alpha only", "layers, chosen")
    },
    "table lost in part": lambda r, f: damaged(r, f, "part"),
    "table lost, all": lambda r, f: damaged(r, f, "all"),
}
