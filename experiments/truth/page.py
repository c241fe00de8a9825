"""docs/results/truth.md, from the rows of a run."""

import bounds
import scenes
import study
from receivers import KINDS, LIFT

HEAD = """# Soft shadows against other tracers

Shadow factors that the program gives by default, beside those of tracers that have nothing to do with it: Embree
3.13, all hits of every shadow ray, for surfaces and strands, and Mitsuba 3.9 (`volpath`) where there are media. Maps are
baked (`bake --kind …`) and asked (`lookup`) without any other switch: 512 × 512 pixels, of fragments 1024 × 1024 where
strands are not wider than half a pixel of those, and 256 rays a point.

Made by `python experiments/truth/truth.py --tools target/release/dsm-tools --page docs/results/truth.md --json
docs/results/truth.json`; see [experiments/truth](../../experiments/truth/README.md). All rows are in
[truth.json](truth.json). By `{version}`{later}.

Receivers are drawn from the geometry itself, {count} of a kind: on the *ground*; beside surfaces by the cosine between
the light's centre and the side they are on, above 0.2 (*lit side*), below −0.2 (*turned away*) or between (*grazing*);
on the middle lines of *strands*; and *in media*. They stand 2⁻¹² of the scene's radius ({lift:.1e}, less than a
tenth of a map's pixel) off their surface, so that the side is known. The truth's rays start there;
those of a point on a strand pass over its own segment and the two beside it. Kinds count alike in *all*.

Numbers are RMSE over receivers and channels, with the tracers' own noise, known from two halves of their rays, taken
off; in brackets the mean difference, too light above 0. Asked are at most {over_all} over all, {kind} of a kind, and a
mean within {mean}: what is above is **bold**. {met} of the {of} numbers of maps traced by default (fragments)
are within them.
"""


def number(row, mean=False):
    text = f"{row['rmse']:.4f}"
    if row["rmse"] > bounds.asked(row)[0]:
        text = f"**{text}**"
    if mean:
        own = f"{row['mean']:+.4f}"
        limit = bounds.asked(row)[1]
        text += f" ({own})" if limit is None or abs(row["mean"]) <= limit else f" (**{own}**)"
    return text


def table(heads, lines):
    rows = ["| " + " | ".join(heads) + " |", "| --- " + "| ---: " * (len(heads) - 1) + "|"]
    rows += ["| " + " | ".join(line) + " |" for line in lines]
    return "\n".join(rows) + "\n"


class Rows:
    """The rows, found by what they are."""

    def __init__(self, rows):
        self.rows = rows

    def only(self, **wanted):
        return [row for row in self.rows if all(row[key] == value for key, value in wanted.items())]

    def cell(self, mean=False, **wanted):
        found = self.only(**wanted)
        return number(found[0], mean) if found else "–"

    def names(self):
        return list(dict.fromkeys(row["scene"] for row in self.rows))


def by_kind(rows):
    heads = ["scene", "all", *KINDS]
    lines = []
    for name in rows.names():
        wanted = {"scene": name, "variant": scenes.BASE.name, "ask": "lookup", "default": True}
        cells = [rows.cell(True, receivers=kind, **wanted) for kind in (study.ALL, *KINDS)]
        lines.append([f"*{name}*", *cells])
    return table(heads, lines)


def by_variant(rows):
    names = [variant.name for variant in scenes.VARIANTS]
    lines = []
    for name in rows.names():
        wanted = {"scene": name, "ask": "lookup", "default": True, "receivers": study.ALL}
        lines.append([f"*{name}*", *(rows.cell(variant=variant, **wanted) for variant in names)])
    return table(["scene", *names], lines)


def by_method(rows, variant):
    heads = [f"{kind}, {method}" for kind, method in study.METHODS]
    lines = []
    for name in rows.names():
        wanted = {"scene": name, "variant": variant, "ask": "lookup", "receivers": study.ALL}
        cells = [rows.cell(kind=kind, method=method, **wanted) for kind, method in study.METHODS]
        lines.append([f"*{name}*", *cells])
    return table(["scene", *heads], lines)


def pictures(rows, variant):
    lines = []
    for name in rows.names():
        wanted = {"scene": name, "variant": variant, "ask": "render"}
        if found := rows.only(**wanted):
            cells = [rows.cell(True, method=method, **wanted) for method in study.PICTURES]
            lines.append([f"*{name}*", *cells, f"{found[0]['noise']:.4f}"])
    return table(["scene", *(f"`{method}`" for method in study.PICTURES), "noise of the truth"], lines)


def peers(rows):
    lines = [
        [f"*{row['scene']}*", f"{row['rmse']:.4f}", f"{row['mean']:+.4f}", f"{row['noise']:.4f}"]
        for row in rows.only(ask="peers")
    ]
    return table(["scene", "RMSE", "mean", "noise of a receiver"], lines)


def speeds(rows):
    lines = []
    for name in rows.names():
        found = {row["kind"]: row for row in rows.only(scene=name, ask="speed")}
        embree = found.pop("embree", None)
        for kind, own in found.items():
            cells = [f"*{name}*", kind, f"{own['rate']:.1f}", f"{own['built']:.1f}"]
            if embree:
                ratio = own["rate"] / embree["rate"]
                cells += [f"{embree['rate']:.1f}", f"{embree['built']:.2f}", f"{ratio:.1f}"]
            lines.append(cells + ["–"] * (7 - len(cells)))
    heads = ["scene", "map", "million rays a second", "baked in s", "Embree", "built in s", "ratio"]
    return table(heads, lines)


def later(document):
    """Which scenes another version of the program was measured on."""
    versions = {}
    for name, version in document.get("later", {}).items():
        versions.setdefault(version, []).append(f"*{name}*")
    return "".join(f", {' and '.join(names)} by `{version}`" for version, names in versions.items())


def page(document, described):
    rows = Rows(document["rows"])
    asked = [row for row in rows.rows if row["default"]]
    met = sum(not bounds.excess(row, *bounds.asked(row)) for row in asked)
    parts = [
        HEAD.format(
            version=document["program"], later=later(document), count=max(row["count"] for row in rows.only(receivers="ground")), lift=LIFT,
            over_all=bounds.OVER_ALL, kind=bounds.OF_A_KIND, mean=bounds.MEAN, met=met, of=len(asked),
        ),
        "## The scenes\n",
        "".join(f"- *{scene.name}*: {scene.what}\n" for scene in described if scene.name in rows.names()),
        "Each stands on a ground and is about 2 high; a square light, 1 wide, stands 5.7 above and to the side.\n",
        "## Traced by default, by kind of receiver\n",
        by_kind(rows),
        "## The same, over all, in other lights, sizes and places\n",
        by_variant(rows),
        "A scene's place and size are those of its file: `transform`, light and points are moved and scaled together.\n",
        "## Every kind of map and method, over all\n",
        "*filter* answers the light of a point, *pcf* one of its size. The light as it is:\n",
        by_method(rows, scenes.BASE.name),
        "The light × 0.1. `lookup` knows nothing of what a point lies on, and its filters take no bias of their own:\n"
        "most of their error is surfaces that shade themselves. Pictures, below, have the automatic bias.\n",
        by_method(rows, scenes.SMALL_LIGHT.name),
        "## Pictures\n",
        "`render --factor` at 96 × 72 pixels, by every method, two seeds, whose noise is taken off too:\n",
        pictures(rows, scenes.BASE.name),
        "The light × 0.1:\n",
        pictures(rows, scenes.SMALL_LIGHT.name),
        "## Rays a second\n",
        "Of the same receivers, all threads, single rays of Embree with a filter function; the seconds of a bake are\n"
        "those of the whole command, with the scene read. While other work ran on the machine: ratios are rough.\n",
        speeds(rows),
        "## The tracers against each other\n",
        "Mitsuba against Embree on the same receivers, where Mitsuba has what a scene has (no flat ribbons, no coloured\n"
        "masks, no cutoff: masks are laid out up to 8 times finer instead). The noise of both is taken off.\n",
        peers(rows),
    ]  # fmt: skip
    return "\n".join(parts)
