"""Golden files in which one rule is broken, each with what the validator says: rules that chance breaks seldom."""

import struct

import numpy as np

from .model import Model, Tile


def word(index, value):
    """A change of one word of the first tile; a float is stored as f32."""

    def change(model):
        bits = struct.unpack("<I", struct.pack("<f", value))[0] if isinstance(value, float) else value
        model.tiles()[0].words[index] = bits

    return change


def column(number, offset, value):
    """A change of a word of a column of the first tile."""

    def change(model):
        before = sum(length or 0 for length in model.tiles()[0].lengths[:number])
        word(before + offset, value)(model)

    return change


def spare_bit(number):
    """Sets the highest bit of the last word of flags, column `number`, of the last tile."""

    def change(model):
        tile = model.tiles()[-1]
        before = sum(length or 0 for length in tile.lengths[: number + 1])
        tile.words[before - 1] |= 1 << 31

    return change


def metadata(old, new):
    def change(model):
        assert old.encode() in model.metadata
        model.metadata = model.metadata.replace(old.encode(), new.encode(), 1)

    return change


def entry(at, value):
    def change(model):
        struct.pack_into("<f" if isinstance(value, float) else "<I", model.tiles()[0].entry, at, value)

    return change


def columns(change_columns):
    """A change of the first tile's columns, which are given as views of its words; None where there is none."""

    def change(model):
        tile = model.tiles()[0]
        parts, at = [], 0
        for length in tile.lengths:
            parts.append(None if length is None else tile.words[at : at + length])
            at += length or 0
        change_columns(parts)

    return change


def record(at, value, level=-1):
    """A change of the record of the last level, or of another."""

    def change(model):
        struct.pack_into("<f" if isinstance(value, float) else "<i", model.levels[level], at, value)

    return change


def another_level(view, number):
    """The last level once more, as that one."""

    def change(model):
        copy = model.copy()
        model.levels.append(copy.levels[-1])
        model.directories.append(copy.directories[-1])
        struct.pack_into("<II", model.levels[-1], 0, view, number)

    return change


def wide(side):
    """One row of so many pixels, and nothing in it."""

    def change(model):
        metadata('"width":12,"height":9', f'"width":{side},"height":1')(model)
        struct.pack_into("<IIIIII", model.levels[0], 8, side, 1, 0, 0, side, 1)
        model.directories[0] = [Tile(bytearray(64), None)]

    return change


def _item_of(starts, least):
    """The first item of a table of starts that has at least so many."""
    return int(np.argmax(np.diff(starts.astype(np.int64)) >= least))


def _run_without_zero(parts):
    """The last layer of a run that another follows is as the one before it."""
    run = int(parts[1][_item_of(parts[1], 2)])
    last = int(parts[2][run + 1]) - 1
    parts[6][last] = parts[6][last - 1]


def _run_too_near(parts):
    run = int(parts[1][_item_of(parts[1], 2)])
    parts[5][parts[2][run + 1]] = 0


def _run_without_layers(parts):
    parts[2][1] = 0


def _unknown_with_gradient(parts):
    index = int(np.argmax((parts[2] | parts[3]) & 0x7FFFFFFF != 0))
    parts[4][index // 32] |= 1 << index % 32


def _covering_nothing(parts):
    parts[6][0] = parts[7][0] = 0


def _second_is(column_number, starts, value):
    """Of the first item with two elements the second becomes a number."""

    def change(parts):
        first = int(parts[starts][_item_of(parts[starts], 2)])
        parts[column_number].view("<f4")[first + 1] = value

    return columns(change)


def _border(value, column_number, last=False):
    def change(parts):
        half = len(parts[0]) // 2
        borders = parts[0][half:]
        pixel = _item_of(borders, 2)
        at = int(borders[pixel + 1]) - 1 if last else int(borders[pixel])
        parts[column_number].view("<f4")[at] = value

    return columns(change)


def _one_border(parts):
    borders = parts[0][len(parts[0]) // 2 :]
    borders[_item_of(borders, 2) + 1] -= np.diff(borders)[_item_of(borders, 2)] - 1


def _seen_nothing(parts):
    parts[0][np.argmax(parts[0] != 0)] = 0


# The golden file, what is changed, and what is said then.
WINDOW = '"display_window":'
BROKEN = [
    ("deep_exact_plain_mono", column(0, 0, 1), "does not begin with 0"),
    ("deep_exact_plain_mono", column(0, 1, 60000), "falls"),
    ("deep_exact_plain_mono", column(3, 0, float("nan")), "a depth is not finite"),
    ("deep_exact_plain_mono", column(4, 0, 0.5), "a first value is not 1"),
    ("deep_exact_plain_mono", column(4, 1, 1.5), "values rise"),
    ("deep_exact_plain_mono", entry(32, 0.0), "its depths are"),
    ("deep_exact_plain_rgb", spare_bit(2), "bits behind the last flag"),
    ("deep_exact_plain_rgb", column(1, 1, 1), "neither v nor 3 v values"),
    ("deep_exact_plain_mono", metadata('"tolerance":0.0', '"tolerance":0.5'), "not that of the metadata"),
    ("deep_exact_plain_mono", metadata('"width":12', '"width":12.0'), "is not an integer"),
    ("deep_exact_plain_mono", metadata('"camera":null', '"light":{"shape":"point","size":[1,0]}'), "out of range"),
    ("deep_exact_plain_mono", metadata(WINDOW + "null", WINDOW + '{"min":[1,0],"max":[0,0]}'), "above max"),
    ("deep_exact_plain_mono", metadata('s":{}', 's":{"a":{"type":"float","value":1e39}}'), "not finite"),
    ("deep_crop_mono", metadata('"width":12', '"width":7'), "does not lie in the whole map"),
    ("layers_plain_mono", metadata('"resets":0', '"resets":1'), "no resets"),
    ("layers_plain_mono", metadata('"max_layers":5', '"max_layers":1'), "more than 1 layers"),
    ("layers_plain_mono", metadata('"so', '"left_out":{"pixels":1,"max":1.5,"mean":0},"so'), "out of range"),
    ("layers_plain_mono", metadata('"software"', '"coverage":8,"software"'), "no key coverage"),
    ("layers_plain_mono", column(2, 0, 1.5), "an opacity does not lie in"),
    ("layers_plain_mono", entry(48, 0.5), "have no error"),
    ("layers_plain_mono", entry(40, 1e-7), "its largest error is not"),
    ("mtsm_plain_mono", word(0, 0), "runs of"),
    ("mtsm_plain_mono", metadata('"resets":2', '"resets":0'), "more than 1 runs"),
    ("mtsm_plain_mono", column(7, 0, 1), "first layer of a run counts"),
    ("fragments_plain_mono", column(1, 0, float("inf")), "not finite"),
    ("fragments_plain_mono", spare_bit(4), "bits behind the last flag"),
    ("fragments_plain_mono", column(5, 0, 0.0), "0 in every channel"),
    ("fragments_plain_mono", entry(32, 8.0), "do not hold"),
    ("fragments_plain_mono", entry(36, 3.0), "do not hold"),
    ("fragments_plain_mono", metadata('"coverage":8', '"coverage":3'), "none of 1, 2, 4 and 8"),
    ("fragments_plain_mono", metadata('"software"', '"media":{"max_slabs":1},"software"'), "no key media"),
    ("fragments-with-media_plain_mono", metadata('"max_slabs":4', '"max_slabs":1'), "more than 2 borders"),
    ("fragments-with-media_plain_mono", column(7, 0, 0.5), "a first border has a thickness"),
    ("fragments-with-media_plain_mono", column(6, 1, 0.0), "borders do not rise"),
    ("prefiltered_plain_mono", column(1, 0, -1.0), "w is not finite and above 0"),
    ("prefiltered_plain_mono", metadata('"max_layers":5', '"max_layers":1'), "more than 1 layers"),
    ("prefiltered_levels", metadata('"stack_from":1', '"stack_from":0'), "its record is"),
    ("prefiltered_levels", metadata('"stack_from":1', '"stack_from":9'), "no such level"),
    ("attenuation_plain_mono", metadata('"light_samples":8', '"light_samples":0'), "does not lie in"),
    ("attenuation_plain_mono", column(2, 0, 0.0), "0 in every channel"),
    ("views_plain_mono", metadata('[0.5,0.25,0.125]', '[1,2,3],[0.5,0.25,0.125]'), "for 3 eyes"),
    ("views_plain_mono", column(0, 0, -1.0), "w is not finite and ≥ 0"),
    ("deep_exact_plain_mono", record(16, 4, 0), "does not lie in the whole map"),
    ("deep_levels_mono", record(8, 8, 0), "a crop has one level"),
    ("deep_crop_mono", record(16, 1, 0), "does not begin on a tile's border"),
    ("layers_plain_mono", metadata('"tolerance":0.0', '"tolerance":0.5'), "has a tolerance of 0"),
    ("layers_levels", record(32, 0.25), "its tolerance is not 0"),
    ("layers_plain_mono", metadata('"width":12', '"width":13'), "does not end on a tile's border"),
    ("layers_plain_mono", _second_is(1, 0, 0.0), "depths fall"),
    ("mtsm_plain_mono", columns(_run_without_zero), "does not end with 0"),
    ("mtsm_plain_mono", columns(_run_too_near), "begins before the end"),
    ("mtsm_plain_mono", columns(_run_without_layers), "a run has no layer"),
    ("mtsm_plain_mono", metadata('"so', '"coverage":8,"so'), "no key coverage"),
    ("fragments_plain_mono", _second_is(1, 0, -1.0), "w falls"),
    ("fragments_plain_mono", columns(_covering_nothing), "a coverage is empty"),
    ("fragments_plain_mono", columns(_unknown_with_gradient), "not known has a gradient"),
    ("fragments-with-media_plain_mono", _border(float("inf"), 6, last=True), "depth is not finite"),
    ("fragments-with-media_plain_mono", _border(float("nan"), 7, last=True), "thickness is not finite"),
    ("fragments-with-media_plain_mono", _border(0.0, 7, last=True), "a last border has no thickness"),
    ("fragments-with-media_plain_mono", columns(_one_border), "a pixel has one border"),
    ("fragments-with-media_plain_mono", entry(24, 1), "its length is not that of its columns"),
    ("prefiltered_plain_mono", _second_is(1, 0, 1e6), "w rises"),
    ("prefiltered_levels", metadata('"subsampled":0', '"subsampled":9'), "no such level"),
    ("prefiltered_levels", metadata('"widths":2.0', '"widths":2.0,"more":1'), "nothing else"),
    ("prefiltered_levels", metadata('"widths":2.0', '"widths":-2.0'), "out of range"),
    ("prefiltered_plain_mono", wide(2**24 + 1), "more than 16777216 texels"),
    ("prefiltered_levels", record(8, 5), "its record is"),
    ("prefiltered_levels", metadata('"add"', '"min"'), "is none of add"),
    ("prefiltered_levels", metadata('"joined":false', '"joined":0'), "is not true or false"),
    ("layers_plain_mono", metadata('"light_depth":0.75', '"light_depth":"0.75"'), "is not a number"),
    ("layers_plain_mono", metadata('"light_depth":0.75', '"light_depth":1e39'), "is not finite"),
    ("layers_plain_mono", metadata('"kind":"layers"', '"kind":"com.example.slabs"'), "is not known"),
    ("layers_plain_mono", metadata('"kind":"layers"', '"kind":"layers","kind_version":2'), "is not known"),
    ("prefiltered_plain_mono", another_level(1, 0), "there is one view"),
    ("attenuation_plain_mono", another_level(0, 1), "there is more than one"),
    ("views_plain_mono", metadata('"channels":1', '"channels":3'), "views have one channel"),
    ("views_plain_mono", metadata('"eyes":[', '"eyes":[],"more":['), "there are 0"),
    ("views_plain_mono", record(12, 8), "its pixels are not those of the first view"),
    ("views_plain_mono", columns(_seen_nothing), "pixels are not 0, not"),
]


def broken(golden):
    """(the golden file's name, what is said, bytes) of all of them."""
    for name, change, said in BROKEN:
        model = Model.read(golden[name])
        change(model)
        yield name, said, model.write()
