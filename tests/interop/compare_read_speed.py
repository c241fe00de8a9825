"""Times reading a deep image: OpenImageIO on one thread against this project's reader, turn by turn.

compare_read_speed.py FILE.exr [--rounds N] [--runs N] [--least RATIO]

Exits with 1 where the ratio of the medians stays under RATIO (1.2 unless told).
"""

import argparse
import json
import math
import statistics
import subprocess
import sys
import time
from pathlib import Path

import OpenImageIO as oiio

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ["cargo", "run", "--quiet", "--release", "--locked", "-p", "deep-exr", "--example", "time_read", "--"]


def theirs(path, runs):
    """Median seconds from opening the file to its deep data; the samples read and the sum of their depths."""
    seconds = []
    for _ in range(runs):
        started = time.perf_counter()
        source = oiio.ImageInput.open(path)
        data = source.read_native_deep_image(0, 0)
        seconds.append(time.perf_counter() - started)
        source.close()
    depth = data.Z_channel
    depths = [data.deep_value(p, depth, s) for p in range(data.pixels) for s in range(data.samples(p))]
    return statistics.median(seconds), (len(depths), math.fsum(depths))


def ours(path, runs):
    done = subprocess.run([*EXAMPLE, path, str(runs)], cwd=ROOT, check=True, capture_output=True, text=True)
    told = json.loads(done.stdout)
    return told["seconds"], (told["samples"], told["sum_z"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--rounds", type=int, default=5, help="turns of each reader")
    parser.add_argument("--runs", type=int, default=7, help="readings a turn")
    parser.add_argument("--least", type=float, default=1.2, help="ratio to reach")
    arguments = parser.parse_args()
    path = str(arguments.file.resolve())
    oiio.attribute("threads", 1)
    oiio.attribute("exr_threads", 1)
    ours(path, 1)  # builds the example, warms the file
    theirs(path, 1)
    their_times, our_times = [], []
    for _ in range(arguments.rounds):
        seconds, (samples, depths) = theirs(path, arguments.runs)
        their_times.append(seconds)
        seconds, (our_samples, our_depths) = ours(path, arguments.runs)
        our_times.append(seconds)
        if samples != our_samples or not math.isclose(depths, our_depths, rel_tol=1e-12):
            sys.exit(f"OpenImageIO reads {samples} samples, depths {depths}; here {our_samples}, {our_depths}")
    their_median, our_median = statistics.median(their_times), statistics.median(our_times)
    ratio = their_median / our_median
    print(
        f"{arguments.file.name}, {samples} samples, one thread: OpenImageIO {their_median * 1e3:.1f} ms, "
        f"here {our_median * 1e3:.1f} ms: {ratio:.2f}x as fast"
    )
    if ratio < arguments.least:
        sys.exit(f"under {arguments.least}x")


if __name__ == "__main__":
    main()
