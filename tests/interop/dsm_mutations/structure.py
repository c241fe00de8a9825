"""Changes of what a file is made of: other sections, levels and tiles, another order, a newer version, bytes."""

import json
import struct

from .model import Tile
from .odd import flip, odd_word
from .sign import resign


def sections(chance, model):
    """One more section, of a kind that is known or not, required or not."""
    kind = chance.choice((b"note", b"NOTE", b"META", b"LEVL", b"TDIR", b"\0\0\0\0", b"n\xff\x80!", b"meta"))
    flags = chance.choice((0, 0, 0, 1, 2, 3, 1 << 31))
    contents = chance.choice((b"", b"x", bytes(64), bytes(range(65)), model.metadata))
    model.extra.append((kind, flags, contents))
    return model.write(), f"section {kind} with flags {flags} and {len(contents)} bytes"


def empty_extent(chance, model):
    """A section of length 0 that stands somewhere: where another extent begins, within one, or behind the file."""
    model.extra.append((b"note", 0, b""))
    data = bytearray(model.write())
    offset, count = struct.unpack_from("<QI", data, 24)
    place = 64 * chance.randrange(len(data) // 64 + 2) + chance.choice((0, 0, 0, 0, 1))
    struct.pack_into("<Q", data, offset + 32 * (count - 1) + 8, place)
    return resign(data), f"an empty section at {place} of {len(data)}"


def order(chance, model):
    """Metadata before the tiles, or tiles in another order: both allowed."""
    model.sections_first = True
    model.extra.append((b"note", 0, b"an empty extent's neighbour"))
    model.extra.append((b"note", 0, b""))
    return model.write(), "metadata before the tiles, an empty section"


def newer(chance, model):
    """A newer minor version, with or without what only that may have."""
    model.minor = chance.choice((1, 2, 65535))
    told = [f"minor version {model.minor}"]
    if chance.random() < 0.5:
        level = chance.choice(model.levels)
        level[48 + chance.randrange(16)] = 1
        told.append("reserved bytes of a level")
    if chance.random() < 0.5:
        entry = chance.choice(chance.choice(model.directories)).entry
        entry[59 + chance.randrange(5)] = 1
        told.append("reserved bytes of an entry")
    data = bytearray(model.write())
    if chance.random() < 0.5:
        at = 40 + chance.randrange(20)
        data[at] = 1
        told.append(f"byte {at}")
    if chance.random() < 0.5:
        at = chance.choice((12, 13, 14, 15))
        data[at] = 1
        told.append(f"flags at {at}")
    if chance.random() < 0.5:
        row = struct.unpack_from("<Q", data, 24)[0]
        at = row + chance.choice((5, 7, 28, 31))
        data[at] = 1
        told.append(f"section table at {at - row}")
    return resign(data), ", ".join(told)


def levels(chance, model):
    """A level left out, twice, or changed with another; or numbered otherwise."""
    number = chance.randrange(len(model.levels))
    way = chance.randrange(5)
    if way == 0 and len(model.levels) > 1:
        del model.levels[number], model.directories[number]
    elif way == 1:
        other = chance.randrange(len(model.levels))
        for part in (model.levels, model.directories):
            part[number], part[other] = part[other], part[number]
    elif way == 2:
        copy = model.copy()
        model.levels.append(copy.levels[number])
        model.directories.append(copy.directories[number])
        last = struct.unpack_from("<II", model.levels[-2])
        where = chance.choice(((last[0], last[1] + 1), (last[0] + 1, 0), (last[0], last[1])))
        struct.pack_into("<II", model.levels[-1], 0, *where)
    elif way == 3:
        struct.pack_into("<II", model.levels[number], 0, chance.randrange(3), chance.randrange(3))
    else:
        at = chance.choice((16, 20))
        place = struct.unpack_from("<i", model.levels[number], at)[0] + chance.choice((-8, -4, -1, 1, 4, 5, 8))
        struct.pack_into("<i", model.levels[number], at, place)
    return model.write(), f"levels, way {way}, level {number}"


def resized(chance, model):
    """A map of nothing, of another size or place, in level 0 and in the metadata alike or nearly."""
    sides = (1, 2, 7, 255, 4096, 65536, 2**20, 2**24, 2**24 + 1, 2**31 - 1, 2**31, 2**32 - 1)
    whole = [chance.choice(sides) for _ in range(2)]
    size = [chance.choice((side, side, side, max(1, side // 2))) for side in whole]
    tile = [chance.choice((side, side, max(1, side // 2))) for side in size]
    place = [chance.choice((0, 0, part)) for part in tile]
    root = json.loads(model.metadata)
    root["width"], root["height"] = whole
    if "eyes" in root:
        root["eyes"] = root["eyes"][:1]
    model.metadata = json.dumps(root).encode()
    del model.levels[1:], model.directories[1:]
    struct.pack_into("<IIIIII", model.levels[0], 8, *size, *place, *tile)
    model.levels[0][36:44] = bytes(8)
    tiles = [-(-side // part) for side, part in zip(size, tile)]
    model.directories[0] = [Tile(bytearray(64), None) for _ in range(tiles[0] * tiles[1])]
    return model.write(), f"nothing in {size} pixels at {place} of {whole}, tiles {tile}"


def emptied(chance, model):
    """A tile without its payload, or an empty one that keeps a field."""
    tile = chance.choice(chance.choice(model.directories))
    kept = bytes(tile.entry[40:48])
    way = chance.randrange(4)
    if way == 0 and tile.words is not None:
        tile.words = None
        tile.entry[:] = bytes(64)
        tile.entry[40:48] = kept
    elif way == 1:
        tile.words = None
        tile.entry[:40] = bytes(40)
        tile.entry[48:] = bytes(16)
        at = chance.choice((8, 16, 24, 32, 36, 48, 52, 56))
        struct.pack_into("<I", tile.entry, at, chance.choice((1, 0x80000000, odd_word(chance, 0))))
    elif tile.words is not None:
        at = chance.choice((24, 48, 56))
        struct.pack_into("<I", tile.entry, at, odd_word(chance, struct.unpack_from("<I", tile.entry, at)[0]))
    return model.write(), f"an entry emptied, way {way}: {bytes(tile.entry).hex()}"


def any_byte(chance, model):
    """Bytes flipped anywhere, checksums right again."""
    data = bytearray(model.write())
    places = sorted({chance.randrange(len(data)) for _ in range(chance.choice((1, 1, 2)))})
    for at in places:
        flip(chance, data, at)
    return resign(data), f"bytes {places} of {len(data)} flipped"


def unsigned(chance, model):
    """A flipped byte, a cut end or more bytes, and checksums as they were."""
    data = bytearray(model.write())
    way = chance.randrange(4)
    if way < 2:
        flip(chance, data, chance.randrange(len(data)))
    elif way == 2:
        del data[chance.randrange(len(data)) :]
    else:
        data += bytes(chance.choice((1, 63, 64, 65)))
    return bytes(data), f"unsigned, way {way}"
