"""Kind `deep`: a visibility function a pixel (sections 4, 5, 7 and 8)."""

from ..codecs import CODECS
from ..fault import demand
from ..functions import check_functions, check_range


class Deep:
    codecs = tuple(CODECS)

    @staticmethod
    def check_metadata(metadata):
        """No keys besides those of every kind."""

    @staticmethod
    def check_levels(metadata, levels):
        first = levels[0]
        place = first.place
        demand(first.tolerance == metadata.tolerance, place, "its tolerance is not that of the metadata")
        whole = (metadata.width, metadata.height)
        if (first.column, first.row, first.width, first.height) == (0, 0, *whole):
            return
        demand(len(levels) == 1, place, "it is not the whole map, and a crop has one level")
        for begin, size, tile, end in zip(
            (first.column, first.row), (first.width, first.height), (first.tile_width, first.tile_height), whole
        ):
            demand(begin >= 0 and begin + size <= end, place, "it does not lie in the whole map")
            demand(begin % tile == 0, place, "it does not begin on a tile's border")
            demand(begin + size == end or (begin + size) % tile == 0, place, "it does not end on a tile's border")

    @staticmethod
    def lengths(entry, channels, contents):
        return CODECS[entry.codec].lengths(entry, channels, contents)

    @staticmethod
    def check_tile(metadata, entry, contents):
        functions = CODECS[entry.codec].functions(entry, contents, metadata.channels)
        check_functions(functions, entry.place)
        check_range(entry, functions.depths.min(), functions.depths.max())
