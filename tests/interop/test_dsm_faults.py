"""The validator names the broken rule of each damaged file, of frames, attributes, codecs and places in the file."""

import struct
import unittest
from pathlib import Path

import numpy as np
import zstandard

from dsm_mutations import maps
from dsm_mutations.model import Model, _packed
from dsm_mutations.sign import resign
from dsm_validator import BeyondLimits, verdict

DAMAGED = Path(__file__).resolve().parents[1] / "data" / "dsm-1" / "damaged"
GOLDEN = dict(maps.golden())

# By the name of a damaged file, which says what was done to it.
SAID = {
    "depth_falls": "depths fall",
    "depth_negative": "a depth is not finite and ≥ 0",
    "empty": "does not begin with the magic",
    "empty_tile_with_vertices": "its offset is 0, and it is not empty",
    "four_billion_sections": "4294967295 sections are more than",
    "known_section_not_required": "has the flag required",
    "level_directory": "its directory is no such section",
    "level_error": "do not lie in [0, 1], or in order",
    "level_error_not_of_tiles": "its largest error is not",
    "level_number": "does not come next",
    "level_of_four_billion_tiles": "tiles are more than",
    "level_reserved": "level 0: reserved bytes",
    "level_tolerance": "its tolerance is not in [0, 1)",
    "level_without_pixels": "0 is no size",
    "metadata_of_another_size": "does not end on a tile's border",
    "metadata_without_width": "no key width",
    "mono_flag": "mono flags",
    "newer_major_version": "the major version is 2",
    "optional_flag": "prologue: reserved bits",
    "padding": "its padding is not zero",
    "pixel_table_end": "ends with 3, not 4",
    "plain_differences": "a plain tile has no differences",
    "prologue_checksum": "prologue: its checksum",
    "prologue_only": "the file has 64 bytes",
    "raw_length_not_of_words": "45 bytes are no words",
    "raw_length_of_an_exbibyte": "unpacked are more than",
    "raw_length_too_long": "is as long unpacked",
    "required_flag": "a required bit that is not known",
    "reserved_section": "reserved bits are not zero",
    "section_outside": "do not lie in a file of",
    "table_unaligned": "is no multiple of 64",
    "three_vertices_at_one_depth": "three vertices stand at one depth",
    "tile_depth_error": "are no depths",
    "tile_error_above_tolerance": "its error is above the tolerance",
    "tile_on_the_prologue": "it is not empty, and it has no vertices",
    "tile_outside": "belong to no extent",
    "tile_reserved": "reserved bytes are not zero",
    "trailing_byte": "the file has 705 bytes",
    "two_channels": "there are 1 or 3",
    "two_level_sections": "not one section b'LEVL'",
    "unclaimed_bytes": "from 704 to 768 belong to no extent",
    "unknown_block": "block 200 is not known",
    "unknown_codec": "codec 200 is not known",
    "unknown_required_section": "required and of a kind that is not known",
    "value_first": "a first value is not 1",
    "value_rises": "values rise",
    "vertex_count": "its length is not that of its columns",
}

# An attribute, and whether it is one.
ATTRIBUTES = [
    ('{"type":"int","value":1}', None),
    ('{"type":"int","value":1.0}', "is not an integer"),
    ('{"type":"int","value":2147483648}', "does not lie in"),
    ('{"type":"string","value":1}', "it is not a string"),
    ('{"type":"opaque","value":1}', "has no value"),
    ('{"type":"opaque","hex":"aAFf09"}', None),
    ('{"type":"opaque","hex":"0"}', "is not pairs"),
    ('{"type":"opaque","hex":"0g"}', "is not pairs"),
    ('{"type":"int"}', "has not either value or hex"),
    ('{"type":"int","value":1,"hex":"01000000"}', "has not either value or hex"),
    ('{"type":"v2i","value":[1,2,3]}', "it has 3 items, not 2"),
    ('{"type":"v2i","value":1}', "it is not an array"),
    ('{"type":"double","value":1e309}', "is beyond every f64"),
    ('{"type":"double","value":"1"}', "is not a number"),
    ('{"type":1,"hex":""}', "it is not a string"),
    ("[]", "it is not an object"),
]


def named(frame):
    return frame[:4] + bytes([frame[4] | 1, 7]) + frame[5:]


def wide(frame):
    """The frame with a window of 256 MiB instead of its single segment."""
    assert frame[4] == 0x20
    return frame[:4] + bytes([0, 18 << 3]) + frame[6:]


# A frame made of good contents, and what is said of it.
FRAMES = [
    (lambda raw: zstandard.ZstdCompressor(write_checksum=True).compress(raw), None),
    (lambda raw: zstandard.ZstdCompressor().compress(raw) + b"\0", "1 bytes follow its frame"),
    (lambda raw: zstandard.ZstdCompressor().compress(raw)[:-1], "does not end"),
    (lambda raw: zstandard.ZstdCompressor().compress(raw + bytes(1 << 16)), "unpacks to more than"),
    (lambda raw: zstandard.ZstdCompressor().compress(raw[:-4]), "bytes, not"),
    (lambda raw: named(zstandard.ZstdCompressor().compress(raw)), "needs a dictionary"),
    (lambda raw: wide(zstandard.ZstdCompressor().compress(raw[:200])), "window are more than"),
    (lambda raw: b"\x50\x2a\x4d\x18\0\0\0\0" + zstandard.ZstdCompressor().compress(raw), "not a zstd frame"),
    (lambda raw: zstandard.ZstdCompressor(write_checksum=True).compress(raw)[:-4] + bytes(4), "does not unpack"),
]


class Damaged(unittest.TestCase):
    def test_each_damaged_file_is_refused_for_what_was_done_to_it(self):
        for name, said in SAID.items():
            with self.subTest(name=name):
                self.assertIn(said, str(verdict((DAMAGED / f"{name}.dsm").read_bytes())))


class Attributes(unittest.TestCase):
    def test_attributes(self):
        for text, said in ATTRIBUTES:
            with self.subTest(text=text):
                model = Model.read(GOLDEN["document"])
                model.metadata = model.metadata.replace(b'"attributes":{}', f'"attributes":{{"a":{text}}}'.encode())
                fault = verdict(model.write())
                self.assertIn(said, str(fault)) if said else self.assertIsNone(fault)


class Frames(unittest.TestCase):
    def test_frames(self):
        for number, (make, said) in enumerate(FRAMES):
            with self.subTest(number=number):
                model = Model.read(GOLDEN["deep_exact_zstd_rgb"])
                tile = model.tiles()[0]
                raw = zstandard.ZstdDecompressor().decompress(_packed(tile))
                tile.payload = make(raw)
                fault = verdict(model.write())
                self.assertIn(said, str(fault)) if said else self.assertIsNone(fault)

    def test_differences_of_columns(self):
        model = Model.read(GOLDEN["deep_exact_zstd_mono"])
        model.tiles()[0].entry[58] = 0b00110
        self.assertIsNone(verdict(model.write()), "those of missing columns say nothing")
        model.tiles()[0].entry[58] = 1 << 5
        self.assertIn("a column that is not there", str(verdict(model.write())))


class Codecs(unittest.TestCase):
    """Two vertices of one pixel as the quantized codec stores them, and what breaks."""

    def fault(self, header, depths, falls):
        model = Model.read(GOLDEN["document"])
        tile = model.tiles()[0]
        # The tile has two pixels; the second has no vertices.
        tile.words = np.array([header, 0, 2, 2, *depths, *falls], np.uint32)
        tile.entry[56] = 1
        struct.pack_into("<Q", tile.entry, 24, 2)
        # A step at 2.
        struct.pack_into("<ff", tile.entry, 32, 2.0, 2.0)
        return verdict(model.write())

    def test_codes(self):
        two = 0x40000000 >> 20
        self.assertIsNone(self.fault(20 | 4 << 8, (two << 1, 0), (0, 8)))
        self.assertIn("its header has a = 24", str(self.fault(24 | 4 << 8, (two << 1, 0), (0, 8))))
        self.assertIn("its header has a = 20, b = 25", str(self.fault(20 | 25 << 8, (two << 1, 0), (0, 8))))
        self.assertIn("is above the largest", str(self.fault(20 | 4 << 8, (two << 1, 2000), (0, 8))))
        self.assertIn("is below 0", str(self.fault(20 | 4 << 8, (two << 1, 0), (0, 17))))


class Places(unittest.TestCase):
    def at(self, offset):
        """An empty section that says it stands there."""
        model = Model.read(GOLDEN["document"])
        model.extra.append((b"note", 0, b""))
        data = bytearray(model.write())
        table, count = struct.unpack_from("<QI", data, 24)
        struct.pack_into("<Q", data, table + 32 * (count - 1) + 8, offset)
        return verdict(resign(data))

    def test_empty_extents_stand_where_another_begins(self):
        end = len(GOLDEN["document"])
        self.assertIsNone(self.at(64))
        self.assertIsNone(self.at(end))
        # Within the metadata.
        self.assertIn("no other extent begins there", str(self.at(192)))
        self.assertIn("no multiple of 64", str(self.at(65)))

    def test_extents_neither_overlap_nor_leave_room(self):
        for length, said in ((65, "overlaps"), (1, None), (0, "belong to no extent")):
            model = Model.read(GOLDEN["document"])
            model.extra += [(b"note", 0, b"1"), (b"note", 0, b"2")]
            data = bytearray(model.write())
            table, count = struct.unpack_from("<QI", data, 24)
            # What the first of the two says of its length; beneath a padding of zeros that of the second is read.
            row = table + 32 * (count - 2)
            place = struct.unpack_from("<Q", data, row + 8)[0]
            data[place] = data[place + 64] = 0
            struct.pack_into("<Q", data, row + 16, length)
            fault = verdict(resign(data))
            self.assertIn(said, str(fault)) if said else self.assertIsNone(fault)
            self.assertNotIsInstance(fault, BeyondLimits)

    def test_depths_of_an_entry_are_in_order(self):
        model = Model.read(GOLDEN["document"])
        struct.pack_into("<ff", model.tiles()[0].entry, 32, 5.0, 2.0)
        self.assertIn("its depths are not in order", str(verdict(model.write())))


if __name__ == "__main__":
    unittest.main()
