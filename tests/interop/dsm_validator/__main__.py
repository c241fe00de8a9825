"""python -m dsm_validator FILE…: says of each file whether it is valid, and where it is not; exits with 1 then."""

import sys
from pathlib import Path

from . import verdict


def main(paths):
    faults = 0
    for path in paths:
        fault = verdict(Path(path).read_bytes())
        faults += fault is not None
        print(f"{path}: {fault or 'valid'}")
    return 1 if faults or not paths else 0


sys.exit(main(sys.argv[1:]))
