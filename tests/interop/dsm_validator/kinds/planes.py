"""Pieces of planes with coverage: what both versions of kind `fragments` say of them (section 13)."""

from dataclasses import dataclass

import numpy as np

from ..fault import demand
from ..functions import bits
from ..numbers import MAX_F32
from . import layering

SIDE = 8
# What rounding may take from the depths that an entry states.
SLACK = 1e-6


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
    """The depths of the entry hold all that is covered, and the borders; they may be wider."""
    depths = np.asarray(borders, np.float64)
    if len(planes.w):
        depths = np.concatenate((depths, *_covered_depths(planes)))
    held = entry.least_depth <= depths.min() * (1 + SLACK) and entry.most_depth >= depths.max() * (1 - SLACK)
    demand(held, entry.place, f"its depths do not hold all from {depths.min()} to {depths.max()}")


def _covered_depths(planes):
    """The nearest and the farthest depth of each fragment, over the corners of all squares that are covered."""
    squares = planes.coverage[:, None] >> np.arange(SIDE * SIDE, dtype=np.uint64) & np.uint64(1)
    row, column = np.divmod(np.arange(SIDE * SIDE), SIDE)
    w, right, down = (part.astype(np.float64)[:, None] for part in (planes.w, planes.right, planes.down))
    middle = w + right * ((column + 0.5) / SIDE - 0.5) + down * ((row + 0.5) / SIDE - 0.5)
    reach = (np.abs(right) + np.abs(down)) / (2 * SIDE)
    nearest = np.where(squares, middle + reach, -np.inf).max(axis=1)
    farthest = np.where(squares, middle - reach, np.inf).min(axis=1)
    with np.errstate(divide="ignore"):
        # A plane that does not come back before the light's own depth has no end.
        depths = [np.where(w > 0, 1 / w, np.inf) for w in (nearest, farthest)]
    return [np.minimum(part, MAX_F32) for part in depths]
