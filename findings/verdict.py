"""The last lines of each script: what one would guess, what was seen, and whether it is still so."""

import math


def same(seen, recorded, tolerance):
    if isinstance(recorded, (list, tuple)):
        return (
            isinstance(seen, (list, tuple))
            and len(seen) == len(recorded)
            and all(same(a, b, tolerance) for a, b in zip(seen, recorded))
        )
    if isinstance(recorded, float):
        return math.isclose(seen, recorded, rel_tol=tolerance, abs_tol=tolerance)
    return seen == recorded


def verdict(question, guess, seen, recorded, tolerance=1e-4):
    """Prints one case and exits with 1 if what is seen is no longer what was recorded."""
    print(f"question: {question}")
    print(f"guess:    {guess}")
    print(f"seen:     {seen}")
    if not same(seen, recorded, tolerance):
        print(f"CHANGED:  recorded was {recorded}")
        raise SystemExit(1)
