"""Runs the program under test, and what its commands promise about their output."""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

# No conversion of these small images takes longer; a hang must not stop the checks.
TIME_LIMIT = 300


class Failed(Exception):
    """A promise of the program was broken; the text says which."""


class Tool:
    def __init__(self, program):
        self.program = str(Path(program).resolve())

    def run(self, *arguments):
        """Exit code, stdout and stderr; a crash or a panic is a failure whatever the caller expects."""
        command = [self.program, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT)
        stdout, stderr = done.stdout.decode(), done.stderr.decode(errors="replace")
        shown = " ".join(command)
        if done.returncode not in (0, 1, 2):
            raise Failed(f"{shown}: exit code {done.returncode}: {stderr.strip()}")
        if "panicked" in stderr:
            raise Failed(f"{shown}: panicked: {stderr.strip()}")
        return done.returncode, stdout, stderr

    def expect(self, *arguments):
        """Stdout of a run that must succeed."""
        code, stdout, stderr = self.run(*arguments)
        if code != 0:
            raise Failed(f"{' '.join(map(str, arguments))}: exit code {code}: {stderr.strip()}")
        return stdout

    def refuse(self, *arguments):
        """The error line of a run that must fail with exit code 1."""
        code, _, stderr = self.run(*arguments)
        lines = [line for line in stderr.splitlines() if line.startswith("error:")]
        if code != 1 or len(lines) != 1:
            raise Failed(f"{' '.join(map(str, arguments))}: exit code {code}, wanted 1 and one error line: {stderr.strip()}")
        return lines[0]

    def json(self, *arguments):
        return json.loads(self.expect(*arguments))

    def offers(self, command, switch):
        """Whether a command's help lists a switch."""
        return switch in self.expect(command, "--help")

    def lookup(self, image, points, folder, *arguments):
        """Values at points (n x 3: x, y, z with z a float32), n x 1 or n x 3."""
        path = Path(folder) / "points.csv"
        write_points(path, points)
        out = self.expect("lookup", image, "--points", path, *arguments)
        head, _, body = out.partition("\n")
        columns = {"v": 1, "r,g,b": 3}.get(head.strip())
        if columns is None:
            raise Failed(f"lookup of {image}: header {head!r}, wanted 'v' or 'r,g,b'")
        values = np.array(body.replace(",", "\n").split(), np.float64)
        if values.size != columns * len(points):
            raise Failed(f"lookup of {image}: {values.size} numbers for {len(points)} points of {columns}")
        return values.reshape(-1, columns)


def write_points(path, points):
    """Nine digits of z name its float32 exactly."""
    x, y, z = (column.tolist() for column in np.asarray(points, np.float64).T)
    with open(path, "w") as file:
        file.write("x,y,z\n")
        file.writelines("%.9g,%.9g,%.9g\n" % point for point in zip(x, y, z))


def image_arguments(description):
    """The command line of a check over images: the program, two folders, and more images."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--tools", required=True, type=Path, help="the program dsm-tools")
    parser.add_argument("--data", type=Path, help="folder of the real deep images")
    parser.add_argument("--generated", type=Path, help="folder written by generate.py")
    parser.add_argument("--sample", type=Path, action="append", default=[], help="one more image")
    return parser.parse_args()


def run_cases(cases):
    """Runs (title, check) pairs, each check with a folder of its own, and prints what they say; exits with 1 if one
    fails or there is none."""
    failures = done = 0
    for title, check in cases:
        started = time.monotonic()
        try:
            with tempfile.TemporaryDirectory() as folder:
                outcome = check(folder)
        except (Failed, KeyError, ValueError, RuntimeError) as error:
            failures += 1
            outcome = f"FAILED: {type(error).__name__}: {error}"
        done += 1
        print(f"{title}: {outcome} ({time.monotonic() - started:.1f} s)", flush=True)
    print(f"{done - failures} of {done} passed")
    if failures or not done:
        sys.exit(1)
