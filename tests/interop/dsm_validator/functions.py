"""Tables of starts, and visibility functions as section 8 has them."""

from dataclasses import dataclass

import numpy as np

from .fault import demand


def words_of_bits(count):
    return -(-count // 32)


def bits(words, count, place):
    """The first `count` bits of words, whose others are zero."""
    flags = np.unpackbits(np.ascontiguousarray(words).view(np.uint8), bitorder="little")
    demand(not flags[count:].any(), place, "bits behind the last flag are not zero")
    return flags[:count].astype(bool)


def counts(starts, end, place, what):
    """How many each item of a table of starts has."""
    demand(starts[0] == 0, place, f"the table of {what} does not begin with 0")
    difference = np.diff(starts.astype(np.int64))
    demand((difference >= 0).all(), place, f"the table of {what} falls")
    demand(starts[-1] == end, place, f"the table of {what} ends with {starts[-1]}, not {end}")
    return difference


def owners(counted):
    """For each element the item it belongs to, and its place in that item."""
    item = np.repeat(np.arange(len(counted)), counted)
    starts = np.concatenate(([0], np.cumsum(counted)))[:-1]
    return item, np.arange(len(item)) - starts[item]


@dataclass(frozen=True)
class Functions:
    """Vertices of several functions: `counted` vertices each, depths, and the values of each channel."""

    counted: np.ndarray
    depths: np.ndarray
    values: list


def values_of(counted, value_counts, mono, place):
    """The place of each vertex's value in each of three channels, after the tables were checked."""
    plain = value_counts == counted
    demand((plain | (value_counts == 3 * counted)).all(), place, "a pixel has neither v nor 3 v values")
    demand((mono == plain).all(), place, "the mono flags are not those of the tables")
    item, local = owners(counted)
    starts = np.concatenate(([0], np.cumsum(value_counts)))[:-1]
    step = np.where(plain, 0, counted)
    return [starts[item] + local + channel * step[item] for channel in range(3)]


def check_depths(item, depths, place):
    """Finite, not negative, never falling within an item, at most two at one depth."""
    demand((np.isfinite(depths) & (depths >= 0)).all(), place, "a depth is not finite and ≥ 0")
    same = item[1:] == item[:-1]
    demand((~same | (depths[1:] >= depths[:-1])).all(), place, "depths fall")


def check_functions(functions, place):
    item, local = owners(functions.counted)
    depths = functions.depths
    check_depths(item, depths, place)
    three = (item[2:] == item[:-2]) & (depths[2:] == depths[:-2])
    demand(not three.any(), place, "three vertices stand at one depth")
    same = item[1:] == item[:-1]
    for values in functions.values:
        demand((values[local == 0] == 1).all(), place, "a first value is not 1")
        demand((values >= 0).all(), place, "a value is not ≥ 0")
        demand((~same | (values[1:] <= values[:-1])).all(), place, "values rise")


def check_range(entry, least, most):
    """The depths of the entry are those of the payload."""
    demand(
        entry.least_depth == least and entry.most_depth == most,
        entry.place,
        f"its depths are {least} to {most}, not {entry.least_depth} to {entry.most_depth}",
    )
