"""Lists what a program or library built from this workspace has in it of others: NOTICE.

notice.py [--check]: writes NOTICE, or says whether it is what it would write.
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ("dsm-tools", "deepshadow-c", "deepshadow-python")
# What crates carry in other languages, which their own licence field does not tell.
BUNDLED = {
    "zstd-sys": "Zstandard (C), BSD-3-Clause, Meta Platforms, Inc. and affiliates",
    "ring": "parts of BoringSSL (C and assembly), ISC, OpenSSL and SSLeay licences, only in builds with feature remote",
}
HEAD = """\
Deep shadow maps: MIT OR Apache-2.0 (LICENSE-MIT, LICENSE-APACHE).

The program, the Python package and the library for C contain the following packages, under the licences that
they state. The texts are in the packages' own archives. Made by tests/packages/notice.py; those with an
asterisk are only in builds with the feature `remote`.

"""


def metadata(*arguments):
    command = ["cargo", "metadata", "--locked", "--format-version", "1", *arguments]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout)


def reached(found):
    """The packages that the programs are linked with, by id: no tests, no build scripts."""
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    open_ids = [package["id"] for package in found["packages"] if package["name"] in PROGRAMS]
    seen = set()
    while open_ids:
        at = open_ids.pop()
        if at in seen:
            continue
        seen.add(at)
        for dependency in nodes[at]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                open_ids.append(dependency["pkg"])
    return seen


def notice():
    by_default, with_all = metadata(), metadata("--all-features")
    usual = reached(by_default)
    every = reached(with_all)
    foreign = [p for p in with_all["packages"] if p["id"] in every and p["source"] is not None]
    lines = []
    for package in sorted(foreign, key=lambda p: (p["name"], p["version"])):
        mark = "" if package["id"] in usual else "*"
        lines.append(f"{package['name']} {package['version']}{mark}: {package['license']}")
        if package["name"] in BUNDLED:
            lines.append(f"    with {BUNDLED[package['name']]}")
    return HEAD + "\n".join(lines) + "\n"


def main():
    path, text = ROOT / "NOTICE", notice()
    if "--check" not in sys.argv[1:]:
        path.write_text(text)
    elif not path.is_file() or path.read_text() != text:
        sys.exit("NOTICE is not what tests/packages/notice.py writes: run it")
    else:
        print(f"NOTICE names {text.count(': ')} packages and what they carry")


if __name__ == "__main__":
    main()
