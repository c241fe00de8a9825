"""Blocks (section 7): from the payload of a tile to its columns of 32-bit words."""

import numpy as np
import zstandard

from .fault import Limits, demand

PLAIN, ZSTD, CODED = 0, 1, 2
FRAME_MAGIC = b"\x28\xb5\x2f\xfd"


def unpack(entry, payload, limits):
    """The contents of a payload, as long as the entry states: words one after the other, or planes."""
    place = entry.place
    known = (PLAIN, ZSTD, CODED) if entry.codec == 1 else (PLAIN, ZSTD)
    demand(entry.block in known, place, f"block {entry.block} is not known")
    Limits.hold(entry.raw_length, limits.tile_bytes, place, "bytes unpacked")
    demand(entry.raw_length % 4 == 0, place, f"{entry.raw_length} bytes are no words")
    if entry.block == CODED:
        return payload
    if entry.block == PLAIN:
        demand(entry.differences == 0, place, "a plain tile has no differences")
        demand(len(payload) == entry.raw_length, place, f"a plain payload of {len(payload)} bytes is as long unpacked")
        return payload
    return _unpack_frame(payload, entry.raw_length, place, limits)


def _unpack_frame(payload, length, place, limits):
    demand(payload[:4] == FRAME_MAGIC, place, "its payload is not a zstd frame")
    try:
        parameters = zstandard.get_frame_parameters(payload)
        demand(parameters.dict_id == 0, place, "its frame needs a dictionary")
        Limits.hold(parameters.window_size, limits.window, place, "bytes of a frame's window")
        frame = zstandard.ZstdDecompressor(max_window_size=limits.window).decompressobj()
        contents = bytearray()
        # In pieces: a frame may unpack to far more than it should.
        for at in range(0, len(payload), 4096):
            contents += frame.decompress(payload[at : at + 4096])
            demand(len(contents) <= length, place, f"its frame unpacks to more than {length} bytes")
            if frame.eof:
                rest = len(frame.unused_data) + max(0, len(payload) - at - 4096)
                demand(rest == 0, place, f"{rest} bytes follow its frame")
                break
    except zstandard.ZstdError as error:
        demand(False, place, f"its frame does not unpack: {error}")
    demand(frame.eof, place, "its frame does not end")
    demand(len(contents) == length, place, f"its frame unpacks to {len(contents)} bytes, not {length}")
    return bytes(contents)


def split(entry, contents, lengths, spare=()):
    """Columns of the given lengths in words (None: the codec lacks it; bits of `spare` ones are without meaning)."""
    demand(sum(n or 0 for n in lengths) * 4 == len(contents), entry.place, "its length is not that of its columns")
    kept = sum(1 << i for i, n in enumerate(lengths) if n is not None or i in spare)
    demand(entry.differences & ~kept == 0, entry.place, "differences name a column that is not there")
    columns = []
    at = 0
    for index, words in enumerate(lengths):
        if words is None:
            columns.append(None)
            continue
        part = np.frombuffer(contents, np.uint8, 4 * words, at)
        at += 4 * words
        if entry.block == ZSTD:
            part = np.ascontiguousarray(part.reshape(4, words).T).ravel()
        column = part.view("<u4")
        if entry.differences >> index & 1:
            column = np.cumsum(column, dtype=np.uint32)
        columns.append(column)
    return columns
