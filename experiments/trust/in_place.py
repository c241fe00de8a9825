"""Runs every command on maps that somebody else changes, cuts and restores in place meanwhile.

in_place.py --tools PROGRAM [--runs N] [--seed S] [--json OUT]

A run may answer as it does for one of the two maps that the file is written over with, or end with status 1, a line
that starts with "error:" and nothing left behind. Everything else is a complaint: a panic, a signal, a partial file,
an answer that is of neither map.
"""

import argparse
import collections
import json
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

SECONDS = 60
RESOLUTION = 96

# What is baked: two seeds of each, of the same size, so that one can be written over the other.
KINDS = {
    "deep": ["--samples", "4"],
    "deep-plain": ["--samples", "4", "--block", "none"],
    "deep-quantized": ["--samples", "4", "--codec", "quantized"],
    "deep-pyramid": ["--samples", "4", "--block", "none", "--mip"],
    "fragments": ["--kind", "fragments", "--block", "none"],
    "layers": ["--kind", "layers"],
    "mtsm": ["--kind", "mtsm"],
    "prefiltered": ["--kind", "prefiltered"],
}

KEPT = {"a.dsm", "b.dsm", "live.dsm", "points.csv"}
TRACED = ("fragments", "layers", "mtsm")


def commands(kind, map_path, folder):
    """(name, arguments, files it writes) of every command that reads a map of this kind."""
    out = folder / "out"
    points = folder / "points.csv"
    found = [
        ("inspect", ["inspect", map_path, "--json"], []),
        ("inspect --pixel", ["inspect", map_path, "--json", "--pixel", "40,40"], []),
        ("verify", ["verify", map_path], []),
        ("lookup", ["lookup", map_path, "--points", points, *(["--rays", "4"] if kind in TRACED else [])], []),
    ]
    if kind.startswith("deep"):
        found += [
            ("diff", ["diff", map_path, folder / "a.dsm", "--json"], []),
            ("slice", ["inspect", map_path, "--slice", "3.5", "--image", out.with_suffix(".png")], ["out.png"]),
            ("convert", ["convert", map_path, out.with_suffix(".dsm"), "--tolerance", "0"], ["out.dsm"]),
            ("convert to EXR", ["convert", map_path, out.with_suffix(".exr")], ["out.exr"]),
        ]
    if kind in ("deep", "deep-plain", "deep-quantized"):
        found += [
            ("mip", ["mip", map_path, "-o", out.with_suffix(".dsm")], ["out.dsm"]),
            ("merge", ["merge", map_path, folder / "a.dsm", "-o", out.with_suffix(".dsm")], ["out.dsm"]),
        ]
    return found


class Run:
    """One run of the program: its status, output and what it left."""

    def __init__(self, program, arguments, folder, writes):
        for name in set(os.listdir(folder)) - KEPT:
            (folder / name).unlink()
        command = [program, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, timeout=SECONDS, cwd=folder)
        self.status, self.stdout = done.returncode, done.stdout
        self.stderr = done.stderr.decode(errors="replace")
        self.files = {name: (folder / name).read_bytes() for name in writes if (folder / name).exists()}
        self.left = sorted(set(os.listdir(folder)) - KEPT - set(writes))

    def answer(self):
        return self.stdout, tuple(sorted(self.files.items()))

    def complaint(self, right):
        """What is wrong with this run, if anything; `right` are the answers it may give."""
        if self.left:
            return f"left {self.left}"
        if self.status == 0:
            return None if self.answer() in right else "an answer of neither map, with status 0"
        if self.status != 1 or "panicked" in self.stderr:
            return f"status {self.status}: {self.stderr[-300:]}"
        if not any(line.startswith("error:") for line in self.stderr.splitlines()):
            return f"no line of error: {self.stderr[-300:]!r}"
        return f"left {sorted(self.files)} beside an error" if self.files else None


class Writer(threading.Thread):
    """Changes a file in place, over and over: parts of another map, cuts, whole maps; restored in between."""

    def __init__(self, path, contents, seed):
        super().__init__(daemon=True)
        self.path, self.contents, self.random = path, contents, random.Random(seed)
        self.changes, self.ended = 0, threading.Event()

    def run(self):
        with open(self.path, "r+b", buffering=0) as file:
            while not self.ended.is_set():
                self._change(file)
                self.changes += 1
                # As often whole as not, so that runs get beyond the start.
                time.sleep(self.random.choice([0, 0.001, 0.003, 0.01]))

    def _change(self, file):
        one, other = self.random.sample(self.contents, 2)
        kind = self.random.randrange(4)
        if kind == 0:
            start = self.random.randrange(len(other))
            os.pwrite(file.fileno(), other[start : start + self.random.randrange(1, 1 << 14)], start)
        elif kind == 1:
            file.truncate(self.random.randrange(len(one)))
        elif kind == 2:
            os.pwrite(file.fileno(), one, 0)
            file.truncate(len(one))
        else:
            file.truncate(0)
        time.sleep(self.random.choice([0, 0.001]))
        if kind != 2 or self.random.random() < 0.5:
            os.pwrite(file.fileno(), one, 0)
            file.truncate(len(one))


def bake(program, kind, folder):
    scene = '[[object]]\nbuiltin = "foliage"\n'
    scene += '[light]\neye = [2, 5, 2]\ntarget = [0, 0.5, 0]\nfov = 40.0\nshape = "rectangle"\nsize = [0.5, 0.5]\n'
    (folder / "scene.toml").write_text(scene)
    for name, seed in (("a", 1), ("b", 2)):
        command = [program, "bake", "scene.toml", "-o", f"{name}.dsm", "--seed", str(seed), "--quiet"]
        command += ["--resolution", str(RESOLUTION), "--tile", "32", *KINDS[kind]]
        if name == "b":
            # Another map, not only another seed: kinds without chance differ too.
            text = scene.replace("\n[light]", "\ntransform = { translate = [0.1, 0, 0.05] }\n[light]", 1)
            (folder / "scene.toml").write_text(text)
        subprocess.run(command, cwd=folder, check=True)
    (folder / "scene.toml").unlink()
    rows = [f"{x / 8 - 1},{y / 8},{z / 4 - 0.5}" for x in range(16) for y in range(8) for z in range(4)]
    (folder / "points.csv").write_text("x,y,z\n" + "\n".join(rows) + "\n")


def attack(program, kind, runs, seed):
    """Counts by command and outcome, complaints, changes made."""
    counts, complaints = collections.Counter(), []
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        bake(program, kind, folder)
        contents = [(folder / name).read_bytes() for name in ("a.dsm", "b.dsm")]
        live = folder / "live.dsm"
        right = {}
        for index, content in enumerate(contents):
            live.write_bytes(content)
            for name, arguments, writes in commands(kind, live, folder):
                found = Run(program, arguments, folder, writes)
                if found.status != 0:
                    raise SystemExit(f"{kind}, {name}: {found.stderr}")
                right.setdefault(name, set()).add(found.answer())
        live.write_bytes(contents[0])
        writer = Writer(live, contents, seed)
        writer.start()
        for _ in range(runs):
            for name, arguments, writes in commands(kind, live, folder):
                found = Run(program, arguments, folder, writes)
                counts[name, "answered" if found.status == 0 else "refused"] += 1
                complaint = found.complaint(right[name])
                if complaint:
                    complaints.append(f"{kind}, {name}: {complaint}")
        writer.ended.set()
        writer.join()
        return counts, complaints, writer.changes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tools", required=True, help="the program")
    parser.add_argument("--runs", type=int, default=5, help="runs of every command and kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", help="where to write the counts")
    arguments = parser.parse_args()
    program = os.path.abspath(arguments.tools)
    total, complaints, changes = collections.Counter(), [], 0
    for number, kind in enumerate(KINDS):
        counts, found, made = attack(program, kind, arguments.runs, arguments.seed * 100 + number)
        total += counts
        complaints += found
        changes += made
    runs, answered = sum(total.values()), sum(n for (_, how), n in total.items() if how == "answered")
    print(f"{runs} runs, {changes} changes in place: {answered} answered, {runs - answered} refused, "
          f"{len(complaints)} complaints")
    for complaint in complaints[:20]:
        print(f"  {complaint}")
    if arguments.json:
        rows = {}
        for (name, how), count in sorted(total.items()):
            rows.setdefault(name, {})[how] = count
        Path(arguments.json).write_text(json.dumps(
            {"runs": runs, "changes": changes, "complaints": len(complaints), "commands": rows}, indent=1) + "\n")
    # Runs that all answer or all refuse have not been attacked.
    sys.exit(1 if complaints or answered in (0, runs) else 0)


if __name__ == "__main__":
    main()
