"""Bakes of scenes and of Python functions."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from conftest import Tools

import deepshadow as ds

Maps = dict[tuple[str, int], Path]
LIGHT = ds.Light([0, 4, 0], [0, 0, 0], up=[0, 0, 1], fov=60)
Array = npt.NDArray[np.float64]


class Sphere:
    """An opaque sphere of radius 1 around the origin, through any view."""

    def through(self, view: ds.View) -> object:
        def hits(x: Array, y: Array, time: Array) -> tuple[Array, Array, float]:
            origins, directions = view.rays(x, y)
            a = (directions**2).sum(1)
            b = (origins * directions).sum(1)
            inner = b * b - a * ((origins**2).sum(1) - 1)
            sample = np.flatnonzero(inner > 0)
            depth = (-b[sample] - np.sqrt(inner[sample])) / a[sample]
            return sample, depth, 1.0

        return hits


def test_the_programs_bakes_are_the_same(scenes: dict[int, Path], tools: Tools, tmp_path: Path) -> None:
    ours, theirs = tmp_path / "ours.dsm", tmp_path / "theirs.dsm"
    ds.bake(scenes[1], ours, resolution=40, samples=4, filter="tent", tolerance=0.02, seed=3, mip=True)
    words = "--resolution=40 --samples=4 --filter=tent --tolerance=0.02 --seed=3 --mip".split()
    tools.run("bake", scenes[1], "-o", theirs, *words)
    one, other = ds.open(ours), ds.open(theirs)
    assert len(one.levels) == len(other.levels) == 7
    for level in range(7):
        for ours_column, theirs_column in zip(one.columns(level), other.columns(level), strict=True):
            assert np.array_equal(ours_column, theirs_column)
    assert one.attrs == other.attrs


@pytest.mark.parametrize("kind", ["deep", "layers", "fragments", "mtsm", "prefiltered"])
def test_a_python_source_beside_the_truth(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "sphere.dsm"
    area = ds.Light([0, 4, 0], [0, 0, 0], up=[0, 0, 1], fov=60, shape="disk", radius=0.2)
    report = ds.bake(Sphere(), path, light=area, kind=kind, resolution=128)
    assert report["hits"] > 1000
    m = ds.open(path)
    # Below the middle it is dark, beside the sphere's shadow it is lit.
    points = [[0, -1.5, 0], [0.3, -1.2, 0.2], [2.2, -1, 0], [0, 1.5, 0], [0, 3, 0]]
    assert m.at(points) == pytest.approx([0, 0, 1, 1, 1], abs=0.01)


def test_a_function_is_a_source(tmp_path: Path) -> None:
    """A pane of 60 % over x < 0, one unit above the ground; of point lights the raster is the light's."""
    path, threads = tmp_path / "pane.dsm", set()

    def pane(x: Array, y: Array, time: Array) -> tuple[Array, Array, Array]:
        threads.add(threading.get_ident())
        assert x.dtype == y.dtype == np.float64 and time.dtype == np.float32
        assert x.shape == y.shape == time.shape and (0 <= time).all() and (time <= 1).all()
        sample = np.flatnonzero(x < 32)
        return sample, np.full(len(sample), 3.0), np.full(len(sample), 0.6)

    report = ds.bake(pane, path, light=LIGHT, resolution=64, samples=4)
    assert report["samples"] == 64 * 64 * 4 and report["hits"] == report["samples"] // 2
    assert threading.get_ident() not in threads
    m = ds.open(path)
    values = m.at([[10.5, 9, 3.5], [10.5, 9, 2.5], [50.5, 9, 3.5]], space="raster")
    assert values == pytest.approx([0.4, 1, 1], abs=1e-6)


def test_colours_and_media(tmp_path: Path) -> None:
    path = tmp_path / "fog.dsm"

    def glass(x: Array, y: Array, time: Array) -> tuple[Array, Array, Array]:
        sample = np.arange(len(x))
        return sample, np.full(len(x), 2.0), np.tile(np.float32([0.1, 0.5, 0.9]), (len(x), 1))

    ds.bake(glass, path, light=LIGHT, resolution=8, channels="rgb")
    found = ds.open(path).at([[4.5, 4.5, 3.0]], space="raster")
    assert found[0] == pytest.approx([0.9, 0.5, 0.1], abs=1e-6)

    def fog(x: Array, y: Array, time: Array) -> tuple[Array, Array, float, Array]:
        return np.arange(len(x)), np.full(len(x), 2.0), 0.75, np.full(len(x), 4.0)

    ds.bake(fog, path, light=LIGHT, resolution=8, media=True, tolerance=1e-4)
    values = ds.open(path).at([[4.5, 4.5, z] for z in (1.9, 3.0, 4.1)], space="raster")
    assert values == pytest.approx([1, 0.5, 0.25], abs=2e-4), "half of the way takes the root"
    with pytest.raises(TypeError, match="media=True"):
        ds.bake(fog, path, light=LIGHT, resolution=8)


class Oops(RuntimeError):
    pass


def test_exceptions_come_through(tmp_path: Path) -> None:
    path = tmp_path / "none.dsm"

    def raises(x: Array, y: Array, time: Array) -> tuple[Array, Array, float]:
        raise Oops("no hits today")

    with pytest.raises(Oops, match="no hits today") as raised:
        ds.bake(raises, path, light=LIGHT, resolution=128)
    assert any("raises" in str(entry) for entry in raised.traceback)
    assert not path.exists()
    wrong: list[tuple[object, type[Exception], str]] = [
        (lambda x, y, t: None, TypeError, "returns"),
        (lambda x, y, t: ([0.5], [1.0], 1.0), TypeError, "integers"),
        (lambda x, y, t: (np.array([0.5]), [1.0], 1.0), TypeError, "integers"),
        (lambda x, y, t: ([len(x)], [1.0], 1.0), ds.DeepshadowError, "sample"),
        (lambda x, y, t: (np.array([-1]), [1.0], 1.0), ds.DeepshadowError, "sample"),
        (lambda x, y, t: ([2**32], [1.0], 1.0), ds.DeepshadowError, "sample"),
        (lambda x, y, t: ([0, 1], [1.0], 1.0), ds.DeepshadowError, "."),
        (lambda x, y, t: ([0], [1.0], [1.0, 1.0]), ValueError, "opacities"),
        (lambda x, y, t: ([0], [-1.0], 1.0), ds.DeepshadowError, "depth"),
        (lambda x, y, t: ([0], [1.0], 1.5), ds.DeepshadowError, "opacity"),
        (lambda x, y, t: ([0], [np.nan], 0.5), ds.DeepshadowError, "depth"),
    ]
    for number, (function, error, words) in enumerate(wrong):
        with pytest.raises(error, match=words):
            ds.bake(function, path, light=LIGHT, resolution=8)  # type: ignore[arg-type]
        assert not path.exists(), number


def test_settings_are_checked(scenes: dict[int, Path], tmp_path: Path) -> None:
    path = tmp_path / "none.dsm"
    area = ds.Light([0, 4, 0], [0, 0, 0], up=[0, 0, 1], shape="disk", radius=0.3)
    for source, settings, words in [
        (scenes[1], {"kind": "shiny"}, "none of"),
        (scenes[1], {"resets": 2}, "mtsm"),
        (scenes[1], {"tolerance": 2.0}, "tolerance"),
        (scenes[1], {"kind": "prefiltered", "levels": "z"}, "levels"),
        (lambda x, y, t: ([], [], 1.0), {}, "light"),
        (lambda x, y, t: ([], [], 1.0), {"light": area, "kind": "fragments"}, "through"),
        (7, {"light": area}, "source"),
    ]:
        with pytest.raises(ds.SettingError, match=words):
            ds.bake(source, path, **settings)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="'shine'"):
        ds.bake(scenes[1], path, shine=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="samples"):
        ds.bake(scenes[1], path, samples="many")  # type: ignore[arg-type]
    with pytest.raises(ds.SettingError, match="both"):
        ds.Light([0, 1, 0], [0, 0, 0], fov=30, extent=2)
    with pytest.raises(ds.SettingError):
        ds.Light([0, 1, 0], [0, 1, 0])
    assert not path.exists()


def test_prefiltered_maps_of_maps(maps: Maps, tools: Tools, tmp_path: Path) -> None:
    ours, theirs = tmp_path / "ours.dsm", tmp_path / "theirs.dsm"
    ds.bake(ds.open(maps["fragments", 1]), ours, kind="prefiltered", preset="paper")
    tools.run("bake", maps["fragments", 1], "-o", theirs, "--kind=prefiltered", "--preset=paper")
    points = np.random.default_rng(3).uniform(-1.5, 1.5, (500, 3))
    assert np.array_equal(ds.open(ours).at(points), ds.open(theirs).at(points))


def test_progress_is_told_and_may_end_the_work(tmp_path: Path) -> None:
    path, told = tmp_path / "slow.dsm", []

    def slow(x: Array, y: Array, t: Array) -> tuple[list[int], list[float], float]:
        time.sleep(0.03)
        return [0], [1.0], 1.0

    ds.bake(slow, path, light=LIGHT, resolution=256, progress=lambda done, total: told.append((done, total)))
    assert len(told) > 1 and told == sorted(told) and told[-1][0] <= told[-1][1] == 16
    path.unlink()
    with pytest.raises(ds.Cancelled):
        ds.bake(slow, path, light=LIGHT, resolution=512, progress=lambda done, total: done < 4)

    def fails(done: int, total: int) -> None:
        raise Oops("enough")

    with pytest.raises(Oops, match="enough"):
        ds.bake(slow, path, light=LIGHT, resolution=512, progress=fails)
    assert list(tmp_path.iterdir()) == [], "nothing is left"


INTERRUPTED = """
    import sys, time
    import numpy as np
    import deepshadow as ds

    light = ds.Light([0, 4, 0], [0, 0, 0], up=[0, 0, 1])

    def slow(x, y, t):
        print("at work\\n", end="", flush=True)
        time.sleep(0.05)
        return [0], [1.0], 1.0

    try:
        {call}
    except KeyboardInterrupt:
        print("interrupted", flush=True)
"""


@pytest.mark.parametrize(
    "call",
    [
        'ds.bake(slow, sys.argv[1] + "/never.dsm", light=light, resolution=4096, threads=2)',
        'print("at work", flush=True); m = ds.open(sys.argv[2]); '
        "m.at(np.random.default_rng(1).uniform(-1, 1, (4000000, 3)), rays=4096)",
    ],
    ids=["bake", "at"],
)
def test_ctrl_c_ends_the_work(call: str, maps: Maps, tmp_path: Path) -> None:
    words = [sys.executable, "-c", textwrap.dedent(INTERRUPTED).format(call=call), tmp_path, maps["mtsm", 1]]
    child = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "at work\n"
    time.sleep(0.5)
    started = time.monotonic()
    os.kill(child.pid, signal.SIGINT)
    rest, _ = child.communicate(timeout=60)
    assert rest.endswith("interrupted\n") and child.returncode == 0
    assert time.monotonic() - started < 20
    assert list(tmp_path.iterdir()) == []
