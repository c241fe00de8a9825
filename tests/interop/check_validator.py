"""`verify` and a validator that was written from docs/format/dsm-1.md alone agree on mutated files of every kind.

check_validator.py --tools PROGRAM [--mutations N] [--seed S] [--keep FOLDER]

Golden files and small maps that the program makes are changed, their checksums made right again, and both say whether
the file is valid; before them golden files, of which each breaks one rule that chance breaks seldom. Where the two
differ, one of them is wrong or the document says too little.
"""

import argparse
import collections
import itertools
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import dsm_validator
from dsm_mutations import maps
from dsm_mutations.broken import broken
from dsm_mutations.kinds import mutate
from dsm_mutations.model import Model
from tool import Failed, Tool

FILES_A_CALL = 200
SECONDS_A_CALL = 120
MEBIBYTES = 1024
SHOWN = 40


class Batch:
    """What `verify` says of many files: None for a valid one, else its errors."""

    def __init__(self, program, paths, seconds=SECONDS_A_CALL):
        self.seconds = seconds
        self.said = {}
        self.complaints = []
        self.mebibytes = 0
        self._run(program, paths)

    def _run(self, program, paths):
        trouble, said = self._call(program, paths)
        if trouble is None:
            self.said.update(said)
        elif len(paths) == 1:
            self.said[paths[0]] = trouble
            self.complaints.append(f"verify of {paths[0].name}: {trouble}")
        else:
            # Which of them it is.
            middle = len(paths) // 2
            self._run(program, paths[:middle])
            self._run(program, paths[middle:])

    def _call(self, program, paths):
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            command = [program, "verify", "--json", "--quiet", *map(str, paths)]
            child = subprocess.Popen(command, stdout=out, stderr=err)
            status, usage = _wait(child, self.seconds)
            out.seek(0)
            err.seek(0)
            text, complaint = out.read(), err.read().decode(errors="replace")
        mebibytes = usage.ru_maxrss / 1024
        self.mebibytes = max(self.mebibytes, mebibytes)
        if status not in (0, 1) or "panicked" in complaint:
            return f"exit status {status}: {complaint.strip()[-300:]}", None
        if mebibytes > MEBIBYTES:
            return f"{mebibytes:.0f} MiB", None
        files = json.loads(text)["files"]
        return None, {path: None if told["ok"] else told["errors"] for path, told in zip(paths, files, strict=True)}


def _wait(child, seconds):
    started = time.monotonic()
    status = None
    while True:
        pid, code, usage = os.wait4(child.pid, os.WNOHANG)
        if pid:
            child.returncode = os.waitstatus_to_exitcode(code)
            return status or child.returncode, usage
        if status is None and time.monotonic() - started > seconds:
            child.kill()
            status = f"none in {seconds} s"
        time.sleep(0.002)


def judge(data):
    """What the validator says: None, or the fault. An exception of another type is a fault of the validator's."""
    try:
        return dsm_validator.verdict(data)
    except Exception as error:
        raise Failed(f"the validator fails: {type(error).__name__}: {error}") from error


def agree(fault, errors):
    """Whether both take the file, or neither. Limits are a program's own: what is beyond one may be refused."""
    limited = errors is not None and all("is more than the limit of" in error for error in errors)
    if isinstance(fault, dsm_validator.BeyondLimits) or limited:
        return True
    return (fault is None) == (errors is None)


@dataclass(frozen=True)
class Changed:
    """A file that something was done to."""

    number: str
    source: str
    name: str
    told: str
    data: bytes


def changed_files(sources, mutations, seed):
    """The files in which one rule is broken, and then as many mutations as are wanted."""
    golden = dict(maps.golden())
    for number, (source, said, data) in enumerate(broken(golden)):
        yield Changed(f"broken {number}", source, "one rule broken", said, data)
    models = [(name, Model.read(data)) for name, data in sources]
    chance = random.Random(seed)
    for number in range(mutations):
        source, model = models[number % len(models)]
        data, name, told = mutate(chance, model)
        yield Changed(str(number), source, name, told, data)


class Tally:
    """What both said of all files."""

    def __init__(self, keep):
        self.keep = keep
        self.verdicts = collections.Counter()
        self.by_name = collections.Counter()
        self.differing = []
        self.complaints = []
        self.mebibytes = 0

    def compare(self, program, files, folder):
        """Judges some files twice."""
        paths = {Path(folder) / f"{changed.number.replace(' ', '_')}.dsm": changed for changed in files}
        for path, changed in paths.items():
            path.write_bytes(changed.data)
        batch = Batch(program, list(paths))
        self.mebibytes = max(self.mebibytes, batch.mebibytes)
        self.complaints += batch.complaints
        for path, changed in paths.items():
            self._compare_one(changed, batch.said[path])
            path.unlink()

    def _compare_one(self, changed, errors):
        about = f"{changed.number} {changed.source}; {changed.name}: {changed.told}"
        try:
            fault = judge(changed.data)
        except Failed as error:
            self.complaints.append(f"{about}: {error}")
            return
        limit = isinstance(fault, dsm_validator.BeyondLimits)
        self.verdicts["beyond limits" if limit else "valid" if fault is None else "invalid"] += 1
        self.by_name[changed.name, fault is None] += 1
        if agree(fault, errors):
            return
        program = "valid" if errors is None else errors[0].partition(".dsm: ")[2]
        self.differing.append(f"{about}\n  program:  {program}\n  document: {fault or 'valid'}")
        if self.keep:
            (self.keep / f"{changed.number.replace(' ', '_')}.dsm").write_bytes(changed.data)


def check(tool, sources, mutations, seed, folder, keep):
    tally = Tally(keep)
    files = changed_files(sources, mutations, seed)
    while some := list(itertools.islice(files, FILES_A_CALL)):
        tally.compare(tool.program, some, folder)
    return tally


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tools", required=True, type=Path, help="the program dsm-tools")
    parser.add_argument("--mutations", type=int, default=400, help="how many files in all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="where files are kept of which the two say different things")
    arguments = parser.parse_args()
    tool = Tool(arguments.tools)
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    started = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        try:
            sources = maps.golden() + maps.made(tool, folder)
        except Failed as error:
            sys.exit(f"FAILED: {error}")
        for name, data in sources:
            fault = judge(data)
            if fault:
                sys.exit(f"FAILED: {name}, as it was made, is not what the document says: {fault}")
        random.Random(arguments.seed).shuffle(sources)
        outcome = check(tool, sources, arguments.mutations, arguments.seed, folder, arguments.keep)
    for name in sorted({name for name, _ in outcome.by_name}):
        print(f"{name}: {outcome.by_name[name, True]} valid, {outcome.by_name[name, False]} not")
    for line in (*outcome.complaints[:SHOWN], *outcome.differing[:SHOWN]):
        print(f"FAILED: {line}")
    print(
        f"{arguments.mutations} mutations of {len(sources)} files, seed {arguments.seed}, and one file a rule: "
        + ", ".join(f"{count} {name}" for name, count in sorted(outcome.verdicts.items()))
        + f"; {len(outcome.differing)} verdicts differ, {len(outcome.complaints)} complaints; verify took at most"
        + f" {outcome.mebibytes:.0f} MiB ({time.monotonic() - started:.0f} s)"
    )
    if outcome.differing or outcome.complaints:
        sys.exit(1)


if __name__ == "__main__":
    main()
