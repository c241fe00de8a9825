"""Checksums made right again in a file whose bytes were changed, as far as its offsets still lie in it."""

import struct

from dsm_validator.checksum import crc32c
from dsm_validator.container import PROLOGUE, SECTION
from dsm_validator.directory import ENTRY
from dsm_validator.extents import padded


def resign(data):
    """The file with right checksums, from the payloads to the prologue."""
    data = bytearray(data)
    if len(data) < PROLOGUE.size:
        return bytes(data)
    offset, count = struct.unpack_from("<QI", data, 24)
    if _inside(data, offset, SECTION.size * count):
        rows = [offset + SECTION.size * i for i in range(count)]
        for row in rows:
            if data[row : row + 4] == b"TDIR":
                _sign_payloads(data, *struct.unpack_from("<QQ", data, row + 8))
        for row in rows:
            begin, length = struct.unpack_from("<QQ", data, row + 8)
            if _inside(data, begin, length):
                struct.pack_into("<I", data, row + 24, _checksum(data, begin, length))
        struct.pack_into("<I", data, 36, _checksum(data, offset, SECTION.size * count))
    struct.pack_into("<I", data, 60, crc32c(bytes(data[:60])))
    return bytes(data)


def _sign_payloads(data, offset, length):
    if not _inside(data, offset, length):
        return
    for entry in range(offset, offset + length - ENTRY.size + 1, ENTRY.size):
        begin, size = struct.unpack_from("<QQ", data, entry)
        if begin and _inside(data, begin, size):
            struct.pack_into("<I", data, entry + 52, _checksum(data, begin, size))


def _inside(data, offset, length):
    return offset + padded(length) <= len(data)


def _checksum(data, offset, length):
    return crc32c(bytes(data[offset : offset + padded(length)]))
