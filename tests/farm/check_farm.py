#!/usr/bin/env python3
"""Plans of bakes on a farm's own schedulers: Slurm, with everything that goes wrong on a farm, and Open Job Description.

Whatever happened on the way, the maps have the bytes of those that one process bakes, and nothing that is half done is left.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from cluster import Cluster, missing


def run(*command, cwd, fails=None, env=None):
    done = subprocess.run([str(word) for word in command], cwd=cwd, capture_output=True, text=True, timeout=900, check=False, env=env)
    shown = " ".join(map(str, command))
    if fails is None:
        assert done.returncode == 0, f"{shown}: exit code {done.returncode}: {done.stderr.strip()}{done.stdout[-2000:]}"
        return done.stdout
    assert done.returncode == 1, f"{shown}: exit code {done.returncode}, not 1"
    for word in fails:
        assert word in done.stderr, f"{shown}: \"{word}\" is not in: {done.stderr}"
    return done.stderr


def check_leftovers(folder):
    """Finished maps, and a note beside each."""
    maps = folder / "maps"
    for path in maps.rglob("*"):
        if path.is_dir():
            continue
        fine = path.parent == maps and path.suffix == ".dsm" or path.name == "done.json"
        assert fine, f"{path.relative_to(folder)} was left"


def same(one, other):
    assert one.read_bytes() == other.read_bytes(), f"{one.name} has other bytes than {other.name}"


def own_steps(folder):
    """Processes of the program in this folder."""
    found = []
    for process in Path("/proc").iterdir():
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            if os.readlink(process / "cwd") == str(folder) and b"step" in words and b"bake" in words:
                found.append(int(process.name))
        except OSError:
            pass
    return found


class Hairball:
    """16 crops of a hairball, with mip levels."""

    def __init__(self, tools, folder, side):
        self.tools, self.folder, self.side = tools, folder, side
        self.switches = ["--resolution", side, "--samples", 16]
        run(tools, "bake", "builtin:hairball", "-o", "whole.dsm", *self.switches, "--quiet", cwd=folder)
        run(tools, "mip", "whole.dsm", "-o", "mip.dsm", "--quiet", cwd=folder)
        plan = [tools, "plan", "builtin:hairball", "-o", "plan.json", "--crops", 16, "--mip", "--slurm", "submit.sh",
                "--openjd", "job.json", "--trial", 2, "--", *self.switches]
        print(run(*plan, cwd=folder).strip())

    def check(self):
        same(self.folder / "maps" / "hairball.dsm", self.folder / "mip.dsm")
        check_leftovers(self.folder)

    def expect(self):
        """Parts that are missing, doubled or foreign are named."""
        parts = self.folder / "parts"
        parts.mkdir()
        for part in [1, 2, 16]:
            run(self.tools, "bake", "builtin:hairball", "-o", f"parts/{part}.dsm", "--crop", f"{part}/16", *self.switches, "--quiet", cwd=self.folder)
        shutil.copy(parts / "2.dsm", parts / "again.dsm")
        run(self.tools, "bake", "builtin:fur-plane", "-o", "parts/fur.dsm", "--crop", "3/16", *self.switches, "--quiet", cwd=self.folder)
        files = sorted(str(path.relative_to(self.folder)) for path in parts.iterdir())
        run(self.tools, "merge", *files, "-o", "expected.dsm", "--expect", "plan.json", cwd=self.folder, fails=[
            "missing: 3/16", "and 5 more", "doubled: 2/16", "parts/2.dsm and parts/again.dsm", "foreign: parts/fur.dsm is of builtin:fur-plane",
        ])
        run(self.tools, "merge", "parts/1.dsm", "-o", "expected.dsm", cwd=self.folder, fails=["one crop alone"])
        assert not (self.folder / "expected.dsm").exists()
        shutil.rmtree(parts)


def check_slurm(hairball, work):
    """Jobs, a node and the whole run killed in the middle, then the same script again."""
    folder = hairball.folder
    with Cluster(work) as farm:
        environment = dict(farm.environment, DSM_TOOLS=str(hairball.tools))

        def submit():
            print(run("bash", "submit.sh", "--output=/dev/null", cwd=folder, env=environment).strip())

        def parts():
            return len(list((folder / "maps").rglob("[0-9]*.dsm")))

        submit()
        farm.wait("bakes", lambda: own_steps(folder) and parts() >= 2)
        # A job whose process is killed.
        os.kill(own_steps(folder)[0], signal.SIGKILL)
        farm.wait("more bakes", lambda: parts() >= 4)
        # A node that is drained goes on with what it has, and gets no more.
        farm.call("scontrol", "update", "nodename=node1", "state=drain", "reason=check")
        # The other one's daemon dies, and its tasks with it.
        farm.kill_node("node0")
        for pid in own_steps(folder):
            os.kill(pid, signal.SIGKILL)
        time.sleep(1)
        farm.start_node("node0")
        farm.call("scontrol", "update", "nodename=node1", "state=resume")
        farm.wait("bakes after the node came back", lambda: own_steps(folder) or not farm.jobs())
        # Somebody cancels all of it.
        farm.call("scancel", "--full", "-u", os.getuid())
        farm.wait("end", lambda: not farm.jobs(), 60)
        assert not (folder / "maps" / "hairball.dsm").exists(), "all of it was done before it was broken off"
        kept = {path: path.stat().st_mtime_ns for path in (folder / "maps").rglob("[0-9]*.dsm")}
        assert 0 < len(kept) < 16, f"{len(kept)} parts were there when it was broken off"
        run(hairball.tools, "step", "plan.json", "merge", 0, cwd=folder, fails=["missing: "])
        started = time.monotonic()
        submit()

        def untouched():
            return all(not path.exists() or path.stat().st_mtime_ns == time_ns for path, time_ns in kept.items())

        farm.wait("parts", lambda: parts() == 16 or (folder / "maps" / "hairball.dsm").exists(), 600)
        assert untouched(), "a part that was there and sound was baked again"
        farm.wait("end", lambda: not farm.jobs(), 600)
        print(f"slurm: {len(kept)} of 16 parts were kept, the rest took {time.monotonic() - started:.0f} s")
    hairball.check()
    print("slurm: the bytes of one process, nothing left")


SCENE = """\
[light]
eye = {eye}
target = [0, 0, 0]
fov = 40.0
shape = "rectangle"
size = [0.5, 0.5]

[[object]]
mesh = "leaf.####.obj"
opacity = 0.5
"""


class Sequence:
    """8 frames under 2 lights, of a layered kind."""

    def __init__(self, tools, folder):
        self.tools, self.folder = tools, folder
        for frame in range(1, 9):
            shift = 0.1 * frame
            corners = [(-1 + shift, 0, -1), (1, shift, -1), (1, 0, 1 - shift), (-1, 0.3, 1)]
            text = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 3\nf 1 3 4\n"
            (folder / f"leaf.{frame:04}.obj").write_text(text)
        for name, eye in [("key", [1, 5, 1]), ("fill", [-3, 4, 2])]:
            (folder / f"{name}.toml").write_text(SCENE.format(eye=eye))
        self.switches = ["--kind", "fragments", "--resolution", 128, "--tile", 32]
        run(tools, "plan", "key.toml", "fill.toml", "-o", "plan.json", "--frames", "1-8", "--crops", 2, "--openjd", "job.json",
            "--slurm", "submit.sh", "--", *self.switches, cwd=folder)
        plan = json.loads((folder / "plan.json").read_text())
        assert len(plan["maps"]) == 16 and plan["cost"]["bake"]["memory"] > 0

    def check(self):
        for name in ["key", "fill"]:
            for frame in range(1, 9):
                whole = self.folder / "whole.dsm"
                run(self.tools, "bake", f"{name}.toml", "-o", whole, "--frame", frame, *self.switches, "--quiet", cwd=self.folder)
                same(self.folder / "maps" / f"{name}.{frame:04}.dsm", whole)
        check_leftovers(self.folder)


def check_openjd(openjd, tools, folder, steps):
    """Every step of a plan's template, by openjd-cli, and all of it once more."""
    run(openjd, "check", "job.json", cwd=folder)
    for again in [False, True]:
        for step in steps:
            said = run(openjd, "run", "job.json", "--step", step, "-p", f"Program={tools}", cwd=folder)
            assert not again or "there already" in said and ": done" not in said, said


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tools", required=True, type=Path)
    parser.add_argument("--side", type=int, default=2048)
    parser.add_argument("--openjd", type=Path)
    arguments = parser.parse_args()
    tools = arguments.tools.resolve()
    with tempfile.TemporaryDirectory() as work:
        work = Path(work).resolve()
        (work / "hairball").mkdir()
        hairball = Hairball(tools, work / "hairball", arguments.side)
        hairball.expect()
        absent = missing()
        if absent:
            print(f"SKIPPED: Slurm, without {', '.join(absent)}")
        else:
            (work / "farm").mkdir()
            check_slurm(hairball, work / "farm")
        (work / "sequence").mkdir()
        sequence = Sequence(tools, work / "sequence")
        if arguments.openjd is None:
            print("SKIPPED: Open Job Description, without openjd-cli")
            run(tools, "step", "plan.json", cwd=work / "sequence")
        else:
            openjd = arguments.openjd.resolve()
            shutil.rmtree(work / "hairball" / "maps", ignore_errors=True)
            check_openjd(openjd, tools, work / "hairball", ["bake", "merge", "mip", "verify"])
            hairball.check()
            check_openjd(openjd, tools, work / "sequence", ["bake", "merge", "verify"])
        sequence.check()
        print("Open Job Description and a sequence of 8 frames under 2 lights: the bytes of one process")


if __name__ == "__main__":
    main()
