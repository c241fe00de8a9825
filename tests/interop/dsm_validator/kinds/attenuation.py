"""Kind `attenuation`: what each place sees of the light (section 13)."""

from ..fault import demand
from ..fields import MOST_U32
from . import layering
from .texels import check_lists, lengths


class Attenuation:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_exact(metadata)
        metadata.fields.integer("light_samples", 1, MOST_U32)
        metadata.fields.real("depth_tolerance", least=0)

    @staticmethod
    def check_levels(metadata, levels):
        layering.check_whole(metadata, levels)
        demand(len(levels) == 1, "levels", "there is more than one")

    check_errors = staticmethod(layering.check_no_errors)
    lengths = staticmethod(lengths)

    @staticmethod
    def check_tile(metadata, entry, contents):
        check_lists(metadata, entry, contents)
