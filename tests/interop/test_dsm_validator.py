"""The validator: it takes golden files and the document's example, and notices each broken rule where it is broken."""

import random
import re
import struct
import unittest
from fractions import Fraction
from pathlib import Path

import numpy as np

from dsm_mutations import maps
from dsm_mutations.broken import broken, entry
from dsm_mutations.model import Model
from dsm_validator import BeyondLimits, verdict
from dsm_validator.checksum import POLYNOMIAL, crc32c
from dsm_validator.coded_numbers import Bits, _weight, unfolded
from dsm_validator.codecs import _depth_codes, _value_codes
from dsm_validator.fault import Fault, Limits
from dsm_validator.json_text import parse
from dsm_validator.numbers import nearest_f32

TESTS = Path(__file__).resolve().parents[1]
DOCUMENT = TESTS.parent / "docs" / "format" / "dsm-1.md"
GOLDEN = dict(maps.golden())


def bits_f32(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def crc_bit_by_bit(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (POLYNOMIAL if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


class Checksums(unittest.TestCase):
    def test_the_document_s_number(self):
        self.assertEqual(crc32c(b"123456789"), 0xE3069283)

    def test_every_length_is_that_of_the_definition(self):
        chance = random.Random(5)
        for length in (*range(70), 127, 128, 129, 640, 1001):
            data = chance.randbytes(length)
            self.assertEqual(crc32c(data), crc_bit_by_bit(data), length)


class Numbers(unittest.TestCase):
    def test_decimals_are_rounded_once(self):
        # Halfway but for a digit that binary64 does not see: rounding twice would go to the even one.
        halfway = Fraction(1) + Fraction(1, 2**24)
        text = f"{float(halfway):.60f}"[:30]
        self.assertEqual(nearest_f32(text), 1.0)
        self.assertEqual(nearest_f32(text + "0" * 20 + "1"), bits_f32(0x3F800001))

    def test_f32s_come_back_from_nine_digits(self):
        chance = random.Random(6)
        for _ in range(300):
            number = bits_f32(chance.randrange(0x7F800000))
            self.assertEqual(nearest_f32(f"{number:.9g}"), number)
            self.assertEqual(nearest_f32(f"-{number:.9g}"), -number)

    def test_what_is_too_large_or_too_small(self):
        self.assertEqual(nearest_f32("3.4028235e38"), bits_f32(0x7F7FFFFF))
        self.assertEqual(nearest_f32("3.40282356779733661637e38"), bits_f32(0x7F7FFFFF))
        for text in ("3.4028235677973366164e38", "1e39", "1e400", "1e999999999999"):
            self.assertEqual(nearest_f32(text), float("inf"), text)
        for text in ("7e-46", "1e-400", "1e-999999999999"):
            self.assertEqual(nearest_f32(text), 0.0, text)
        self.assertEqual(nearest_f32("7.1e-46"), 2.0**-149)


class Json(unittest.TestCase):
    def fault(self, text):
        with self.assertRaises(Fault) as caught:
            parse(text, "metadata", Limits())
        return caught.exception

    def test_what_is_no_json_of_the_document(self):
        for text in (
            b'{"a":1,"a":2}', b'{"b":[{"a":1,"a":1}]}', b'{"a":NaN}', b'{"a":-Infinity}', b'{"a":01}', b'{"a":1.}',
            b"{", b'{"a":"\\ud800"}', b'{"a":"\t"}', b'\xef\xbb\xbf{}', b'{"a":"\xff"}', b"{} {}", b"",
        ):
            self.assertNotIsInstance(self.fault(text), BeyondLimits, text)

    def test_nesting_has_a_limit_that_is_the_reader_s(self):
        parse(b"[" * 127 + b"]" * 127, "metadata", Limits())
        self.assertIsInstance(self.fault(b"[" * 128 + b"]" * 128), BeyondLimits)
        self.assertIsInstance(self.fault(b"[" * 200_000), BeyondLimits)
        parse(b'"' + b"[" * 500 + b'"', "metadata", Limits())

    def test_integers_are_written_as_such(self):
        integers = {b"0": 0, b"-7": -7, b"1" * 300: 10**40}
        for text, value in (integers | dict.fromkeys((b"1.0", b"1e0", b"-0"))).items():
            self.assertEqual(parse(text, "metadata", Limits()).integer(), value)


class Codecs(unittest.TestCase):
    def test_depths_of_the_quantized_codec(self):
        # Pixels of 2, 0, 1 and 2 vertices: first codes 10, 7 and 9, as changes of 10, −3 and 2 with their signs.
        changes = np.array([20, 5, 5, 4, 1], np.uint32)
        self.assertEqual(_depth_codes(changes, np.array([2, 0, 1, 2])).tolist(), [10, 15, 7, 9, 10])

    def test_values_of_the_quantized_codec(self):
        falls = np.array([0, 3, 1, 0, 16], np.uint32)
        self.assertEqual(_value_codes(falls, np.array([3, 0, 2]), 4).tolist(), [16, 13, 12, 16, 0])


class CodedNumbers(unittest.TestCase):
    def test_numbers_of_the_bit_string(self):
        # γ(0) = 1, γ(1) = 0 1 0, γ(5): 6 is 110, two zeros, a one and the digits 10, the lowest first.
        bits = Bits(bytes([0b0100_0101, 0b0000_0001]), 0, "here")
        self.assertEqual([bits.gamma(), bits.gamma(), bits.gamma()], [0, 1, 5])

    def test_weights_stand_on_a_scale(self):
        self.assertEqual([_weight(place) for place in (0, 1, 2, 4, 5, 9, 129)], [0, 4, 5, 7, 8, 16, 4 << 32])

    def test_signs_are_the_lowest_bit(self):
        self.assertEqual([unfolded(number) for number in (0, 1, 2, 3, 2**32 - 1)], [0, -1, 1, -2, -(2**31)])


class Golden(unittest.TestCase):
    def test_golden_files_are_valid(self):
        self.assertGreater(len(GOLDEN), 40)
        for name, data in GOLDEN.items():
            self.assertIsNone(verdict(data), name)

    def test_damaged_files_are_not(self):
        paths = sorted((TESTS / "data" / "dsm-1" / "damaged").iterdir())
        self.assertGreater(len(paths), 50)
        for path in paths:
            self.assertIsNotNone(verdict(path.read_bytes()), path.name)

    def test_the_example_of_the_document_is_valid_and_no_other_byte_would_be(self):
        rows = re.findall(r"^[0-9a-f]{8}((?:  ?[0-9a-f]{2})+)  \|", DOCUMENT.read_text(), re.MULTILINE)
        data = bytes.fromhex("".join(rows))
        self.assertEqual(data, GOLDEN["document"])
        self.assertIsNone(verdict(data))
        for at in range(len(data)):
            changed = bytearray(data)
            changed[at] ^= 0x10
            self.assertIsNotNone(verdict(bytes(changed)), at)


class Rules(unittest.TestCase):
    def test_each_broken_rule_is_named(self):
        for name, said, data in broken(GOLDEN):
            with self.subTest(name=name, said=said):
                self.assertIn(said, str(verdict(data)))

    def test_a_wider_range_of_fragments_is_allowed(self):
        model = Model.read(GOLDEN["fragments_plain_mono"])
        entry(32, 0.0)(model)
        entry(36, 1e30)(model)
        self.assertIsNone(verdict(model.write()))

    def test_errors_of_exact_kinds_are_0_however_small(self):
        model = Model.read(GOLDEN["layers_plain_mono"])
        for tile in model.directories[0]:
            struct.pack_into("<f", tile.entry, 40, 1e-7)
        struct.pack_into("<f", model.levels[0], 36, 1e-7)
        self.assertIn("its errors are not 0", str(verdict(model.write())))


if __name__ == "__main__":
    unittest.main()
