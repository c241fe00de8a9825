#!/usr/bin/env python3
"""Memory and time of bakes, merges and mip levels against the size of the map: writes docs/results/scale.md.

    python3 experiments/farm/scale.py --tools target/release/dsm-tools --most 8192
"""

import argparse
import json
import os
import platform
import subprocess
import tempfile
import time
from pathlib import Path

# A hairball that covers one pixel in 200 of the map, and fur that covers all of it.
SCENES = {
    "mostly empty": '[light]\neye = [0, 30, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov = 45.0\n[[object]]\nbuiltin = "hairball"\n',
    "full": None,
}
KINDS = {
    "deep": ["--samples", "1"],
    "fragments": ["--coverage", "1"],
    "layers": [],
    "mtsm": [],
}
LIMIT = 1 << 30
# Seconds until a task runs, and bytes a second of a merge: assumptions.
START = 12
RATE = 200e6


def told(tools, folder, *arguments):
    started = time.monotonic()
    done = subprocess.run([tools, *map(str, arguments), "--json", "--quiet"], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return json.loads(done.stdout), time.monotonic() - started


def row(name, report, seconds):
    return f"| {name} | {report['peak_bytes'] / 2**20:.0f} | {seconds:.1f} | {report['bytes'] / 1e6:.1f} |"


def measure(tools, folder, scene, side, kind, switches, threads):
    """Rows of the table of one size and kind, and the most memory of any step."""
    size = ["--kind", kind, "--resolution", side, "--threads", threads, *switches]
    rows, peaks, times = [], [], []

    def add(step, *arguments):
        report, seconds = told(tools, folder, *arguments)
        rows.append(row(f"{side}² | {kind} | {step}", report, seconds))
        times.append((seconds * threads / side**2, report["bytes"] / side**2))
        peaks.append(report["peak_bytes"])

    add("bake", "bake", scene, "-o", "whole.dsm", *size)
    crops = []
    for part in range(1, 5):
        told(tools, folder, "bake", scene, "-o", f"{part}.dsm", "--crop", f"{part}/4", *size)
        crops.append(f"{part}.dsm")
    add("merge of 4", "merge", *crops, "-o", "merged.dsm", "--threads", threads)
    if (folder / "merged.dsm").read_bytes() != (folder / "whole.dsm").read_bytes():
        raise SystemExit(f"{kind} at {side}: the crops are not the whole")
    if kind == "deep":
        add("mip", "mip", "whole.dsm", "-o", "mip.dsm", "--threads", threads)
    for path in folder.glob("*.dsm"):
        path.unlink()
    return rows, max(peaks), times[0]


def paper(work, density):
    """Rows of the table of what is not measured."""
    pixels = 32768**2
    merge = 2 * density * pixels / RATE
    for cores in [1, 16, 64, 256, 1000]:
        bake = START + work * pixels / cores
        share = work * pixels / (cores * (bake + merge))
        yield f"| {cores} | {bake:.0f} | {merge:.0f} | {bake + merge:.0f} | {100 * share:.0f} % |"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tools", required=True, type=Path)
    parser.add_argument("--most", type=int, default=8192, help="width of the largest map")
    parser.add_argument("--most-full", type=int, default=4096, help="width of the largest full map")
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_args()
    tools = arguments.tools.resolve()
    root = Path(__file__).resolve().parents[2]
    parts, peaks = [], []
    work = density = 0.0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name, text in SCENES.items():
            scene = "builtin:fur-plane"
            if text:
                scene = "scene.toml"
                (folder / scene).write_text(text)
            rows, side = [], 2048
            while side <= (arguments.most if text else arguments.most_full):
                for kind, switches in KINDS.items():
                    measured, peak, first = measure(tools, folder, scene, side, kind, switches, arguments.threads)
                    print("\n".join(measured), flush=True)
                    rows += measured
                    peaks.append(peak)
                    if kind == "deep" and text is None:
                        work, density = first
                side *= 2
            parts.append(f"## {name.capitalize()} maps\n\n| map | kind | step | memory, MiB | seconds | file, MB |\n|---|---|---|---:|---:|---:|\n" + "\n".join(rows))
    shared = "on a machine that had other work" if os.getloadavg()[0] > 2 * arguments.threads else "on a machine without other work"
    text = f"""# Memory and time against the size of the map

Made by `python3 experiments/farm/scale.py --tools target/release/dsm-tools --most {arguments.most} --most-full {arguments.most_full} --threads {arguments.threads}`, {shared}
({os.cpu_count()} cores, {platform.machine()}). Memory is the resident memory of the process at its peak, with the scene and the pages of files that are
mapped; seconds are those of the whole process. Each merge was compared with the whole bake, byte for byte.

The most that any step took is {max(peaks) / 2**20:.0f} MiB{', within the 1 GiB that is asked for' if max(peaks) <= LIMIT else ''}. Bakes hold a few tiles a thread and 64 bytes of each other tile; a
merge one stored tile; mip levels a few tiles a thread and one a level. What grows with the map is the directory, 64 bytes a tile in memory, 16 MiB at
32768², and the rasteriser's bins of 16 × 16 pixels.

{chr(10).join(chr(10) + part for part in parts).strip()}

## On paper: a thousand cores

Not measured. Assumed: a deep map of 32768² pixels as full as the largest full one above, whose bake took {work * 1e6:.1f} core seconds and
{density:.2f} MB a million pixels; parts of one size; {START} s until a task runs and has loaded its scene; a file system that gives a merge {RATE / 1e6:.0f} MB/s, each way. Parts do
not need each other, so a bake of N parts on as many cores takes {START} s + W / N, and the merge copies every byte once, on one core.

| cores | bake, s | merge, s | all, s | of what cores could do |
|---:|---:|---:|---:|---:|
{chr(10).join(paper(work, density))}

The merge is what does not divide: beyond some hundred cores a map waits for it. A plan's arrays have the parts of all maps, so that other frames are baked meanwhile; for one
map more cores are of no use. Parts should take ten times as long as a task takes to start, which `plan --time` is for. An object store adds its
latency once a request: a part is written in one, and a merge that reads its parts whole adds as many latencies as parts, 1024 × 50 ms one after the other, less with
several at once.
"""
    (root / "docs" / "results" / "scale.md").write_text(text)


if __name__ == "__main__":
    main()
