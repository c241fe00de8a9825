"""What is wrong with a file, and what is merely more than this program takes on."""

from dataclasses import dataclass


class Fault(Exception):
    """A rule of the format that a file breaks: the place in the file, and the rule."""

    def __init__(self, place, rule):
        super().__init__(f"{place}: {rule}")
        self.place = place
        self.rule = rule


class BeyondLimits(Fault):
    """A size that the format allows and this program does not take on."""


@dataclass(frozen=True)
class Limits:
    """How much a file may state before it is refused unread; section 9 names these numbers."""

    sections: int = 65_536
    section_bytes: int = 1 << 30
    tiles: int = 4_194_304
    tile_bytes: int = 1 << 28
    nesting: int = 127
    window: int = 1 << 27

    @staticmethod
    def hold(size, most, place, what):
        if size > most:
            raise BeyondLimits(place, f"{size} {what} are more than {most}")


def demand(condition, place, rule):
    """Raises a fault unless the rule is kept."""
    if not condition:
        raise Fault(place, rule)
