"""The codecs of kind `deep` (section 7), a table: what columns each has, and how they become functions."""

import numpy as np

from . import coded
from .blocks import CODED, split
from .fault import demand
from .functions import Functions, bits, counts, values_of, words_of_bits

LARGEST_DEPTH_BITS = 0x7F7FFFFF


def _column_lengths(entry, channels, words):
    """Of codec 0's columns, which take `words` words in all; m is the entry's count."""
    n, m = entry.pixels, entry.count
    if channels == 1:
        return [n + 1, None, None, m, m]
    rest = words - 2 * (n + 1) - words_of_bits(n) - m
    demand(0 <= rest < 2**32, entry.place, "its length has no room for its values")
    return [n + 1, n + 1, words_of_bits(n), m, rest]


class _Tables:
    """How vertices and values belong to pixels: the columns that both codecs have in common."""

    def __init__(self, entry, channels, starts, value_starts, mono, count, values):
        self.channels = channels
        self.counted = counts(starts, count, entry.place, "vertices")
        if channels == 1:
            self.value_counts = self.counted
            self.places = [np.arange(count)]
        else:
            self.value_counts = counts(value_starts, values, entry.place, "values")
            flags = bits(mono, entry.pixels, entry.place)
            self.places = values_of(self.counted, self.value_counts, flags, entry.place)

    def functions(self, depths, values):
        return Functions(self.counted, depths, [values[place] for place in self.places])

    def runs_of_values(self):
        """The lengths of the runs of values that each belong to a pixel's channel, or to all of its channels."""
        repeat = np.where(self.value_counts == self.counted, 1, 3)
        return np.repeat(self.counted, repeat)


class Exact:
    """Codec 0: depths and values as they are."""

    # Of one channel, columns that are missing; their bits of `differences` are without meaning.
    spare = (1, 2)

    @staticmethod
    def lengths(entry, channels, contents):
        return _column_lengths(entry, channels, len(contents) // 4)

    @staticmethod
    def functions(entry, contents, channels):
        columns = split(entry, contents, Exact.lengths(entry, channels, contents), Exact.spare)
        starts, value_starts, mono, depths, values = columns
        tables = _Tables(entry, channels, starts, value_starts, mono, entry.count, len(values))
        return tables.functions(depths.view("<f4"), values.view("<f4"))


class Quantized:
    """Codec 1: depths and values on grids, as changes."""

    spare = (2, 3)

    @staticmethod
    def lengths(entry, channels, contents):
        return [1, *_column_lengths(entry, channels, len(contents) // 4 - 1)]

    @staticmethod
    def functions(entry, contents, channels):
        if entry.block == CODED:
            return coded.functions(entry, contents, channels)
        columns = split(entry, contents, Quantized.lengths(entry, channels, contents), Quantized.spare)
        header, starts, value_starts, mono, changes, falls = columns
        dropped, grid = int(header[0]) & 0xFF, int(header[0]) >> 8
        demand(dropped <= 23 and grid <= 24, entry.place, f"its header has a = {dropped}, b = {grid}")
        tables = _Tables(entry, channels, starts, value_starts, mono, entry.count, len(falls))
        codes = _depth_codes(changes, tables.counted)
        demand((codes <= LARGEST_DEPTH_BITS >> dropped).all(), entry.place, "a depth's code is above the largest's")
        depths = (codes << np.uint32(dropped)).astype(np.uint32).view(np.float32)
        value_codes = _value_codes(falls, tables.runs_of_values(), grid)
        demand((value_codes <= 1 << grid).all(), entry.place, "a value's code is below 0, or above 1")
        return tables.functions(depths, value_codes.astype(np.float64) / (1 << grid))


def _depth_codes(changes, counted):
    """A pixel's first code follows the first one of the last pixel before with vertices, others the one before."""
    counted = counted[counted > 0]
    firsts = np.concatenate(([0], np.cumsum(counted)))[:-1]
    # These alone have a sign, in their lowest bit.
    signed = changes[firsts]
    first_codes = np.cumsum((signed >> 1) ^ (np.uint32(0) - (signed & 1)), dtype=np.uint32)
    along = np.cumsum(changes, dtype=np.uint32)
    return along + np.repeat(first_codes - along[firsts], counted)


def _value_codes(falls, runs, grid):
    """Each code is the one before it less the fall; a run starts from the code of 1."""
    runs = runs[runs > 0]
    firsts = np.concatenate(([0], np.cumsum(runs)))[:-1]
    along = np.cumsum(falls, dtype=np.uint32)
    before = along[firsts] - falls[firsts]
    return np.uint32(1 << grid) - (along - np.repeat(before, runs))


# A new codec, or a new version of one's payload, is a new line.
CODECS = {0: Exact, 1: Quantized}
