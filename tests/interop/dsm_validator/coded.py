"""Block 2 of codec 1 (section 7): visibility functions as coded numbers."""

import numpy as np

from .coded_numbers import Numbers, unfolded
from .fault import demand
from .functions import Functions, words_of_bits

LARGEST_DEPTH_BITS = 0x7F7FFFFF
WORD = 2**32 - 1


def _ceiled(code, zeros):
    return -(-code >> zeros)


class _Pixel:
    """What is known of a pixel so far."""

    def __init__(self, stations):
        self.stations = stations
        self.zeros = 0
        self.steps = [False] * stations
        self.codes = []
        self.is_mono = True

    def vertices(self):
        return self.stations + sum(self.steps)

    def corners(self):
        """Of each vertex whether it is a corner, or the near or the far side of a step."""
        return [side for step in self.steps for side in (("near", "far") if step else ("corner",))]


class _Tile:
    def __init__(self, entry, numbers, channels):
        self.entry, self.numbers, self.channels = entry, numbers, channels
        self.width = entry.width
        self.pixels = []

    def read(self, value_one, most_depth):
        self._stations()
        held = [pixel for pixel in self.pixels if pixel.stations]
        for pixel in held:
            pixel.zeros = self.numbers.take(5)
            demand(pixel.zeros <= 30, self.entry.place, "codes end with more than 30 zeros")
        for pixel in held:
            self._steps(pixel)
        self._depths(most_depth)
        if self.channels == 3:
            for pixel in held:
                pixel.is_mono = self.numbers.flag(19)
        values = [self._values(pixel, value_one) for pixel in self.pixels]
        self.numbers.finish()
        return values

    def _around(self, index):
        """The pixels to the left and above, which may be none."""
        left = self.pixels[index - 1] if index % self.width else None
        above = self.pixels[index - self.width] if index >= self.width else None
        return left, above

    def _stations(self):
        total = 0
        for index in range(self.entry.pixels):
            left, above = (pixel.stations if pixel else 0 for pixel in self._around(index))
            if left == 0 or above == 0:
                kind = 0 if left == above else 1
            else:
                kind = 2 if left + above <= 6 else 3 if left + above <= 12 else 4
            stations = self.numbers.take(kind)
            total += stations
            demand(total <= self.entry.count, self.entry.place, "it has more stations than vertices")
            self.pixels.append(_Pixel(stations))

    def _steps(self, pixel):
        if not self.numbers.flag(6):
            return
        before = 7
        for at in range(pixel.stations):
            is_last = at + 1 == pixel.stations
            pixel.steps[at] = self.numbers.flag(before + is_last)
            before = 11 if pixel.steps[at] else 9
        demand(any(pixel.steps), self.entry.place, "a pixel has steps, and has none")

    def _depths(self, most):
        last = 0
        for index, pixel in enumerate(self.pixels):
            if not pixel.stations:
                continue
            firsts = [other.codes[0] for other in self._around(index) if other and other.codes]
            expected = sum(firsts) // len(firsts) if firsts else last
            for at, is_step in enumerate(pixel.steps):
                zeros = 0 if is_step else pixel.zeros
                if at == 0:
                    change = unfolded(self.numbers.take(13 + is_step))
                    high = (expected >> zeros) + change & WORD
                else:
                    kind = 15 + pixel.steps[at - 1] + 2 * is_step
                    high = self.numbers.take(kind) + _ceiled(pixel.codes[-1], zeros)
                code = high << zeros
                demand(code <= most, self.entry.place, "a depth's code is above the largest's")
                pixel.codes.append(code)
            last = pixel.codes[0]

    def _values(self, pixel, one):
        """The codes of each channel's values."""
        sides = pixel.corners()
        channels, first = [], []
        for channel in range(1 if pixel.is_mono else self.channels):
            codes = [one] if sides else []
            told = []
            for at in range(1, len(sides)):
                is_last = at + 1 == len(sides)
                if channel == 0:
                    number = self.numbers.take(self._kind(codes[-1], sides[at], is_last))
                else:
                    number = first[at - 1] + unfolded(self.numbers.take(24 + 2 * channel + is_last)) & WORD
                told.append(number)
                codes.append(number if is_last else codes[-1] - number)
                demand(0 <= codes[-1] <= one, self.entry.place, "a value's code is below 0, or above 1")
            first = first or told
            channels.append(codes)
        return channels

    @staticmethod
    def _kind(before, side, is_last):
        if is_last:
            return 23 if before < 4 else 24 if before < 16 else 25
        return {"corner": 20, "near": 21, "far": 22}[side]


def functions(entry, payload, channels):
    """The functions of a tile; its payload is all that there is."""
    place = entry.place
    demand(entry.differences == 0, place, "a coded tile has no differences")
    demand(len(payload) >= 2, place, "its payload is too short")
    dropped, grid = payload[0], payload[1]
    demand(dropped <= 23 and grid <= 24, place, f"its header has a = {dropped}, b = {grid}")
    tile = _Tile(entry, Numbers(payload, place), channels)
    values = tile.read(1 << grid, LARGEST_DEPTH_BITS >> dropped)
    counted = np.array([pixel.vertices() for pixel in tile.pixels])
    demand(counted.sum() == entry.count, place, "it has another number of vertices than it states")
    stored = sum(len(codes) for pixel in values for codes in pixel)
    words = 1 + entry.pixels + 1 + entry.count + stored
    if channels == 3:
        words += entry.pixels + 1 + words_of_bits(entry.pixels)
    demand(entry.raw_length == 4 * words, place, "the length that it states is not that of its columns")
    depths = [code for pixel in tile.pixels for at, code in enumerate(pixel.codes) for _ in range(1 + pixel.steps[at])]
    depths = (np.array(depths, np.uint32) << np.uint32(dropped)).astype(np.uint32).view(np.float32)

    def channel(number):
        codes = [code for pixel in values for code in pixel[number if len(pixel) > 1 else 0]]
        return np.array(codes, np.float64) / (1 << grid)

    return Functions(counted, depths, [channel(number) for number in range(channels)])
