"""Kind `deep`: a visibility function a pixel (sections 4, 5, 7 and 8)."""

from ..codecs import CODECS
from ..fault import demand
from ..functions import check_functions, check_range
from .layering import check_crop


class Deep:
    codecs = tuple(CODECS)

    @staticmethod
    def check_metadata(metadata):
        """No keys besides those of every kind."""

    @staticmethod
    def check_levels(metadata, levels):
        first = levels[0]
        demand(first.tolerance == metadata.tolerance, first.place, "its tolerance is not that of the metadata")
        check_crop(metadata, levels)

    @staticmethod
    def lengths(entry, channels, contents):
        return CODECS[entry.codec].lengths(entry, channels, contents)

    @staticmethod
    def check_tile(metadata, entry, contents):
        functions = CODECS[entry.codec].functions(entry, contents, metadata.channels)
        check_functions(functions, entry.place)
        check_range(entry, functions.depths.min(), functions.depths.max())
