"""Changes of fields of fixed places: prologue, section table, level records, directory entries."""

import struct

from dsm_validator.container import SECTION

from .odd import change_long, change_word, flip
from .sign import resign

# Where the fields of 64 bits are; all others are changed as words, wherever they begin.
LONG_OF_PROLOGUE = (16, 24)
LONG_OF_SECTION = (8, 16)
LONG_OF_ENTRY = (0, 8, 16, 24)


def _change(chance, data, size, longs):
    """A change in a record; returns its place."""
    if chance.random() < 0.3:
        at = chance.choice(longs) if longs else 4 * chance.randrange(size // 4)
        (change_long if longs else change_word)(chance, data, at)
    elif chance.random() < 0.3:
        at = chance.randrange(size)
        flip(chance, data, at)
    else:
        at = 4 * chance.randrange(size // 4)
        change_word(chance, data, at)
    return at


def prologue(chance, model):
    data = bytearray(model.write())
    # Magic, version, flags and lengths, but not the checksum.
    head = data[:60]
    at = _change(chance, head, 60, LONG_OF_PROLOGUE)
    data[:60] = head
    return resign(data), f"prologue at {at}"


def section_table(chance, model):
    data = bytearray(model.write())
    offset, count = struct.unpack_from("<QI", data, 24)
    row = offset + SECTION.size * chance.randrange(count)
    entry = data[row : row + SECTION.size]
    at = _change(chance, entry, SECTION.size, LONG_OF_SECTION)
    data[row : row + SECTION.size] = entry
    return resign(data), f"section table, row at {row}, field at {at}"


def level_record(chance, model):
    level = chance.randrange(len(model.levels))
    at = _change(chance, model.levels[level], 64, None)
    # `write` states the directory; its field is changed behind it.
    wanted = bytes(model.levels[level])
    data = bytearray(model.write())
    if at in range(44, 48):
        begin = data.find(bytes(model.levels[level]))
        data[begin : begin + 64] = wanted
        return resign(data), f"record of level {level} at {at}"
    return bytes(data), f"record of level {level} at {at}"


def directory_entry(chance, model):
    number = chance.randrange(len(model.directories))
    index = chance.randrange(len(model.directories[number]))
    data = bytearray(model.write())
    begin = _directory(data, number) + 64 * index
    entry = data[begin : begin + 64]
    at = _change(chance, entry, 64, LONG_OF_ENTRY)
    data[begin : begin + 64] = entry
    return resign(data), f"entry {index} of directory {number} at {at}"


def errors(chance, model):
    """Errors of a tile and its level changed alike: what they say of each other stays."""
    number = chance.randrange(len(model.levels))
    part = bytearray(4)
    change_word(chance, part, 0)
    where = chance.choice((0, 4))
    for tile in model.directories[number]:
        tile.entry[40 + where : 44 + where] = part
    model.levels[number][36 + where : 40 + where] = part
    if chance.random() < 0.5:
        model.levels[number][36:44] = part * 2
        for tile in model.directories[number]:
            tile.entry[40:48] = part * 2
    return model.write(), f"errors of level {number}: {part.hex()}"


def swapped(chance, model):
    """Two rows of the section table, or two entries of a directory, change their places, whole or the offsets alone."""
    data = bytearray(model.write())
    offset, count = struct.unpack_from("<QI", data, 24)
    if chance.random() < 0.5:
        begin, size, rows, fields = offset, SECTION.size, count, ((0, 32), (8, 16), (8, 24), (0, 4))
    else:
        number = chance.randrange(len(model.directories))
        begin, size, rows = _directory(data, number), 64, len(model.directories[number])
        fields = ((0, 64), (0, 8), (0, 16), (0, 24), (24, 48))
    one, other = (begin + size * chance.randrange(rows) for _ in range(2))
    low, high = chance.choice(fields)
    data[one + low : one + high], data[other + low : other + high] = (
        data[other + low : other + high],
        data[one + low : one + high],
    )
    return resign(data), f"bytes {low} to {high} of the rows at {one} and {other} swapped"


def _directory(data, number):
    offset, count = struct.unpack_from("<QI", data, 24)
    rows = [offset + SECTION.size * i for i in range(count)]
    found = [row for row in rows if data[row : row + 4] == b"TDIR"]
    return struct.unpack_from("<Q", data, found[number] + 8)[0]
