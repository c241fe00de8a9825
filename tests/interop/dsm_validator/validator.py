"""The whole of a file, in the order in which its parts are needed."""

from .blocks import unpack
from .container import read_container
from .directory import read_directory
from .extents import check_cover
from .fault import BeyondLimits, Fault, Limits, demand
from .kinds import KINDS
from .levels import read_levels
from .metadata import read_metadata


def check(data, limits=Limits()):
    """Raises the first fault that is found in the bytes of a file."""
    container = read_container(data, limits)
    for kind in (b"META", b"LEVL"):
        demand(len(container.of_kind(kind)) == 1, "section table", f"there is not one section {kind!r}")
    metadata = read_metadata(container.contents(container.of_kind(b"META")[0]), limits)
    kind = KINDS.get((metadata.kind, metadata.version))
    demand(kind, "metadata", f"kind {metadata.kind!r}, version {metadata.version}, is not known")
    kind.check_metadata(metadata)
    levels = read_levels(container.contents(container.of_kind(b"LEVL")[0]), container.newer, limits)
    kind.check_levels(metadata, levels)
    directories = _directories(container, levels)
    if hasattr(kind, "check_errors"):
        kind.check_errors(levels, directories)
    entries = [entry for directory in directories for entry in directory if not entry.empty]
    check_cover([*container.extents, *(entry.extent for entry in entries)], len(data))
    for entry in entries:
        payload = entry.extent.read(data, entry.checksum)
        demand(entry.codec in kind.codecs, entry.place, f"codec {entry.codec} is not known")
        moved = entry.depth_error != 0 and metadata.kind != "deep"
        demand(not moved, entry.place, "depths of a map of this kind have no error")
        kind.check_tile(metadata, entry, unpack(entry, payload, limits))


def _directories(container, levels):
    """A section each: no two levels share one, and none is left."""
    named = [level.directory for level in levels]
    demand(len(set(named)) == len(named), "levels", "two levels name one directory")
    demand(len(container.of_kind(b"TDIR")) == len(levels), "section table", "there is not one directory a level")
    directories = []
    for level in levels:
        known = level.directory < len(container.sections)
        section = container.sections[level.directory] if known else None
        demand(known and section.kind == b"TDIR", level.place, "its directory is no such section")
        directories.append(read_directory(container.contents(section), level, container.newer))
    return directories


def verdict(data, limits=Limits()):
    """None for a valid file, else what is wrong with it (`BeyondLimits`: what it states too much of)."""
    try:
        check(data, limits)
    except Fault as fault:
        return fault
    return None


__all__ = ["BeyondLimits", "Fault", "Limits", "check", "verdict"]
