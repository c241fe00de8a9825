"""The stubs say what the module is, and mypy accepts who follows them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")
FOLDER = Path(__file__).resolve().parents[1]

GOOD = """
import numpy as np
import deepshadow as ds

m = ds.open("key.dsm", cache=ds.TileCache(1 << 20))
values = m.at(np.zeros((3, 3)), filter="tent", width=4.0, level="auto", threads=2)
total: float = float(values.sum())
offsets, z, v = m.columns()
offsets.dtype, z[0], v.shape
def hits(x, y, time):  # type: ignore[no-untyped-def]
    return [0], [1.0], 0.5
ds.bake(hits, "map.dsm", light=ds.Light([0, 1, 0], [0, 0, 0]), kind="deep", samples=4)
"""
BAD = """
import deepshadow as ds

m = ds.open(3)
m.at([[0, 0, 0]], filter="round")
m.shine
"""


def mypy(text: str, folder: Path) -> subprocess.CompletedProcess[str]:
    path = folder / "user.py"
    path.write_text(text)
    words = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", folder / "cache", path]
    return subprocess.run(words, capture_output=True, text=True, cwd=folder)


def test_users_are_checked(tmp_path: Path) -> None:
    good = mypy(GOOD, tmp_path)
    assert good.returncode == 0, good.stdout
    bad = mypy(BAD, tmp_path)
    assert bad.stdout.count("error:") == 3, bad.stdout


def test_stubs_are_the_module(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "mypy.stubtest", "deepshadow"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_docstrings_are_there() -> None:
    import deepshadow as ds

    for name in ds.__all__:
        thing = getattr(ds, name)
        if name in ("KINDS", "__version__"):
            continue
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            if not member.startswith("_") and not issubclass(thing, Exception):
                assert value.__doc__, f"{name}.{member}"
