"""Extents (section 1): aligned, padded with zeros, under a checksum, and covering the file exactly."""

from dataclasses import dataclass

from .checksum import crc32c
from .fault import demand

ALIGNMENT = 64


def padded(length):
    return -(-length // ALIGNMENT) * ALIGNMENT


@dataclass(frozen=True)
class Extent:
    name: str
    offset: int
    length: int

    @property
    def end(self):
        return self.offset + padded(self.length)

    def place_in(self, data):
        """Checks that the extent lies in the file."""
        demand(self.offset % ALIGNMENT == 0, self.name, f"its offset {self.offset} is no multiple of {ALIGNMENT}")
        demand(
            self.end <= len(data),
            self.name,
            f"{self.length} bytes at {self.offset} do not lie in a file of {len(data)} bytes",
        )

    def read(self, data, checksum=None):
        """Its bytes, after its place, its padding and its checksum were checked."""
        self.place_in(data)
        demand(not any(data[self.offset + self.length : self.end]), self.name, "its padding is not zero")
        if checksum is not None:
            found = crc32c(data[self.offset : self.end])
            demand(found == checksum, self.name, f"its checksum is {found:08x}, not {checksum:08x}")
        return data[self.offset : self.offset + self.length]


def check_cover(extents, length):
    """All bytes belong to one extent each; an empty extent stands where another begins or the file ends."""
    at = 0
    starts = set()
    for extent in sorted((e for e in extents if e.length), key=lambda extent: extent.offset):
        demand(extent.offset >= at, extent.name, "it overlaps another extent")
        demand(extent.offset == at, extent.name, f"the bytes from {at} to {extent.offset} belong to no extent")
        starts.add(extent.offset)
        at = extent.end
    demand(at == length, "file", f"the bytes from {at} to {length} belong to no extent")
    for extent in extents:
        demand(
            extent.length or extent.offset in starts or extent.offset == length,
            extent.name,
            "it is empty, and no other extent begins there",
        )
