"""Kind `prefiltered`: fragments in levels of wider and wider filters (section 13)."""

from ..fault import demand
from . import layering
from .texels import check_lists, lengths

MOST_LEVELS = 25


class Prefiltered:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_no_resets(layering.check_layering(metadata))
        layering.check_exact(metadata)
        layering.check_share(metadata, "left_out")
        filtering = metadata.fields.object("filtering")
        _level(filtering, "stack_from")
        _level(filtering, "subsampled")
        if "joined" in filtering:
            filtering.flag("joined")
        epsilon = filtering.object("epsilon")
        named = [key for key in ("widths", "interval") if key in epsilon]
        demand(len(named) == 1, epsilon.name, "it has not one of widths and interval")
        epsilon.real(named[0], least=0)
        filtering.one_of("accumulate", ("add", "multiply", "max"))
        filtering.one_of("depth", ("mean", "weighted"))

    @staticmethod
    def check_levels(metadata, levels):
        layering.check_whole(metadata, levels)
        filtering = metadata.fields.object("filtering")
        last = len(levels) - 1
        demand(len(levels) <= MOST_LEVELS, "levels", f"there are more than {MOST_LEVELS}")
        wider = max(metadata.width, metadata.height)
        demand(2**last < 2 * wider, "levels", "the last has squares wider than the map")
        stack = _level(filtering, "stack_from")
        for key in ("stack_from", "subsampled"):
            named = _level(filtering, key) or 0
            demand(last == 0 or named <= last, filtering.place(key), "there is no such level")
        for level in levels:
            wanted = _shape(level.index, last, stack, metadata)
            found = (level.view, level.number, level.column, level.row, level.width, level.height)
            demand(found == wanted, level.place, f"its record is {found}, not {wanted}")

    check_errors = staticmethod(layering.check_no_errors)
    lengths = staticmethod(lengths)

    @staticmethod
    def check_tile(metadata, entry, contents):
        counted = check_lists(metadata, entry, contents)
        if entry.place.endswith("of level 0"):
            layering.check_most(counted, layering.max_layers(metadata), entry.place)


def _level(filtering, key):
    return None if filtering.nullable(key) is None else filtering.integer(key, 0, 2**32 - 1)


def _shape(index, last, stack, metadata):
    """View, number, first column and row, width and height of a level."""
    if stack is None or index <= stack:
        side = 1 << index
        return (0, index, 0, 0, -(-metadata.width // side), -(-metadata.height // side))
    side = 1 << stack
    spare = 0 if index == last else (1 << (index - stack - 1)) - 1
    columns, rows = (-(-size // side) + 1 + 2 * spare for size in (metadata.width, metadata.height))
    return (0, index, -spare, -spare, columns, rows)
