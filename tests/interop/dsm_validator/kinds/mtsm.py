"""Kind `mtsm`: runs of visibility functions with counts (section 13)."""

import numpy as np

from ..blocks import split
from ..fault import demand
from ..functions import (
    Functions, bits, check_functions, check_range, counts, owners, values_of, words_of_bits,
)
from . import layering
from .deep import Deep


class Mtsm:
    codecs = (0,)

    @staticmethod
    def check_metadata(metadata):
        layering.check_layering(metadata)
        layering.check_share(metadata, "left_out")
        demand(metadata.fields.nullable("coverage") is None, "metadata", "maps of this kind have no key coverage")

    @staticmethod
    def check_levels(metadata, levels):
        layering.check_crop(metadata, levels)
        Deep.check_levels(metadata, levels)

    @staticmethod
    def lengths(entry, channels, contents):
        # The first word is r, in planes too.
        runs, m = int.from_bytes(contents[:4], "little"), entry.count
        demand(1 <= runs <= m, entry.place, f"{runs} runs of {m} layers")
        return _lengths(entry, channels, runs, len(contents) // 4)

    @staticmethod
    def check_tile(metadata, entry, contents):
        place, m = entry.place, entry.count
        columns = split(entry, contents, Mtsm.lengths(entry, metadata.channels, contents), spare=(3, 4))
        runs = int(columns[0][0])
        _, run_starts, starts, value_starts, mono, depths, values, samples = columns
        runs_of_pixel = counts(run_starts, runs, place, "runs")
        layers_of_run = counts(starts, m, place, "layers")
        demand((layers_of_run >= 1).all(), place, "a run has no layer")
        if metadata.channels == 1:
            places = [np.arange(m)]
        else:
            value_counts = counts(value_starts, len(values), place, "values")
            places = values_of(layers_of_run, value_counts, bits(mono, runs, place), place)
        values = values.view("<f4")
        functions = Functions(layers_of_run, depths.view("<f4"), [values[part] for part in places])
        check_functions(functions, place)
        demand((samples[starts[:-1]] == 0).all(), place, "the first layer of a run counts samples")
        _check_runs(metadata, functions, runs_of_pixel, starts, place)
        check_range(entry, functions.depths.min(), functions.depths.max())


def _lengths(entry, channels, runs, words):
    n, m = entry.pixels, entry.count
    if channels == 1:
        return [1, n + 1, runs + 1, None, None, m, m, m]
    rest = words - 1 - (n + 1) - 2 * (runs + 1) - words_of_bits(runs) - 2 * m
    demand(0 <= rest < 2**32, entry.place, "its length has no room for its values")
    return [1, n + 1, runs + 1, runs + 1, words_of_bits(runs), m, rest, m]


def _check_runs(metadata, functions, runs_of_pixel, starts, place):
    fields = metadata.fields.object("layering")
    layering.check_most(runs_of_pixel, fields.integer("resets", 0, 2**32 - 1) + 1, place, "runs")
    pixel, _ = owners(runs_of_pixel)
    followed = pixel[1:] == pixel[:-1]
    last = starts[1:].astype(np.int64) - 1
    for values in functions.values:
        demand((~followed | (values[last[:-1]] == 0)).all(), place, "a run that another follows does not end with 0")
    begins, ends = functions.depths[starts[1:-1]], functions.depths[last[:-1]]
    demand((~followed | (begins >= ends)).all(), place, "a run begins before the end of the one before it")
    run, local = owners(functions.counted)
    changed = np.zeros(len(local), bool)
    for values in functions.values:
        changed[1:] |= values[1:] != values[:-1]
    changed &= local > 0
    changes = np.bincount(pixel[run[changed]], minlength=len(runs_of_pixel))
    layering.check_most(changes, layering.max_layers(metadata), place)
