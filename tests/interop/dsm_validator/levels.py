"""The records of levels (section 5)."""

import struct
from dataclasses import dataclass

from .fault import Limits, demand

RECORD = struct.Struct("<IIIIiiIIfffI16s")
MOST = 2**31 - 1


@dataclass(frozen=True)
class Level:
    index: int
    view: int
    number: int
    width: int
    height: int
    column: int
    row: int
    tile_width: int
    tile_height: int
    tolerance: float
    largest_error: float
    mean_error: float
    directory: int

    @property
    def place(self):
        return f"level {self.index}"

    @property
    def columns(self):
        return -(-self.width // self.tile_width)

    @property
    def rows(self):
        return -(-self.height // self.tile_height)

    @property
    def tiles(self):
        return self.columns * self.rows

    def tile_columns(self, index):
        """The width of a tile in pixels."""
        column = index % self.columns
        return min(self.tile_width, self.width - column * self.tile_width)

    def tile_pixels(self, index):
        """The number of pixels of a tile."""
        row = index // self.columns
        return self.tile_columns(index) * min(self.tile_height, self.height - row * self.tile_height)


def check_errors(largest, mean, place):
    demand(0 <= mean <= largest <= 1, place, f"its errors {largest} and {mean} do not lie in [0, 1], or in order")


def read_levels(contents, newer, limits):
    demand(contents and len(contents) % RECORD.size == 0, "levels", f"{len(contents)} bytes are no records")
    levels = []
    for index, row in enumerate(RECORD.iter_unpack(contents)):
        level = Level(index, *row[:-1])
        demand(newer or not any(row[-1]), level.place, "reserved bytes are not zero")
        for size in (level.width, level.height, level.tile_width, level.tile_height):
            demand(1 <= size <= MOST, level.place, f"{size} is no size")
        demand(0 <= level.tolerance < 1, level.place, "its tolerance is not in [0, 1)")
        check_errors(level.largest_error, level.mean_error, level.place)
        Limits.hold(level.tiles, limits.tiles, level.place, "tiles")
        _check_order(level, levels)
        levels.append(level)
    Limits.hold(sum(level.tiles for level in levels), limits.tiles, "levels", "tiles")
    return levels


def _check_order(level, before):
    """By views and within them by numbers, both of which count from 0."""
    now = (level.view, level.number)
    if before:
        last = before[-1]
        wanted = {(last.view, last.number + 1), (last.view + 1, 0)}
    else:
        wanted = {(0, 0)}
    demand(now in wanted, level.place, f"view {now[0]}, number {now[1]} does not come next")
