"""The attributes of the metadata (section 4)."""

import re

from .fault import demand
from .fields import array, integer, real_f64
from .numbers import OVERFLOW

HEX = re.compile("(?:[0-9a-fA-F]{2})*", re.ASCII)


def _string(value, place):
    demand(isinstance(value, str), place, "it is not a string")


def _float(value, place):
    """Read as binary64, and then rounded."""
    real_f64(value, place)
    demand(abs(value.f64()) < OVERFLOW, place, f"{value!r} is not finite")


def _int(value, place):
    integer(value, -(2**31), 2**31 - 1, place)


# What `value` may be, by type: how many numbers, in an array or (None) alone, and of which kind.
VALUES = {
    "string": (None, _string),
    "int": (None, _int),
    **{name: (count, _int) for name, count in (("v2i", 2), ("v3i", 3), ("box2i", 4))},
    "float": (None, _float),
    **{
        name: (count, _float)
        for name, count in (
            ("v2f", 2), ("v3f", 3), ("box2f", 4), ("chromaticities", 8), ("m33f", 9), ("m44f", 16),
        )
    },
    "double": (None, real_f64),
    **{name: (count, real_f64) for name, count in (("v2d", 2), ("v3d", 3), ("m33d", 9), ("m44d", 16))},
}


def check_attributes(attributes):
    """Every attribute has a type, and either a value that its type has or pairs of hexadecimal digits."""
    for name in attributes.value:
        attribute = attributes.object(name)
        kind = attribute.text("type")
        place = attribute.name
        alone = (attribute.nullable("value") is None) != (attribute.nullable("hex") is None)
        demand(alone, place, "it has not either value or hex")
        if attribute.nullable("hex") is not None:
            demand(HEX.fullmatch(attribute.text("hex")), place, "hex is not pairs of hexadecimal digits")
            continue
        demand(kind in VALUES, place, f"an attribute of type {kind!r} has no value")
        count, check = VALUES[kind]
        value = attribute.get("value")
        for number in [value] if count is None else array(value, place, count):
            check(number, place)
