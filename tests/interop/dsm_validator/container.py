"""The prologue and the section table (sections 2 and 3)."""

import struct
from dataclasses import dataclass

from .checksum import crc32c
from .extents import Extent
from .fault import Limits, demand

MAGIC = b"\x89DSM\r\n\x1a\n"
MAJOR, MINOR = 1, 0
PROLOGUE = struct.Struct("<8sHHIQQII20sI")
SECTION = struct.Struct("<4sIQQI4s")
REQUIRED = 1
KNOWN = (b"META", b"LEVL", b"TDIR")


@dataclass(frozen=True)
class Section:
    kind: bytes
    extent: Extent
    checksum: int


@dataclass(frozen=True)
class Container:
    """A file whose prologue and sections are as they must be."""

    data: bytes
    newer: bool
    sections: list
    extents: list

    def of_kind(self, kind):
        return [section for section in self.sections if section.kind == kind]

    def contents(self, section):
        return section.extent.read(self.data, section.checksum)


def read_container(data, limits):
    """The sections of a file, each of which was checked against its checksum, known or not."""
    demand(data[: len(MAGIC)] == MAGIC, "prologue", "the file does not begin with the magic")
    demand(len(data) >= PROLOGUE.size, "prologue", f"the file has {len(data)} bytes")
    prologue = data[: PROLOGUE.size]
    _, major, minor, flags, length, offset, count, table_sum, reserved, _ = PROLOGUE.unpack(prologue)
    # Of another major version nothing but this is known.
    demand(major == MAJOR, "prologue", f"the major version is {major}")
    _check_prologue_sum(prologue)
    newer = minor > MINOR
    demand(flags & 0xFFFF == 0, "prologue", f"the flags {flags:08x} have a required bit that is not known")
    demand(newer or (flags == 0 and not any(reserved)), "prologue", "reserved bits are not zero")
    demand(length == len(data), "prologue", f"the file has {len(data)} bytes, not {length}")

    Limits.hold(count, limits.sections, "prologue", "sections")
    table = Extent("section table", offset, SECTION.size * count)
    rows = table.read(data, table_sum)
    sections = [_section(row, number, newer) for number, row in enumerate(SECTION.iter_unpack(rows))]
    for section in sections:
        section.extent.place_in(data)
        Limits.hold(section.extent.length, limits.section_bytes, section.extent.name, "bytes")
        section.extent.read(data, section.checksum)
    extents = [Extent("prologue", 0, PROLOGUE.size), table, *(section.extent for section in sections)]
    return Container(data, newer, sections, extents)


def _check_prologue_sum(prologue):
    stated = struct.unpack_from("<I", prologue, 60)[0]
    found = crc32c(prologue[:60])
    demand(found == stated, "prologue", f"its checksum is {found:08x}, not {stated:08x}")


def _section(row, number, newer):
    kind, flags, offset, length, checksum, reserved = row
    name = f"section {number} ({kind!r})"
    demand(newer or (flags & ~REQUIRED == 0 and not any(reserved)), name, "reserved bits are not zero")
    if kind in KNOWN:
        demand(flags & REQUIRED, name, "a section of this kind has the flag required")
    else:
        demand(not flags & REQUIRED, name, "it is required and of a kind that is not known")
    return Section(kind, Extent(name, offset, length), checksum)
