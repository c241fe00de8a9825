#!/usr/bin/env python3
"""Keeps the few inputs of a corpus that reach most of what it reaches.

    tests/fuzz/keep.py PROGRAM CORPUS KEPT [--count N] [--largest BYTES]

PROGRAM is a fuzz target's program. Up to N inputs (default 60) of up to BYTES
(default 3100) are taken one by one, each time the one that is on record for
the most edges that are missing, for its size; they replace the contents of
KEPT.
"""

import argparse
import hashlib
import pathlib
import subprocess
import tempfile


def coverage(program, corpus):
    """The edges that each input reaches first, by libFuzzer's own record of a merge."""
    with tempfile.TemporaryDirectory() as folder:
        record = pathlib.Path(folder, "record")
        merged = pathlib.Path(folder, "merged")
        merged.mkdir()
        subprocess.run(
            [program, "-merge=1", f"-merge_control_file={record}", merged, corpus],
            check=True,
            stderr=subprocess.DEVNULL,
        )
        lines = record.read_text().splitlines()
    count = int(lines[0])
    names = lines[2 : 2 + count]
    edges = {}
    for line in lines[2 + count :]:
        kind, index, *values = line.split()
        if kind == "COV":
            edges[pathlib.Path(names[int(index)])] = set(values)
    return edges


def cover(edges, count):
    """A choice that reaches most, greedily."""
    missing = set().union(*edges.values())
    for _ in range(count):
        if not missing:
            return
        best = max(edges, key=lambda path: (len(edges[path] & missing) / (64 + path.stat().st_size), str(path)))
        missing -= edges[best]
        yield best


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("corpus", type=pathlib.Path)
    parser.add_argument("kept", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--largest", type=int, default=3100)
    arguments = parser.parse_args()
    edges = coverage(arguments.program, arguments.corpus)
    small = {path: reached for path, reached in edges.items() if path.stat().st_size <= arguments.largest}
    inputs = [path.read_bytes() for path in cover(small, arguments.count)]
    for path in arguments.kept.iterdir():
        path.unlink()
    for data in inputs:
        (arguments.kept / hashlib.sha1(data).hexdigest()[:12]).write_bytes(data)
    print(f"{len(inputs)} of {len(edges)} inputs, {sum(map(len, inputs))} bytes")


if __name__ == "__main__":
    main()
