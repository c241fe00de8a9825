"""Kind `views`: depth images from several points of the light (section 13)."""

import numpy as np

from ..blocks import split
from ..fault import demand
from ..fields import array, real_f64
from ..functions import check_range
from . import layering

MOST_EYES = 1024


class Views:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_exact(metadata)
        demand(metadata.channels == 1, "metadata: channels", "views have one channel")
        fields = metadata.fields
        eyes = fields.array("eyes")
        demand(1 <= len(eyes) <= MOST_EYES, fields.place("eyes"), f"there are {len(eyes)}")
        for eye in eyes:
            for number in array(eye, fields.place("eyes"), 3):
                real_f64(number, fields.place("eyes"))
        fields.real("gap", least=0)

    @staticmethod
    def check_levels(metadata, levels):
        eyes = metadata.fields.array("eyes")
        demand(len(levels) == len(eyes), "levels", f"there are {len(levels)} for {len(eyes)} eyes")
        for level in levels:
            demand((level.view, level.number) == (level.index, 0), level.place, "a view has one level")
            first = levels[0]
            pixels = [(at.column, at.row, at.width, at.height) for at in (level, first)]
            demand(pixels[0] == pixels[1], level.place, "its pixels are not those of the first view")
        layering.check_crop(metadata, levels)

    check_errors = staticmethod(layering.check_no_errors)

    @staticmethod
    def lengths(entry, channels, contents):
        return [entry.pixels]

    @staticmethod
    def check_tile(metadata, entry, contents):
        (w,) = split(entry, contents, Views.lengths(entry, 1, contents))
        w = w.view("<f4")
        demand((np.isfinite(w) & (w >= 0)).all(), entry.place, "w is not finite and ≥ 0")
        seen = w[w > 0]
        demand(len(seen) == entry.count, entry.place, f"{len(seen)} pixels are not 0, not {entry.count}")
        check_range(entry, layering.depth_of(seen.max()), layering.depth_of(seen.min()))
