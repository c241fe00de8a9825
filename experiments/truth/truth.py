"""Soft shadows of the program against tracers that have nothing to do with it.

truth.py --tools PROGRAM [--small [--record]] [--json OUT.json] [--page OUT.md] [--rows ROWS.json] [--scenes NAME,…]
         [--keep ROWS.json]

Without --small: every scene in every way, some 10 minutes on two cores, which makes docs/results/truth.md. With it: the
scenes that are generated, fewer points, in less than two minutes; exit code 1 if a bound is passed.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import bounds
import embree
import page
import scenes
import study
from program import Failed, Program


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tools", required=True, help="the program, dsm-tools")
    parser.add_argument("--small", action="store_true", help="the generated scenes, few points, against the bounds")
    parser.add_argument("--record", action="store_true", help="with --small: write what is reached as bounds")
    parser.add_argument("--json", help="write all rows")
    parser.add_argument("--page", help="write the tables")
    parser.add_argument("--rows", help="take the rows of an earlier --json and measure nothing")
    parser.add_argument("--scenes", help="only these, by name, separated by commas")
    parser.add_argument("--keep", help="with --scenes: the rows of all others, from an earlier --json")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    return parser.parse_args()


def every_scene(options):
    found = list(scenes.generated())
    if not options.small:
        if scenes.DATA.is_dir():
            found += scenes.real()
        else:
            print(f"SKIPPED: the scenes of downloaded models, {scenes.DATA} is not there")
    return found


def chosen_scenes(options):
    found = every_scene(options)
    if options.scenes:
        names = options.scenes.split(",")
        unknown = set(names) - {scene.name for scene in found}
        if unknown:
            raise Failed(f"no scene {', '.join(sorted(unknown))}; there are: {', '.join(s.name for s in found)}")
        found = [scene for scene in found if scene.name in names]
    return found


def measure(options, program, library):
    effort = study.SMALL if options.small else study.FULL
    measured = study.Study(program, library, effort, options.threads, lambda text: print(text, flush=True))
    rows = []
    for scene in chosen_scenes(options):
        if options.small:
            rows += measured.scene(scene, bounds.VARIANTS, (scenes.BASE,), picture=False, check=scene.name == "tree")
        else:
            every = (scenes.BASE, scenes.SMALL_LIGHT)
            rows += measured.scene(scene, scenes.VARIANTS, every, picture=True, check=True)
    return rows


def write(path, document):
    """All rows as lists of values, one a line, under the names of their columns."""
    rows = document["rows"]
    columns = list(dict.fromkeys(key for row in rows for key in row))
    head = json.dumps({**document, "columns": columns, "rows": None}, ensure_ascii=False)
    lines = ",\n".join(json.dumps([row.get(key) for key in columns], ensure_ascii=False) for row in rows)
    Path(path).write_text(head.replace('"rows": null', f'"rows": [\n{lines}\n]') + "\n")


def read(path):
    document = json.loads(Path(path).read_text())
    columns = document.pop("columns")
    lines = [dict(zip(columns, line, strict=True)) for line in document["rows"]]
    document["rows"] = [{key: value for key, value in line.items() if value is not None} for line in lines]
    return document


def run(options):
    start = time.monotonic()
    program = Program(options.tools)
    with tempfile.TemporaryDirectory() as folder:
        rows = measure(options, program, embree.build(folder))
    return {"program": program.version(), "seconds": round(time.monotonic() - start), "rows": rows}


def merged(kept, document):
    """Rows of an earlier run, with those of the scenes that were measured again in their place."""
    again = {}
    for row in document["rows"]:
        again.setdefault(row["scene"], []).append(row)
    names = dict.fromkeys(row["scene"] for row in kept["rows"] + document["rows"])
    rows = [row for name in names for row in again.get(name, [r for r in kept["rows"] if r["scene"] == name])]
    later = {**kept.get("later", {}), **{name: document["program"] for name in again}}
    return {**kept, "later": later, "rows": rows}


def main():
    options = arguments()
    if options.rows:
        document = read(options.rows)
    else:
        document = run(options)
        if options.keep:
            document = merged(read(options.keep), document)
    rows = document["rows"]
    if options.json:
        write(options.json, document)
    if options.page:
        Path(options.page).write_text(page.page(document, every_scene(options)))
    print(f"{len(rows)} rows in {document['seconds']} s")
    if options.small and options.record:
        bounds.record(rows)
        return 0
    if options.small:
        return 0 if bounds.check(rows) else 1
    bounds.report(rows)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Failed, embree.NotBuilt) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
