"""Deep OpenEXR images as the official clients read them, and the light they let through.

A `DeepPart` keeps the samples of every pixel of one part, ragged: pixel i (row major, from the corner of the
data window) owns the samples offsets[i]..offsets[i + 1]. `DeepPart.transmittance` is the reference the checks
compare with: the product over a pixel's samples of what each leaves at a depth, in float64, after
"Interpreting OpenEXR Deep Pixels". It needs no order among the samples and no tidying.
"""

from dataclasses import dataclass, field

import numpy as np
import OpenEXR

# Pairs of (query, sample) evaluated at once: bounds the memory of a query over a big image.
PAIRS_AT_ONCE = 1 << 21

COLOUR_ALPHAS = (("AR", "RA"), ("AG", "GA"), ("AB", "BA"))


class NotADepthImage(ValueError):
    """The part has no channel Z, or no samples that could be read."""


@dataclass
class DeepPart:
    """One part: its samples, and the header attributes its reader gave."""

    name: str
    width: int
    height: int
    offsets: np.ndarray  # int64, width * height + 1
    z: np.ndarray  # float32, front depth of each sample
    z_back: np.ndarray  # float32, equal to z for a point
    alpha: np.ndarray  # float64, samples x 1 (one alpha for all) or samples x 3 (r, g, b)
    dropped: int = 0
    clamped: int = 0
    attributes: dict = field(default_factory=dict)

    @property
    def pixels(self):
        return self.width * self.height

    @property
    def channels(self):
        return self.alpha.shape[1]

    def sample_pixels(self):
        """The pixel of every sample."""
        return np.repeat(np.arange(self.pixels), np.diff(self.offsets))

    def transmittance(self, pixel, depth):
        """T at `depth` through `pixel` (arrays of equal length), one column a channel."""
        pixel = np.asarray(pixel, np.int64)
        depth = np.asarray(depth, np.float64)
        result = np.ones((pixel.size, self.channels))
        counts = self.offsets[pixel + 1] - self.offsets[pixel]
        asking = np.flatnonzero(counts)
        ends = np.cumsum(counts[asking])
        first = 0
        while first < asking.size:
            done = ends[first - 1] if first else 0
            last = max(first + 1, int(np.searchsorted(ends, done + PAIRS_AT_ONCE, "right")))
            query = asking[first:last]
            count = counts[query]
            start = np.cumsum(count) - count
            sample = np.arange(count.sum()) - np.repeat(start - self.offsets[pixel[query]], count)
            left = light_left(
                self.z[sample], self.z_back[sample], self.alpha[sample], np.repeat(depth[query], count)
            )
            result[query] = np.multiply.reduceat(left, start, axis=0)
            first = last
        return result


def light_left(z, z_back, alpha, depth):
    """What single samples leave at `depth`: arrays of n, and n x channels for alpha and the result."""
    z = np.asarray(z, np.float64)
    z_back = np.asarray(z_back, np.float64)
    volume = z_back > z
    thickness = np.where(volume, z_back - z, 1.0)
    share = np.clip((depth - z) / thickness, 0.0, 1.0)[:, None]
    opaque = alpha >= 1.0
    density = -np.log1p(-np.where(opaque, 0.0, alpha))
    inside = np.where(opaque, np.where((depth > z)[:, None], 0.0, 1.0), np.exp(-share * density))
    point = np.where((depth >= z)[:, None], 1.0 - alpha, 1.0)
    return np.where(volume[:, None], inside, point)


def make_part(name, width, height, counts, z, z_back, alphas, attributes=None):
    """A part from its channels; `alphas` maps channel names to values, and may be empty (opaque).

    Import rules: a sample whose depth is not finite or negative is dropped, an alpha is clamped to [0, 1].
    """
    z = np.asarray(z, np.float32)
    z_back = z.copy() if z_back is None else np.asarray(z_back, np.float32)
    whole = alphas.get("A", np.ones(z.size))
    colours = [next((alphas[n] for n in names if n in alphas), None) for names in COLOUR_ALPHAS]
    if any(c is not None for c in colours):
        columns = [whole if c is None else c for c in colours]
    else:
        columns = [whole]
    alpha = np.stack([np.asarray(c, np.float64) for c in columns], axis=1)

    keep = np.isfinite(z) & (z >= 0)
    pixel = np.repeat(np.arange(width * height), counts)[keep]
    offsets = np.zeros(width * height + 1, np.int64)
    np.cumsum(np.bincount(pixel, minlength=width * height), out=offsets[1:])
    alpha = alpha[keep]
    clamped = np.clip(alpha, 0.0, 1.0)
    z_back = np.where(z_back > z, z_back, z)
    return DeepPart(
        name=name,
        width=width,
        height=height,
        offsets=offsets,
        z=z[keep],
        z_back=z_back[keep],
        alpha=clamped,
        dropped=int((~keep).sum()),
        clamped=int((clamped != alpha).any(axis=1).sum()),
        attributes=attributes or {},
    )


def read_parts(path):
    """Every part of an OpenEXR file that has depths, as a list of `DeepPart`."""
    path = str(path)
    try:
        return _read_with_openexr(path)
    except RuntimeError as error:
        if "deepImageState" not in str(error):
            raise
        return _read_with_openimageio(path)


def read_part(path, name=None):
    """The part called `name`, or the first that has depths."""
    for part in read_parts(path):
        if name is None or part.name == name:
            return part
    raise NotADepthImage(f"{path}: no part {name or 'with depths'}")


def _alpha_names(names):
    known = {"A"}.union(*COLOUR_ALPHAS)
    return [n for n in names if n in known]


def _read_with_openexr(path):
    parts = []
    with OpenEXR.File(path, separate_channels=True) as file:
        for part in file.parts:
            header = {key: value for key, value in part.header.items() if key != "channels"}
            (x0, y0), (x1, y1) = header["dataWindow"]
            width, height = int(x1 - x0 + 1), int(y1 - y0 + 1)
            if "Z" not in part.channels:
                continue
            name = header.get("name", "")
            deep = header["type"] in (OpenEXR.deepscanline, OpenEXR.deeptile)
            read = _read_deep if deep else _read_flat
            parts.append(read(part.channels, name, width, height, header))
    return parts


def _read_deep(channels, name, width, height, header):
    lists = channels["Z"].pixels.ravel()
    counts = np.fromiter((0 if s is None else len(s) for s in lists), np.int64, lists.size)

    def column(channel):
        kept = [s for s in channels[channel].pixels.ravel() if s is not None]
        return np.concatenate(kept) if kept else np.zeros(0, np.float32)

    z_back = column("ZBack") if "ZBack" in channels else None
    alphas = {n: column(n) for n in _alpha_names(channels)}
    return make_part(name, width, height, counts, column("Z"), z_back, alphas, header)


def _read_flat(channels, name, width, height, header):
    """A depth image holds one opaque point a pixel, where its depth is finite."""
    z = np.asarray(channels["Z"].pixels, np.float32).ravel()
    return make_part(name, width, height, np.ones(z.size, np.int64), z, None, {}, header)


def _window(x, y, width, height):
    return (x, y), (x + width - 1, y + height - 1)


def _read_with_openimageio(path):
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(path)
    if source is None:
        raise NotADepthImage(f"{path}: {oiio.geterror()}")
    parts = []
    while source.seek_subimage(len(parts), 0):
        spec = source.spec()
        data = source.read_native_deep_image(len(parts), 0)
        if data is None:
            raise NotADepthImage(f"{path}: {source.geterror()}")
        names = list(spec.channelnames)
        pixels = spec.width * spec.height
        counts = np.fromiter((data.samples(p) for p in range(pixels)), np.int64, pixels)

        def column(channel):
            index = names.index(channel)
            values = [data.deep_value(p, index, s) for p in np.flatnonzero(counts) for s in range(counts[p])]
            return np.asarray(values, np.float32)

        z_back = column("ZBack") if "ZBack" in names else None
        alphas = {n: column(n) for n in _alpha_names(names)}
        attributes = {a.name: a.value for a in spec.extra_attribs}
        attributes["dataWindow"] = _window(spec.x, spec.y, spec.width, spec.height)
        attributes["displayWindow"] = _window(spec.full_x, spec.full_y, spec.full_width, spec.full_height)
        title = spec.get_string_attribute("oiio:subimagename")
        parts.append(make_part(title, spec.width, spec.height, counts, column("Z"), z_back, alphas, attributes))
    source.close()
    return parts


def next_above(depth):
    """The neighbouring float32 above."""
    return np.nextafter(np.asarray(depth, np.float32), np.float32(np.inf))


def next_below(depth):
    """The neighbouring float32 below."""
    return np.nextafter(np.asarray(depth, np.float32), np.float32(-np.inf))
