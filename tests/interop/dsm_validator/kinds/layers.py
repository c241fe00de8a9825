"""Kind `layers`: the first hits of every pixel's centre (section 13)."""

from ..blocks import split
from ..fault import demand
from ..functions import check_depths, check_range, counts, owners
from . import layering


class Layers:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_no_resets(layering.check_layering(metadata))
        layering.check_exact(metadata)
        layering.check_share(metadata, "left_out")
        demand(metadata.fields.nullable("coverage") is None, "metadata", "maps of layers have no key coverage")

    check_levels = staticmethod(layering.check_crop)
    check_errors = staticmethod(layering.check_no_errors)

    @staticmethod
    def lengths(entry, channels, contents):
        return [entry.pixels + 1, entry.count, entry.count * channels]

    @staticmethod
    def check_tile(metadata, entry, contents):
        m, channels = entry.count, metadata.channels
        starts, depths, opacities = split(entry, contents, Layers.lengths(entry, channels, contents))
        counted = counts(starts, m, entry.place, "layers")
        layering.check_most(counted, layering.max_layers(metadata), entry.place)
        depths = depths.view("<f4")
        check_depths(owners(counted)[0], depths, entry.place)
        layering.check_opacities(layering.channels_of(opacities, channels), entry.place, nonzero=False)
        check_range(entry, depths.min(), depths.max())
