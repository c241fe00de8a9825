"""Numbers that readers get wrong, and small changes of a number."""

import struct

FLOATS = [
    0x00000000, 0x80000000, 0x3F800000, 0xBF800000, 0x3F7FFFFF, 0x3F800001, 0x7F7FFFFF, 0xFF7FFFFF,
    0x7F800000, 0xFF800000, 0x7FC00000, 0xFFC00000, 0x7F800001, 0x00000001, 0x80000001, 0x007FFFFF,
    0x00800000, 0x34000000, 0x33800000, 0x3D800000,
]
INTEGERS = [0, 1, 2, 3, 4, 8, 31, 32, 33, 63, 64, 65, 255, 256, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1]
LONG = [0, 1, 63, 64, 65, 128, 2**31, 2**32 - 1, 2**32, 2**40, 2**62, 2**63 - 1, 2**63, 2**64 - 64, 2**64 - 1]


def odd_word(chance, now):
    """Another 32-bit word."""
    way = chance.randrange(6)
    if way == 0:
        return chance.choice(INTEGERS)
    if way in (1, 2):
        return chance.choice(FLOATS)
    if way == 3:
        return now ^ 1 << chance.randrange(32)
    return (now + chance.choice((1, -1, 2, -2, 64, -64, 1 << 10, -(1 << 20)))) % 2**32


def odd_long(chance, now):
    """Another 64-bit word."""
    way = chance.randrange(4)
    if way == 0:
        return chance.choice(LONG)
    if way == 1:
        return now ^ 1 << chance.randrange(64)
    return (now + chance.choice((1, -1, 4, -4, 32, -32, 64, -64, 128))) % 2**64


def change_word(chance, data, at):
    struct.pack_into("<I", data, at, odd_word(chance, struct.unpack_from("<I", data, at)[0]))


def change_long(chance, data, at):
    struct.pack_into("<Q", data, at, odd_long(chance, struct.unpack_from("<Q", data, at)[0]))


def flip(chance, data, at):
    data[at] ^= 1 << chance.randrange(8)
