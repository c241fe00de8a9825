"""Maps of every kind, made once, and the program that the values are held to."""

from __future__ import annotations

import csv
import io
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import deepshadow as ds

# Small, with an area light; parts of it are coloured.
SCENE = """
[light]
eye = [0.5, 4.0, 0.0]
target = [0.0, 0.0, 0.0]
fov = 50
shape = "rectangle"
size = [0.6, 0.3]

[[object]]
builtin = "{builtin}"
"""


class Tools:
    """The program dsm-tools."""

    def __init__(self, path: str) -> None:
        self.path = path

    def run(self, *arguments: object) -> str:
        words = [self.path, *map(str, arguments)]
        done = subprocess.run(words, check=True, capture_output=True, text=True)
        return done.stdout

    def lookup(self, path: Path, points: np.ndarray, folder: Path, **options: object) -> np.ndarray:
        """The values that `lookup` prints; options by the names of `Map.at`."""
        table = folder / "points.csv"
        lines = ["x,y,z", *(",".join(repr(float(number)) for number in point) for point in points)]
        table.write_text("\n".join(lines) + "\n")
        words: list[object] = []
        for name, value in options.items():
            if isinstance(value, tuple):
                value = "x".join(map(repr, value))
            elif isinstance(value, ds.Map):
                value = value.path
            words.append(f"--{name.replace('_', '-')}={value}")
        rows = list(csv.reader(io.StringIO(self.run("lookup", path, "--points", table, *words))))[1:]
        values = np.array([[np.float32(number) for number in row] for row in rows], np.float32)
        return values[:, 0] if values.shape[1] == 1 else values


@pytest.fixture(scope="session")
def tools() -> Tools:
    path = os.environ.get("DSM_TOOLS")
    if not path:
        pytest.fail("DSM_TOOLS names the program dsm-tools that values are held to")
    return Tools(path)


@pytest.fixture(scope="session")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """A scene file by the number of channels that its maps have."""
    folder = tmp_path_factory.mktemp("scenes")
    made = {}
    for channels, builtin in [(1, "hairball"), (3, "stained-glass")]:
        made[channels] = folder / f"scene{channels}.toml"
        made[channels].write_text(SCENE.format(builtin=builtin))
    return made


@pytest.fixture(scope="session")
def maps(scenes: dict[int, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int], Path]:
    """A map by its kind and its number of channels."""
    folder = tmp_path_factory.mktemp("maps")
    made = {}
    for channels, scene in scenes.items():
        opened = ds.Scene(scene)
        for kind in ds.KINDS:
            path = folder / f"{kind}{channels}.dsm"
            settings: dict[str, object] = {"kind": kind, "resolution": 48}
            if kind == "deep":
                settings |= {"mip": True, "samples": 4}
            if channels == 1:
                settings["channels"] = "mono"
            try:
                report = ds.bake(opened, path, **settings)  # type: ignore[arg-type]
            except ds.SettingError:
                # A kind that has no colours.
                assert channels == 3
                continue
            assert report["hits"] > 0
            # One kind has no colours, of coloured scenes either.
            made[kind, ds.open(path).channels] = path
    return made


@pytest.fixture(scope="session")
def deep_map(maps: dict[tuple[str, int], Path]) -> Path:
    return maps["deep", 1]


def world_points(count: int, seed: int = 1) -> np.ndarray:
    """Points in and around what the scenes show."""
    return np.random.default_rng(seed).uniform(-1.6, 1.6, (count, 3))
