"""What the documents say runs, and the guide's pictures are what it makes."""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
GUIDE = ROOT / "docs/guide/python.md"


def blocks(path: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", path.read_text(), re.MULTILINE | re.DOTALL)


def run(path: Path) -> None:
    found = blocks(path)
    assert found, path
    names: dict[str, object] = {"__name__": "document"}
    for number, block in enumerate(found):
        exec(compile(block, f"{path.name}, block {number}", "exec"), names)


def pixels(path: Path) -> bytes:
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        if data[at + 4 : at + 8] == b"IDAT":
            packed += data[at + 8 : at + 8 + length]
        at += length + 12
    return zlib.decompress(packed)


@pytest.mark.parametrize("path", [ROOT / "README.md", ROOT / "bindings/python/README.md"], ids=str)
def test_recipes_run(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run(path)


def test_the_guide_runs_and_makes_its_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run(GUIDE)
    shown = re.findall(r"\(\.\./images/(python-.*?\.png)\)", GUIDE.read_text())
    assert sorted(shown) == sorted(path.name for path in tmp_path.glob("*.png"))
    for name in shown:
        kept = ROOT / "docs/images" / name
        assert pixels(kept) == pixels(tmp_path / name), f"{name}: bindings/python/guide_pictures.py makes it"
