"""Threads, processes, references and memory."""

from __future__ import annotations

import gc
import multiprocessing
import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from conftest import world_points

import deepshadow as ds

Maps = dict[tuple[str, int], Path]


def test_eight_threads_on_one_map(maps: Maps) -> None:
    cache = ds.TileCache(1 << 16)
    points = world_points(2000)
    for kind in ["deep", "mtsm", "fragments"]:
        m = ds.open(maps[kind, 1], cache=cache)
        query = {} if kind == "deep" else {"rays": 2}
        expected = m.at(points, **query)  # type: ignore[arg-type]
        barrier = threading.Barrier(8)

        def ask(number: int) -> bool:
            barrier.wait()
            values = [m.at(points[number:], **query) for _ in range(2)]  # noqa: B023
            if kind == "deep":  # noqa: B023
                return all(np.array_equal(found, expected[number:]) for found in values)  # noqa: B023
            # Rays are seeded by a point's number.
            return all(np.array_equal(found, values[0]) for found in values)

        with ThreadPoolExecutor(8) as pool:
            assert all(pool.map(ask, range(8))), kind
    assert cache.statistics["hits"] + cache.statistics["misses"] > 0


def test_the_lock_is_released(maps: Maps) -> None:
    m, done, counted = ds.open(maps["mtsm", 1]), threading.Event(), 0

    def work() -> None:
        m.at(world_points(20_000), rays=256)
        done.set()

    worker = threading.Thread(target=work)
    worker.start()
    while not done.is_set():
        counted += 1
    worker.join()
    assert counted > 1000, "this thread ran meanwhile"


def resident() -> int:
    """Bytes of memory that the process has."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_opens_leave_nothing(deep_map: Path) -> None:
    point = np.zeros((1, 3))

    def use() -> None:
        m = ds.open(deep_map)
        m.at(point)
        m[20, 20]
        m.attrs  # noqa: B018

    def columns() -> None:
        ds.open(deep_map).columns()

    def refused() -> None:
        with pytest.raises(ds.DeepshadowError):
            ds.open(deep_map).at(point, method="trace")

    path = str(deep_map)
    for work, count in [(use, 10_000), (columns, 1000), (refused, 1000)]:
        for _ in range(200):
            work()
        gc.collect()
        memory, files = resident(), len(os.listdir("/proc/self/fd"))
        references = [sys.getrefcount(thing) for thing in (path, point, ds.Map, None)]
        objects = len(gc.get_objects())
        for _ in range(count):
            work()
        gc.collect()
        assert resident() - memory < 4 << 20, work
        assert len(os.listdir("/proc/self/fd")) == files
        after = [sys.getrefcount(thing) for thing in (path, point, ds.Map, None)]
        assert all(abs(one - other) < 50 for one, other in zip(references, after, strict=True))
        assert abs(len(gc.get_objects()) - objects) < 50


def test_bakes_leave_no_references(tmp_path: Path) -> None:
    class Source:
        def __call__(self, x: object, y: object, t: object) -> tuple[list[int], list[float], float]:
            return [0], [1.0], 1.0

    source, light = Source(), ds.Light([0, 4, 0], [0, 0, 0], up=[0, 0, 1])
    count = sys.getrefcount(source)
    for _ in range(5):
        ds.bake(source, tmp_path / "map.dsm", light=light, resolution=128)  # type: ignore[arg-type]
    gc.collect()
    assert sys.getrefcount(source) == count


def answer(path: Path) -> list[float]:
    values: list[float] = ds.open(path).at(world_points(2000)).tolist()
    return values


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_other_processes(method: str, deep_map: Path) -> None:
    """Also those that fork after the threads of this one have started."""
    expected = answer(deep_map)
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.map_async(answer, [deep_map] * 4).get(timeout=120)
    assert found == [expected] * 4
