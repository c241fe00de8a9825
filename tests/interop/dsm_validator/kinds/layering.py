"""What maps of layers have in common (section 13, layered maps)."""

import numpy as np

from ..fault import demand
from ..fields import MOST_U32
from ..functions import owners


def check_layering(metadata):
    """The key `layering`, and what depends on nothing else."""
    layering = metadata.fields.object("layering")
    layering.integer("resets", 0, MOST_U32)
    layering.integer("max_layers", 1, MOST_U32)
    layering.real("light_depth", least=0)
    return layering


def check_no_resets(layering):
    demand(layering.integer("resets", 0, MOST_U32) == 0, layering.name, "a map of this kind has no resets")


def max_layers(metadata):
    return metadata.fields.object("layering").integer("max_layers", 1, MOST_U32)


def check_share(metadata, key):
    """`left_out` or `folded`: how many pixels, the most light of one of them, and the mean over all."""
    share = metadata.fields.object_or_null(key)
    if share is None:
        return
    share.integer("pixels", 0, 2**64 - 1)
    for part in ("max", "mean"):
        share.real(part, least=0, most=1)
    if share.nullable("sum") is not None:
        share.integer("sum", 0, 2**64 - 1)


def check_exact(metadata):
    demand(metadata.tolerance == 0, "metadata: tolerance", "a map of this kind has a tolerance of 0")


def check_no_errors(levels, directories):
    """The tolerance and all errors of maps that are not compressed are 0."""
    for level, entries in zip(levels, directories):
        demand(level.tolerance == 0, level.place, "its tolerance is not 0")
        for part in (level, *entries):
            demand(part.largest_error == 0 and part.mean_error == 0, part.place, "its errors are not 0")


def check_crop(metadata, levels):
    """Level 0 of view 0 is the whole map, or the file holds a crop (section 5): whole tiles of it, of every view."""
    first = levels[0]
    whole = (metadata.width, metadata.height)
    pixels = (first.column, first.row, first.width, first.height)
    if pixels == (0, 0, *whole):
        return
    for level in levels:
        same = (level.column, level.row, level.width, level.height) == pixels
        demand(level.number == 0 and same, level.place, "a crop has one level a view, all of the same pixels")
    for begin, size, tile, end in zip(pixels[:2], pixels[2:], (first.tile_width, first.tile_height), whole):
        demand(begin >= 0 and begin + size <= end, first.place, "it does not lie in the whole map")
        demand(begin % tile == 0, first.place, "it does not begin on a tile's border")
        demand(begin + size == end or (begin + size) % tile == 0, first.place, "it does not end on a tile's border")


def check_whole(metadata, levels):
    """Level 0 of view 0 is the whole map."""
    first = levels[0]
    demand(
        (first.column, first.row, first.width, first.height) == (0, 0, metadata.width, metadata.height),
        first.place,
        "it is not the whole map",
    )


def check_most(counted, most, place, what="layers"):
    demand((counted <= most).all(), place, f"a pixel has more than {most} {what}")


def channels_of(column, channels):
    """A column that has the values of the first channel, then of the second and the third."""
    return column.view("<f4").reshape(channels, -1)


def check_opacities(opacities, place, nonzero):
    demand(((opacities >= 0) & (opacities <= 1)).all(), place, "an opacity does not lie in [0, 1]")
    demand(not nonzero or (opacities != 0).any(axis=0).all(), place, "an opacity is 0 in every channel")


def never_falls(counted, numbers):
    item, _ = owners(counted)
    same = item[1:] == item[:-1]
    return bool((~same | (numbers[1:] >= numbers[:-1])).all())


def depth_of(w):
    """1 / w, rounded to f32; the largest one where that overflows."""
    with np.errstate(over="ignore"):
        depth = np.float32(1.0 / float(w))
    return min(depth, np.finfo(np.float32).max)
