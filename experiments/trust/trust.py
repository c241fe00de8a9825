"""Repeats what can go wrong around files many times over, and writes docs/results/trust.md.

trust.py --tools PROGRAM [--runs N] [--mutations N] [--out PAGE]
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run(arguments, out):
    command = [sys.executable, *map(str, arguments), "--json", str(out)]
    done = subprocess.run(command, cwd=ROOT)
    return done.returncode, json.loads(out.read_text())


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    lines += ["| " + " | ".join(map(str, row)) + " |" for row in rows]
    return "\n".join(lines)


def bold(row):
    """A row's figure, in bold above its limit."""
    figure = str(row["mebibytes"])
    return f"**{figure}**" if row["mebibytes"] > row["limit"] else figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tools", required=True, help="the program")
    parser.add_argument("--runs", type=int, default=40, help="runs of every command and kind")
    parser.add_argument("--mutations", type=int, default=10000, help="changed files for the validator")
    parser.add_argument("--out", default=str(ROOT / "docs" / "results" / "trust.md"))
    arguments = parser.parse_args()
    program = os.path.abspath(arguments.tools)
    here = Path(__file__).parent
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        in_place_code, in_place = run(
            [here / "in_place.py", "--tools", program, "--runs", arguments.runs], folder / "in_place.json")
        memory_code, memory = run([here / "memory.py", "--tools", program], folder / "memory.json")
        validator = subprocess.run(
            [sys.executable, ROOT / "tests/interop/check_validator.py", "--tools", program,
             "--mutations", str(arguments.mutations)], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    commands = [(name, how.get("answered", 0), how.get("refused", 0)) for name, how in in_place["commands"].items()]
    page = f"""# Files under other hands

{platform.machine()}, {os.cpu_count()} processors, {platform.system()}. Made by
`python3 experiments/trust/trust.py --tools PROGRAM`, in an environment with `tests/interop/requirements.txt`.

## Maps changed in place

Every command reads a map while another process writes parts of another map over it, cuts it and restores it:
{in_place["changes"]} changes. A run has to answer as it does for one of the two maps, or to end with one line of
error, status 1 and no file: of {in_place["runs"]} runs {in_place["complaints"]} did anything else.

{table(["command", "answered", "refused"], commands)}

## Memory

What is large only by what a file states, or named many times, costs what it holds. Rows
above what they may take are in bold.

{table(["what", "command", "MiB at the peak", "at most"],
       [(row["what"], f"`{row['command']}`", bold(row), row["limit"]) for row in memory])}

## A validator from the document alone

`tests/interop/dsm_validator` reads files of every kind by nothing but [the format document](../format/dsm-1.md). Files
of every kind were changed and signed again, and its verdict compared with that of `verify`:

```
{validator.stdout.strip()}
```
"""
    Path(arguments.out).write_text(page)
    sys.exit(in_place_code or memory_code or validator.returncode)


if __name__ == "__main__":
    main()
