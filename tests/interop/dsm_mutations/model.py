"""A file in parts that can be changed, and the file of such parts with its checksums and offsets."""

import copy
import struct
from dataclasses import dataclass, field

import numpy as np
import zstandard

from dsm_validator.blocks import CODED, split, unpack
from dsm_validator.checksum import crc32c
from dsm_validator.container import PROLOGUE, SECTION
from dsm_validator.directory import ENTRY, read_directory
from dsm_validator.extents import padded
from dsm_validator.fault import Limits
from dsm_validator.kinds import KINDS
from dsm_validator.levels import RECORD, read_levels
from dsm_validator.metadata import read_metadata


@dataclass
class Tile:
    """A directory entry, and the words of the payload: None if there is none."""

    entry: bytearray
    words: np.ndarray | None
    # How many words each column has; the last one gets what was put in.
    lengths: list = field(default_factory=list)
    # Bytes behind the words, of payloads that are no columns.
    tail: bytes = b""
    # Instead of what the words become in the block of the entry.
    payload: bytes | None = None

    @property
    def block(self):
        return self.entry[57]

    @property
    def raw_length(self):
        return struct.unpack_from("<Q", self.entry, 16)[0]


@dataclass
class Model:
    """The parts of a valid file; `write` gives them checksums, and offsets as they come."""

    metadata: bytes
    levels: list
    directories: list
    extra: list = field(default_factory=list)
    minor: int = 0
    sections_first: bool = False

    def copy(self):
        return copy.deepcopy(self)

    def tiles(self):
        """All tiles that have a payload."""
        return [tile for directory in self.directories for tile in directory if tile.words is not None]

    @staticmethod
    def read(data):
        offset, count = struct.unpack_from("<QI", data, 24)
        sections = [SECTION.unpack_from(data, offset + SECTION.size * i) for i in range(count)]
        parts = [data[row[2] : row[2] + row[3]] for row in sections]
        of_kind = {row[0]: part for row, part in zip(sections, parts)}
        levels = [bytearray(part) for part in _records(of_kind[b"LEVL"], RECORD.size)]
        metadata = read_metadata(of_kind[b"META"], Limits())
        directories = []
        for level in read_levels(of_kind[b"LEVL"], False, Limits()):
            entries = read_directory(parts[level.directory], level, False)
            raw = _records(parts[level.directory], ENTRY.size)
            directories.append([_tile(data, metadata, *both) for both in zip(entries, raw)])
        return Model(of_kind[b"META"], levels, directories)

    def write(self):
        """The bytes of a file. `extra` sections come behind the others: (kind, flags, bytes)."""
        out = bytearray(PROLOGUE.size)
        table = []
        if self.sections_first:
            table.append(_section(out, b"META", 1, self.metadata))
        directories = []
        for directory in self.directories:
            for tile in directory:
                _place_tile(out, tile)
            directories.append(b"".join(tile.entry for tile in directory))
        if not self.sections_first:
            table.append(_section(out, b"META", 1, self.metadata))
        for level, directory in zip(self.levels, directories):
            struct.pack_into("<I", level, 44, len(table))
            table.append(_section(out, b"TDIR", 1, directory))
        table.append(_section(out, b"LEVL", 1, b"".join(self.levels)))
        table += [_section(out, kind, flags, contents) for kind, flags, contents in self.extra]
        rows = b"".join(table)
        offset, checksum = _append(out, rows)
        PROLOGUE.pack_into(
            out, 0, b"\x89DSM\r\n\x1a\n", 1, self.minor, 0, len(out), offset, len(table), checksum, bytes(20), 0
        )
        struct.pack_into("<I", out, 60, crc32c(bytes(out[:60])))
        return bytes(out)


def _records(data, size):
    return [data[at : at + size] for at in range(0, len(data), size)]


def _tile(data, metadata, entry, raw):
    if entry.empty:
        return Tile(bytearray(raw), None)
    contents = unpack(entry, data[entry.offset : entry.offset + entry.length], Limits())
    if entry.block == CODED:
        whole = len(contents) // 4
        words = np.frombuffer(contents, "<u4", whole).copy()
        return Tile(bytearray(raw), words, [whole], contents[4 * whole :])
    lengths = KINDS[metadata.kind, metadata.version].lengths(entry, metadata.channels, contents)
    columns = split(entry, contents, lengths, spare=range(8))
    words = np.concatenate([column for column in columns if column is not None])
    return Tile(bytearray(raw), words, lengths)


def _packed(tile):
    """The payload of the words in the block of the entry."""
    if tile.block != 1:
        return tile.words.astype("<u4").tobytes() + tile.tail
    planes = []
    at = 0
    for index, length in enumerate(tile.lengths):
        if length is None:
            continue
        column = tile.words[at : at + length] if index + 1 < len(tile.lengths) else tile.words[at:]
        at += length
        if tile.entry[58] >> index & 1:
            column = np.diff(column, prepend=np.uint32(0))
        planes.append(column.astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes())
    return zstandard.ZstdCompressor(level=3).compress(b"".join(planes))


def _place_tile(out, tile):
    """Appends a payload, and states it in the entry."""
    if tile.words is None:
        return
    payload = tile.payload
    if payload is None:
        payload = _packed(tile)
    offset, checksum = _append(out, payload)
    # Of coded numbers nothing but the entry tells how long their columns are.
    unpacked = tile.raw_length if tile.block == CODED else 4 * len(tile.words)
    struct.pack_into("<QQQ", tile.entry, 0, offset, len(payload), unpacked)
    struct.pack_into("<I", tile.entry, 52, checksum)


def _append(out, contents):
    offset = len(out)
    out += contents + bytes(padded(len(contents)) - len(contents))
    return offset, crc32c(bytes(out[offset:]))


def _section(out, kind, flags, contents):
    offset, checksum = _append(out, contents)
    return SECTION.pack(kind, flags, offset, len(contents), checksum, bytes(4))
