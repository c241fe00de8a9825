"""Kind `prefiltered`: fragments in levels of wider and wider filters (section 13)."""

from ..fault import demand
from ..fields import MOST_U32
from . import layering
from .texels import check_lists, lengths

MOST_LEVELS = 25
MOST_TEXELS_A_SIDE = 1 << 24


class Prefiltered:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_no_resets(layering.check_layering(metadata))
        layering.check_exact(metadata)
        layering.check_share(metadata, "left_out")
        filtering = metadata.fields.object("filtering")
        _stack_from(filtering)
        _subsampled(filtering)
        if "joined" in filtering:
            filtering.flag("joined")
        epsilon = filtering.object("epsilon")
        (name,) = epsilon.value if len(epsilon.value) == 1 else (None,)
        demand(name in ("widths", "interval"), epsilon.name, "it has not one of widths and interval, and nothing else")
        epsilon.real(name, least=0)
        filtering.one_of("accumulate", ("add", "multiply", "max"))
        filtering.one_of("depth", ("mean", "weighted"))

    @staticmethod
    def check_levels(metadata, levels):
        layering.check_whole(metadata, levels)
        filtering = metadata.fields.object("filtering")
        demand(levels[-1].view == 0, levels[-1].place, "there is one view")
        last = len(levels) - 1
        demand(len(levels) <= MOST_LEVELS, "levels", f"there are more than {MOST_LEVELS}")
        wider = max(metadata.width, metadata.height)
        demand(wider <= MOST_TEXELS_A_SIDE, levels[0].place, f"a side has more than {MOST_TEXELS_A_SIDE} texels")
        demand(2**last < 2 * wider, "levels", "the last has squares wider than the map")
        stack = _stack_from(filtering)
        demand(last == 0 or (stack or 0) <= last, filtering.place("stack_from"), "there is no such level")
        demand(_subsampled(filtering) <= last, filtering.place("subsampled"), "there is no such level")
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


def _stack_from(filtering):
    return None if filtering.nullable("stack_from") is None else filtering.integer("stack_from", 0, MOST_U32)


def _subsampled(filtering):
    return filtering.integer("subsampled", 0, MOST_U32) if "subsampled" in filtering else 0


def _shape(index, last, stack, metadata):
    """View, number, first column and row, width and height of a level."""
    if stack is None or index <= stack:
        side = 1 << index
        return (0, index, 0, 0, -(-metadata.width // side), -(-metadata.height // side))
    side = 1 << stack
    spare = 0 if index == last else (1 << (index - stack - 1)) - 1
    columns, rows = (-(-size // side) + 1 + 2 * spare for size in (metadata.width, metadata.height))
    return (0, index, -spare, -spare, columns, rows)
