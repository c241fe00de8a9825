"""Typed access to the keys of a JSON object: what section 4 and 13 say of each key is said where it is read."""

import math

from .fault import demand
from .json_text import Number

MOST_U32 = 2**32 - 1


class Fields:
    """An object of the metadata, with its name for messages."""

    def __init__(self, value, name):
        demand(isinstance(value, dict), name, "it is not an object")
        self.value = value
        self.name = name

    def __contains__(self, key):
        return key in self.value

    def place(self, key):
        return f"{self.name}: {key}"

    def get(self, key):
        demand(key in self.value, self.name, f"it has no key {key}")
        return self.value[key]

    def nullable(self, key):
        """Its value, None if it is null or missing."""
        return self.value.get(key)

    def text(self, key):
        value = self.get(key)
        demand(isinstance(value, str), self.place(key), "it is not a string")
        return value

    def one_of(self, key, names):
        value = self.text(key)
        demand(value in names, self.place(key), f"{value!r} is none of {', '.join(names)}")
        return value

    def integer(self, key, least, most):
        return integer(self.get(key), least, most, self.place(key))

    def real(self, key, least=-math.inf, most=math.inf, below=math.inf):
        return real(self.get(key), self.place(key), least, most, below)

    def flag(self, key):
        value = self.get(key)
        demand(isinstance(value, bool), self.place(key), "it is not true or false")
        return value

    def array(self, key, length=None):
        return array(self.get(key), self.place(key), length)

    def object(self, key):
        return Fields(self.get(key), self.place(key))

    def object_or_null(self, key):
        return None if self.nullable(key) is None else self.object(key)


def integer(value, least, most, place):
    number = value.integer() if isinstance(value, Number) else None
    demand(number is not None, place, f"{value!r} is not an integer")
    demand(least <= number <= most, place, f"{number} does not lie in {least} to {most}")
    return number


def real(value, place, least=-math.inf, most=math.inf, below=math.inf):
    """An f32 within bounds: after rounding, from `least` to `most` and less than `below`."""
    demand(isinstance(value, Number), place, f"{value!r} is not a number")
    number = value.f32()
    demand(math.isfinite(number), place, f"{value!r} is not finite")
    demand(least <= number <= most and number < below, place, f"{value!r} is out of range")
    return number


def real_f64(value, place):
    demand(isinstance(value, Number), place, f"{value!r} is not a number")
    demand(math.isfinite(value.f64()), place, f"{value!r} is not finite")


def array(value, place, length=None):
    demand(isinstance(value, list), place, "it is not an array")
    demand(length is None or len(value) == length, place, f"it has {len(value)} items, not {length}")
    return value
