"""Feeds damaged deep OpenEXR files to `convert`: clean refusals, in little time and memory, leaving nothing behind.

check_damaged.py --tools PROGRAM [--data DIR] [--sample FILE]

The files of DIR/damaged broke other readers. From the sample many more are made by changing and cutting bytes.
A file may also be converted, if the official client reads the same light from it.
"""

import argparse
import os
import random
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SECONDS = 2.0
MEBIBYTES = 256
MUTATIONS = 300


class Outcome:
    """Exit status, stderr, seconds and peak resident memory of one run."""

    def __init__(self, command):
        started = time.monotonic()
        with tempfile.TemporaryFile() as stderr:
            child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr)
            self.status, usage = self._wait(child, started)
            stderr.seek(0)
            self.stderr = stderr.read().decode(errors="replace")
        self.seconds = time.monotonic() - started
        # Linux keeps the peak of this process itself across the start of a child: a floor of some MiB.
        self.mebibytes = usage.ru_maxrss / 1024

    @staticmethod
    def _wait(child, started):
        killed = False
        while True:
            pid, status, usage = os.wait4(child.pid, os.WNOHANG)
            if pid:
                child.returncode = os.waitstatus_to_exitcode(status)
                return ("killed" if killed else child.returncode), usage
            if not killed and time.monotonic() - started > 5 * SECONDS:
                child.kill()
                killed = True
            time.sleep(0.002)


def judge(program, source, folder):
    """(complaints, outcome, the map if there is one) of converting one file into an empty folder."""
    out = Path(folder) / "out.dsm"
    outcome = Outcome([program, "convert", str(source), str(out), "--tolerance", "0"])
    left = sorted(os.listdir(folder))
    complaints = []
    if outcome.status not in (0, 1):
        complaints.append(f"exit status {outcome.status}")
    if outcome.status == 1 and not any(line.startswith("error:") for line in outcome.stderr.splitlines()):
        complaints.append("no line starting with error:")
    if "panicked" in outcome.stderr:
        complaints.append("panicked")
    if outcome.seconds > SECONDS:
        complaints.append(f"{outcome.seconds:.1f} s")
    if outcome.mebibytes > MEBIBYTES:
        complaints.append(f"{outcome.mebibytes:.0f} MiB")
    if left != (["out.dsm"] if outcome.status == 0 else []):
        complaints.append(f"left {left}")
    if complaints and outcome.stderr:
        complaints.append(f"stderr {outcome.stderr.strip()!r}")
    return complaints, outcome, out if outcome.status == 0 and out.exists() else None


def converted_truly(program, source, out, folder):
    """Complaints about a map made of a damaged file; the client reads the file in a process of its own."""
    command = [sys.executable, __file__, "--compare", program, str(source), str(out), folder]
    done = subprocess.run(command, capture_output=True, timeout=60, text=True)
    return [] if done.returncode == 0 else [f"converted, but {(done.stdout + done.stderr).strip()[-400:]}"]


def compare(program, source, out, folder):
    import check_lookup
    import deep_truth
    from tool import Failed, Tool

    try:
        part = deep_truth.read_part(source)
        pixel, depth = check_lookup.questions(part)
        asked = pixel, depth, part.transmittance(pixel, depth)
        check_lookup.check_values(Tool(program), part, out, folder, asked, 1e-6)
    except (Failed, RuntimeError, ValueError) as error:
        sys.exit(f"{type(error).__name__}: {error}")


def mutations(sample, seed):
    """Copies of a good file with bytes changed, runs overwritten with alarming numbers, or the end cut off."""
    good = sample.read_bytes()
    chance = random.Random(seed)
    alarming = [struct.pack("<i", n) for n in (-1, 0, 2**31 - 1, -(2**31), 65536, 2**24)]
    alarming += [struct.pack("<q", n) for n in (-1, 2**62, 2**32, 0)]
    # Nine in ten inside the header and the offset table and the first chunks: there lengths and counts live.
    for number in range(MUTATIONS):
        bad = bytearray(good)
        limit = len(bad) if number % 10 == 0 else min(len(bad), 1800)
        kind = number % 3
        if kind == 0:
            for _ in range(chance.randint(1, 4)):
                bad[chance.randrange(limit)] ^= 1 << chance.randrange(8)
        elif kind == 1:
            value = chance.choice(alarming)
            at = chance.randrange(limit - len(value))
            bad[at : at + len(value)] = value
        else:
            del bad[chance.randrange(len(bad)) :]
        yield number, bytes(bad)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tools", required=True, type=Path, help="the program dsm-tools")
    parser.add_argument("--data", type=Path, help="folder of the real deep images, with damaged/ in it")
    parser.add_argument("--sample", type=Path, help="a good image to damage")
    arguments = parser.parse_args()
    program = str(arguments.tools.resolve())

    done = failures = 0
    most_seconds = most_mebibytes = 0.0

    def report(title, complaints, outcome, quiet):
        nonlocal done, failures, most_seconds, most_mebibytes
        done += 1
        failures += bool(complaints)
        most_seconds = max(most_seconds, outcome.seconds)
        most_mebibytes = max(most_mebibytes, outcome.mebibytes)
        if complaints:
            print(f"{title}: FAILED: {'; '.join(complaints)}", flush=True)
        elif not quiet:
            said = outcome.stderr.strip().splitlines()[-1:] or ["converted"]
            print(f"{title}: {said[0]} ({outcome.seconds:.2f} s, {outcome.mebibytes:.0f} MiB)", flush=True)

    if arguments.data:
        sources = sorted((arguments.data / "damaged").iterdir())
        if not sources:
            sys.exit(f"nothing in {arguments.data / 'damaged'}")
        for source in sources:
            with tempfile.TemporaryDirectory() as folder:
                complaints, outcome, out = judge(program, source, folder)
                if out:
                    complaints += converted_truly(program, source, out, folder)
            report(source.name, complaints, outcome, quiet=False)
    if arguments.sample:
        before = done
        converted = 0
        for number, bad in mutations(arguments.sample, seed=7):
            with tempfile.TemporaryDirectory() as around:
                source, folder = Path(around) / "bad.exr", Path(around) / "out"
                source.write_bytes(bad)
                folder.mkdir()
                complaints, outcome, out = judge(program, source, folder)
                if out:
                    converted += 1
                    verified = Outcome([program, "verify", str(out)])
                    if verified.status != 0:
                        complaints.append(f"converted, but verify says {verified.stderr.strip()}")
            report(f"mutation {number}", complaints, outcome, quiet=True)
        print(f"{done - before} mutations of {arguments.sample.name}: {converted} converted and verified, the rest refused")
    print(f"{done - failures} of {done} passed; at most {most_seconds:.2f} s and {most_mebibytes:.0f} MiB")
    if failures or not done:
        sys.exit(1)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--compare"]:
        compare(*sys.argv[2:])
    else:
        main()
