"""Decimal numbers, rounded once (section 4)."""

from decimal import Decimal
from fractions import Fraction

import numpy as np

MAX_F32 = float(np.finfo(np.float32).max)
# From here on the nearest f32 would be 2^128: infinity.
OVERFLOW = 2**128 - 2**103


def nearest_f32(text):
    """The f32 nearest to a decimal number, as a float; ties go to the even one, as in binary64."""
    decimal = Decimal(text)
    sign = -1.0 if decimal.is_signed() else 1.0
    if not decimal or decimal.adjusted() < -60:
        return sign * 0.0
    if decimal.adjusted() > 60:
        return sign * float("inf")
    exact = abs(Fraction(decimal))
    if exact >= OVERFLOW:
        return sign * float("inf")
    middle = np.float32(min(float(exact), MAX_F32))
    with np.errstate(over="ignore", under="ignore"):
        beside = (np.nextafter(middle, np.float32(0)), middle, np.nextafter(middle, np.float32(np.inf)))
    best = min(
        (number for number in beside if np.isfinite(number)),
        key=lambda number: (abs(Fraction(float(number)) - exact), int(number.view(np.uint32)) & 1),
    )
    return sign * float(best)
