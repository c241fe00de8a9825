"""Kind `fragments`, version 2: planes and media (section 13)."""

import numpy as np

from ..blocks import split
from ..fault import demand
from ..fields import MOST_U32
from ..functions import counts, owners, words_of_bits
from . import layering
from .deep import Deep
from .planes import Planes, check_coverage_key, check_held


class Media:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_no_resets(layering.check_layering(metadata))
        check_coverage_key(metadata)
        layering.check_share(metadata, "folded")
        metadata.fields.object("media").integer("max_slabs", 1, MOST_U32)

    @staticmethod
    def check_levels(metadata, levels):
        layering.check_crop(metadata, levels)
        Deep.check_levels(metadata, levels)

    @staticmethod
    def lengths(entry, channels, contents):
        m = _fragments(entry, len(contents) // 4, channels)
        b = entry.count - m
        return [2 * entry.pixels + 2, m, 2 * m, words_of_bits(m), m * channels, 2 * m, b, b * channels]

    @staticmethod
    def check_tile(metadata, entry, contents):
        n, channels, place = entry.pixels, metadata.channels, entry.place
        lengths = Media.lengths(entry, channels, contents)
        m, b = lengths[1], lengths[6]
        tables, w, gradients, flags, opacities, coverage, borders, thicknesses = split(entry, contents, lengths)
        fragments = counts(tables[: n + 1], m, place, "fragments")
        slabs = counts(tables[n + 1 :], b, place, "borders")
        pairs = [(column[:m], column[m:]) for column in (gradients, coverage)]
        planes = Planes.of(fragments, w, pairs[0], flags, opacities, pairs[1], channels, place)
        planes.check(metadata, place)
        depths = borders.view("<f4")
        most = metadata.fields.object("media").integer("max_slabs", 1, MOST_U32)
        _check_slabs(slabs, depths, layering.channels_of(thicknesses, channels), most, place)
        check_held(entry, planes, depths)


def _fragments(entry, words, channels):
    """m: the words that all columns have grow with it, and the entry states m + b."""
    fixed = 2 * entry.pixels + 2

    def total(m):
        return fixed + m * (5 + channels) + words_of_bits(m) + (entry.count - m) * (1 + channels)

    low, high = 0, entry.count
    while low < high:
        middle = (low + high) // 2
        low, high = (middle + 1, high) if total(middle) < words else (low, middle)
    demand(total(low) == words, entry.place, "its length is not that of its columns")
    return low


def _check_slabs(counted, depths, thicknesses, most, place):
    demand(((counted == 0) | (counted >= 2)).all(), place, "a pixel has one border")
    layering.check_most(counted, most + 1, place, "borders")
    demand((np.isfinite(depths) & (depths >= 0)).all(), place, "a border's depth is not finite and ≥ 0")
    item, local = owners(counted)
    same = item[1:] == item[:-1]
    demand((~same | (depths[1:] > depths[:-1])).all(), place, "borders do not rise")
    demand((np.isfinite(thicknesses) & (thicknesses >= 0)).all(), place, "a thickness is not finite and ≥ 0")
    demand((thicknesses[:, local == 0] == 0).all(), place, "a first border has a thickness")
    last = local == counted[item] - 1
    demand((thicknesses[:, last] != 0).any(axis=0).all(), place, "a last border has no thickness")
