"""JSON (RFC 8259) as section 4 has it: UTF-8, no key twice, and numbers kept as they were written."""

import json
import math
import re

from .fault import BeyondLimits, demand
from .numbers import nearest_f32

INTEGER = re.compile(r"0|-?[1-9][0-9]*", re.ASCII)


class Number:
    """A number of a JSON text."""

    def __init__(self, text):
        self.text = text

    def __repr__(self):
        return self.text

    def integer(self):
        """Its value if it is written as an integer, else None."""
        if not INTEGER.fullmatch(self.text):
            return None
        # No integer of the format has more digits than 20; longer ones only have to be out of range.
        return int(self.text) if len(self.text) <= 40 else (-1) ** self.text.startswith("-") * 10**40

    def f64(self):
        return float(self.text)

    def f32(self):
        return nearest_f32(self.text)


def parse(contents, place, limits):
    """The value of a JSON text."""
    try:
        text = contents.decode("utf-8")
    except UnicodeDecodeError as error:
        demand(False, place, f"it is not UTF-8: {error}")
    _check_nesting(text, limits.nesting, place)

    def unique(pairs):
        value = dict(pairs)
        demand(len(value) == len(pairs), place, "an object has a key twice")
        return value

    def number(digits):
        demand(math.isfinite(float(digits)), place, f"{digits[:60]} is beyond every f64")
        return Number(digits)

    def constant(name):
        demand(False, place, f"{name} is not of JSON")

    try:
        value = json.loads(
            text, object_pairs_hook=unique, parse_int=number, parse_float=number, parse_constant=constant
        )
    except json.JSONDecodeError as error:
        demand(False, place, f"it is not JSON: {error}")
    _check_strings(value, place)
    return value


def _check_nesting(text, most, place):
    """Before the parser, which goes as deep as the text: brackets outside strings."""
    depth = 0
    for match in re.finditer(r'"(?:[^"\\]|\\.)*"|[\[{]|[\]}]', text, re.DOTALL):
        token = match.group()
        if token in "[{":
            depth += 1
            if depth > most:
                raise BeyondLimits(place, f"it is nested deeper than {most}")
        elif token in "]}":
            depth -= 1


def _check_strings(value, place):
    """Strings are of Unicode characters: an escape that is half a pair is none."""
    if isinstance(value, str):
        demand(not re.search("[\ud800-\udfff]", value), place, "a string has half a surrogate pair")
    elif isinstance(value, list):
        for item in value:
            _check_strings(item, place)
    elif isinstance(value, dict):
        for key, item in value.items():
            _check_strings(key, place)
            _check_strings(item, place)
