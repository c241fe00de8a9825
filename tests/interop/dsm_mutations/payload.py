"""Changes of what tiles hold: words of their unpacked contents, and the frames they are packed in."""

import struct

import numpy as np
import zstandard

from .odd import odd_word


def words(chance, model):
    """One to three words replaced, copied, swapped, put in or left out; packed anew."""
    tile = _tile(chance, model)
    if tile is None:
        return None
    contents = tile.words
    told = []
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        at, other = (chance.randrange(len(contents)) for _ in range(2))
        way = chance.randrange(8)
        if way < 4:
            contents[at] = odd_word(chance, int(contents[at]))
        elif way == 4:
            contents[at] = contents[other]
        elif way == 5:
            at = min(at, len(contents) - 2) if len(contents) > 1 else 0
            contents[at : at + 2] = contents[at : at + 2][::-1].copy()
        elif way == 6:
            contents = np.insert(contents, at, contents[other])
        elif len(contents) > 1:
            contents = np.delete(contents, at)
        told.append(f"word {at} of {len(contents)}, way {way}")
    tile.words = contents
    return model.write(), "; ".join(told)


def column(chance, model):
    """One or two words of one column, short ones as often as long ones, become what the column has elsewhere or what
    such a column has often: changes that only the rules of the kind tell."""
    tile = _tile(chance, model)
    if tile is None:
        return None
    lengths = [length or 0 for length in tile.lengths]
    index = chance.choice([i for i, length in enumerate(lengths) if length])
    begin, length = sum(lengths[:index]), lengths[index]
    told = []
    for _ in range(chance.choice((1, 1, 2))):
        at = begin + chance.randrange(length)
        other = int(tile.words[begin + chance.randrange(length)])
        near = int(tile.words[max(begin, at - 1)])
        new = chance.choice((other, other, near, 0, 0, 1, 0x3F800000, odd_word(chance, other)))
        tile.words[at] = new
        told.append(f"{at - begin} becomes {new:08x}")
    return model.write(), f"column {index}: word " + ", ".join(told)


def coded(chance, model):
    """A bit or a byte of coded numbers, at their header, among frequencies, words or states."""
    tiles = [tile for tile in model.tiles() if tile.block == 2]
    if not tiles:
        return None
    tile = chance.choice(tiles)
    payload = bytearray(tile.words.tobytes() + tile.tail)
    at = chance.choice((0, 1, 2, -1, -4, -8, -9, -10, chance.randrange(len(payload)), chance.randrange(len(payload))))
    if chance.random() < 0.7:
        payload[at] ^= 1 << chance.randrange(8)
    else:
        payload[at] = chance.choice((0, 1, 23, 24, 25, 255, payload[at] ^ 0x80))
    if chance.random() < 0.1:
        payload = payload[:at] + payload[at:][1:]
    tile.payload = bytes(payload)
    return model.write(), f"byte {at} of {len(payload)}"


def everywhere(chance, model):
    """Every word that is a certain number becomes another: zeros, ones, the depth of a step."""
    tile = _tile(chance, model)
    if tile is None:
        return None
    contents = tile.words
    old = int(contents[chance.randrange(len(contents))])
    new = odd_word(chance, old)
    contents[contents == old] = new
    tile.words = contents
    if chance.random() < 0.5:
        # With what the entry says of its depths.
        for at in (32, 36):
            if struct.unpack_from("<I", tile.entry, at)[0] == old:
                struct.pack_into("<I", tile.entry, at, new)
    return model.write(), f"each word {old:08x} is {new:08x}"


def depth_range(chance, model):
    """The depths of an entry, a little or much wider or narrower."""
    tile = _tile(chance, model)
    if tile is None:
        return None
    at = chance.choice((32, 36))
    now = struct.unpack_from("<f", tile.entry, at)[0]
    bits = struct.unpack_from("<I", tile.entry, at)[0]
    new = chance.choice(
        [
            struct.pack("<I", max(0, bits + chance.choice((1, -1, 2, -2, 8, -8, 64, -64)))),
            struct.pack("<f", min(now * chance.choice((0.5, 0.999, 1.001, 2)), 3e38)),
        ]
    )
    tile.entry[at : at + 4] = new
    return model.write(), f"depth of an entry at {at}: {now} becomes {struct.unpack('<f', new)[0]}"


def frame(chance, model):
    """The same contents, packed in another way, right or wrong."""
    tile = _tile(chance, model)
    if tile is None:
        return None
    raw = tile.words.tobytes()
    tile.entry[57] = 1
    pack = zstandard.ZstdCompressor
    good = pack(level=1).compress(raw)
    ways = {
        "a checksum": lambda: pack(level=5, write_checksum=True).compress(raw),
        "no size": lambda: pack(level=5, write_content_size=False).compress(raw),
        "a window": lambda: _windowed(chance.choice((10, 20, 27, 28)), raw),
        "two frames": lambda: good + pack().compress(b""),
        "two halves": lambda: pack().compress(raw[: len(raw) // 2]) + pack().compress(raw[len(raw) // 2 :]),
        "a skippable frame behind": lambda: good + b"\x50\x2a\x4d\x18\x04\x00\x00\x00abcd",
        "a skippable frame before": lambda: b"\x50\x2a\x4d\x18\x04\x00\x00\x00abcd" + good,
        "bytes behind": lambda: good + bytes(chance.randint(1, 70)),
        "a cut end": lambda: good[: -chance.randint(1, min(20, len(good) - 1))],
        "more contents": lambda: pack().compress(raw + bytes(chance.choice((1, 4, 1 << 16)))),
        "less contents": lambda: pack().compress(raw[: -chance.choice((1, 4))]),
        "a bomb": lambda: pack().compress(raw + bytes(1 << 24)),
        "a dictionary's name": lambda: _named(good, chance.choice((0, 7))),
        "nothing": lambda: b"",
        "an empty frame": lambda: pack().compress(b""),
        "a flipped bit": lambda: _flipped(chance, good),
        "a flipped bit with a checksum": lambda: _flipped(chance, pack(write_checksum=True).compress(raw)),
    }
    way = chance.choice(list(ways))
    tile.payload = ways[way]()
    return model.write(), f"a frame with {way}"


def packing(chance, model):
    """Other differences or another block: nothing else is changed, or the contents are as they then must be."""
    tile = _tile(chance, model)
    if tile is None:
        return None
    if chance.random() < 0.5:
        tile.entry[57] = chance.choice([block for block in range(3) if block != tile.block])
        if chance.random() < 0.5:
            tile.entry[58] = 0
        told = "the other block"
    else:
        tile.entry[58] ^= 1 << chance.randrange(8)
        told = f"differences {tile.entry[58]:08b}"
    if chance.random() < 0.1:
        tile.entry[56] = chance.choice((0, 1, 2, 255))
        told += f", codec {tile.entry[56]}"
    return model.write(), told


def _tile(chance, model):
    tiles = model.tiles()
    return chance.choice(tiles) if tiles else None


def _windowed(log, raw):
    """A frame that states a window of 2^log bytes, and no size."""
    parameters = zstandard.ZstdCompressionParameters.from_level(3, window_log=min(log, 20), write_content_size=0)
    packer = zstandard.ZstdCompressor(compression_params=parameters).compressobj()
    frame = bytearray(packer.compress(raw) + packer.flush())
    assert frame[4] & 0xE3 == 0
    frame[5] = (log - 10) << 3
    return bytes(frame)


def _named(frame, name):
    """A frame of one segment with the name of a dictionary, of which 0 is none."""
    assert frame[4] & 0x23 == 0x20
    return frame[:4] + bytes([frame[4] | 1, name]) + frame[5:]


def _flipped(chance, data):
    data = bytearray(data)
    data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return bytes(data)
