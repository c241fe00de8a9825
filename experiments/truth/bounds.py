"""What the program has to reach, and what it is known to reach.

Asked are the bounds of `asked`. Where they are not met yet, `bounds.json` records what is, with some room, so that
nothing gets worse unseen; whatever it does not name has to meet what is asked.
"""

import json
from pathlib import Path

import scenes
import study

RECORD = Path(__file__).with_name("bounds.json")
# The ways in which every scene is checked by each change.
VARIANTS = (scenes.BASE, scenes.SMALL_LIGHT, *(v for v in scenes.VARIANTS if v.name in ("scale 10⁻⁴", "10⁴ off")))
OVER_ALL, OF_A_KIND, MEAN = 0.02, 0.03, 0.003
# A recorded bound is what was reached and this share of it, and this much for the few points of a check.
ROOM, NOISE = 0.15, 0.003
# How far Mitsuba may be off Embree: its masks have no cutoff.
PEERS = 0.015


def asked(row):
    """The bounds of a row: RMSE, and the mean's size or None."""
    if row["ask"] == "peers":
        return PEERS, None
    if row["receivers"] == study.ALL:
        return OVER_ALL, MEAN
    return OF_A_KIND, None


def name(row):
    return " / ".join(row[key] for key in ("scene", "variant", "ask", "kind", "method", "receivers") if row[key])


def excess(row, rmse, mean):
    """What a row has above its bounds, in words."""
    words = []
    if row["rmse"] > rmse:
        words.append(f"RMSE {row['rmse']:.4f} > {rmse:.4f}")
    if mean is not None and abs(row["mean"]) > mean:
        words.append(f"mean {row['mean']:+.4f}, above {mean:.4f}")
    return ", ".join(words)


def counts(row):
    """True of rows that bounds are asked of: the default traced ones, and the peers."""
    return row["default"] or row["ask"] == "peers"


def errors(rows):
    return [row for row in rows if "rmse" in row]


def check(rows):
    """Prints every row above its bound; true if there are none."""
    recorded = json.loads(RECORD.read_text())
    passed = True
    misses = 0
    for row in errors(rows):
        rmse, mean = asked(row)
        if name(row) in recorded:
            rmse, known = recorded[name(row)]
            mean = None if mean is None else known
            misses += 1
        elif not counts(row):
            continue
        if words := excess(row, rmse, mean):
            passed = False
            print(f"FAILED {name(row)}: {words}")
        elif name(row) in recorded and counts(row) and not excess(row, *asked(row)):
            print(f"met by now, its record can go: {name(row)}")
    print(f"{len(rows)} rows, {misses} of them held to what is recorded")
    return passed


def record(rows):
    """Writes what is reached where that is not what is asked, and of all other methods."""
    bounds = {}
    for row in errors(rows):
        if counts(row) and excess(row, *asked(row)) or not counts(row) and row["receivers"] == study.ALL:
            room = [round(abs(row[key]) * (1 + ROOM) + NOISE, 4) for key in ("rmse", "mean")]
            bounds[name(row)] = [max(room[0], asked(row)[0]) if counts(row) else room[0], room[1]]
    lines = [f" {json.dumps(key, ensure_ascii=False)}: {json.dumps(value)}" for key, value in sorted(bounds.items())]
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n")


def report(rows):
    """Prints the rows above what is asked."""
    for row in errors(rows):
        if counts(row) and (words := excess(row, *asked(row))):
            print(f"above what is asked: {name(row)}: {words}")
