"""Lists of w and of shares of light: what kinds `prefiltered` and `attenuation` have in common (section 13)."""

import numpy as np

from ..blocks import split
from ..fault import demand
from ..functions import check_range, counts
from . import layering


def lengths(entry, channels, contents):
    return [entry.pixels + 1, entry.count, entry.count * channels]


def check_lists(metadata, entry, contents):
    """Checks the columns, and returns how many fragments each texel has."""
    channels = metadata.channels
    starts, w, shares = split(entry, contents, lengths(entry, channels, contents))
    counted = counts(starts, entry.count, entry.place, "fragments")
    w = w.view("<f4")
    demand((np.isfinite(w) & (w > 0)).all(), entry.place, "w is not finite and above 0")
    demand(layering.never_falls(counted, -w), entry.place, "w rises within a texel")
    layering.check_opacities(layering.channels_of(shares, channels), entry.place, nonzero=True)
    check_range(entry, layering.depth_of(w.max()), layering.depth_of(w.min()))
    return counted
