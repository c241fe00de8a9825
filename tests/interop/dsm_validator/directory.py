"""Tile directories (section 6), and the errors that levels and tiles state (section 5)."""

import math
import struct
from dataclasses import dataclass

from .extents import Extent
from .fault import Fault, demand
from .levels import check_errors

ENTRY = struct.Struct("<QQQQfffffIBBB5s")
SLACK = 1e-6
MEAN_SLACK = 1e-6


@dataclass(frozen=True)
class Entry:
    place: str
    pixels: int
    width: int
    offset: int
    length: int
    raw_length: int
    count: int
    least_depth: float
    most_depth: float
    largest_error: float
    mean_error: float
    depth_error: float
    checksum: int
    codec: int
    block: int
    differences: int
    empty: bool

    @property
    def extent(self):
        return Extent(self.place, self.offset, self.length)


def read_directory(contents, level, newer):
    """The entries of a level's tiles, each checked as far as it can be without its payload."""
    demand(
        len(contents) == ENTRY.size * level.tiles,
        level.place,
        f"its directory has {len(contents)} bytes for {level.tiles} tiles",
    )
    entries = []
    for index in range(level.tiles):
        raw = contents[ENTRY.size * index : ENTRY.size * (index + 1)]
        y, x = divmod(index, level.columns)
        entries.append(_entry(raw, f"tile ({x}, {y}) of level {level.index}", level.tile_pixels(index), level.tile_columns(index), newer))
    _check_level_errors(level, entries)
    return entries


def _entry(raw, place, pixels, width, newer):
    *numbers, reserved = ENTRY.unpack(raw)
    # Of the errors nothing is said, and −0 is 0.
    empty = not any(numbers[:6]) and not any(numbers[8:])
    entry = Entry(place, pixels, width, *numbers, empty)
    demand(newer or not any(reserved), place, "reserved bytes are not zero")
    check_errors(entry.largest_error, entry.mean_error, place)
    depths = (entry.least_depth, entry.most_depth, entry.depth_error)
    demand(all(math.isfinite(depth) and depth >= 0 for depth in depths), place, f"{depths} are no depths")
    demand(entry.least_depth <= entry.most_depth, place, "its depths are not in order")
    if not empty:
        demand(entry.offset, place, "its offset is 0, and it is not empty")
        demand(entry.count, place, "it is not empty, and it has no vertices")
    return entry


def _check_level_errors(level, entries):
    for entry in entries:
        demand(entry.largest_error <= level.tolerance + SLACK, entry.place, "its error is above the tolerance")
    largest = max(entry.largest_error for entry in entries)
    demand(level.largest_error == largest, level.place, f"its largest error is not {largest}, that of its tiles")
    total = 0.0
    for entry in entries:
        total += entry.mean_error * entry.pixels
    mean = total / (level.width * level.height)
    if not math.isclose(level.mean_error, mean, rel_tol=MEAN_SLACK, abs_tol=2.0**-149):
        raise Fault(level.place, f"its mean error is not {mean}, that of its tiles")
