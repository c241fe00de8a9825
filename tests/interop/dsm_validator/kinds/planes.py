"""Pieces of planes with coverage: what both versions of kind `fragments` say of them (section 13)."""

from dataclasses import dataclass

import numpy as np

from ..fault import demand
from ..functions import bits
from . import layering

SIDE = 8


@dataclass(frozen=True)
class Planes:
    counted: np.ndarray
    w: np.ndarray
    right: np.ndarray
    down: np.ndarray
    unknown: np.ndarray
    opacities: np.ndarray
    coverage: np.ndarray

    @staticmethod
    def of(counted, w, gradients, flags, opacities, coverage, channels, place):
        """From columns, those of gradients and of coverage in pairs."""
        low, high = (part.astype(np.uint64) for part in coverage)
        return Planes(
            counted,
            w.view("<f4"),
            gradients[0].view("<f4"),
            gradients[1].view("<f4"),
            bits(flags, len(w), place),
            layering.channels_of(opacities, channels),
            low | high << np.uint64(32),
        )

    def check(self, metadata, place):
        for numbers in (self.w, self.right, self.down):
            demand(np.isfinite(numbers).all(), place, "a number of a plane is not finite")
        demand(layering.never_falls(self.counted, self.w), place, "w falls within a pixel")
        layering.check_opacities(self.opacities, place, nonzero=True)
        demand((self.coverage != 0).all(), place, "a coverage is empty")
        level = (self.right == 0) & (self.down == 0)
        demand((level | ~self.unknown).all(), place, "a plane that is not known has a gradient")
        layering.check_most(self.counted, layering.max_layers(metadata), place, "fragments")


def check_coverage_key(metadata):
    coverage = metadata.fields.integer("coverage", 1, 8)
    demand(coverage in (1, 2, 4, 8), "metadata: coverage", f"{coverage} is none of 1, 2, 4 and 8")


def check_held(entry, planes, borders=()):
    """The depths of the entry hold all that is covered, and the borders."""
    for depth in borders:
        demand(entry.least_depth <= depth <= entry.most_depth, entry.place, "its depths do not hold its borders")
