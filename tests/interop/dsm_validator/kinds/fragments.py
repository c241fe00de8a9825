"""Kind `fragments`, version 1: planes with coverage (section 13)."""

from ..blocks import split
from ..fault import demand
from ..functions import counts, words_of_bits
from . import layering
from .planes import Planes, check_coverage_key, check_held


class Fragments:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_no_resets(layering.check_layering(metadata))
        layering.check_exact(metadata)
        check_coverage_key(metadata)
        layering.check_share(metadata, "folded")
        demand(metadata.fields.nullable("media") is None, "metadata", "fragments of version 1 have no key media")

    check_levels = staticmethod(layering.check_crop)
    check_errors = staticmethod(layering.check_no_errors)

    @staticmethod
    def lengths(entry, channels, contents):
        m = entry.count
        return [entry.pixels + 1, m, m, m, words_of_bits(m), m * channels, m, m]

    @staticmethod
    def check_tile(metadata, entry, contents):
        m, channels = entry.count, metadata.channels
        lengths = Fragments.lengths(entry, channels, contents)
        starts, w, right, down, flags, opacities, low, high = split(entry, contents, lengths)
        counted = counts(starts, m, entry.place, "fragments")
        planes = Planes.of(counted, w, (right, down), flags, opacities, (low, high), channels, entry.place)
        planes.check(metadata, entry.place)
        check_held(entry, planes)
