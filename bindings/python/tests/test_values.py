"""The values of every kind and method are the program's, bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Tools, world_points

import deepshadow as ds

Maps = dict[tuple[str, int], Path]

# Options by the names of `dsm-tools lookup`, for kinds that have that method.
CASES: list[tuple[str, dict[str, object]]] = [
    ("deep", {}),
    ("deep", {"method": "filter", "bias": 0.01}),
    ("deep", {"filter": "box", "width": 3.0}),
    ("deep", {"filter": "tent", "width": 4.0, "level": "auto"}),
    ("deep", {"filter": "gaussian", "width": 5.0, "level": 1.5, "bias": -0.02}),
    ("mtsm", {"rays": 16}),
    ("mtsm", {"method": "trace", "rays": 8, "rule": "subtract", "z_threshold": 0.01, "seed": 7}),
    ("mtsm", {"method": "filter", "filter": "tent"}),
    ("mtsm", {"method": "pcf", "rays": 16, "bias": 0.02}),
    ("layers", {"rays": 16, "light_size": (0.25, 0.5)}),
    ("layers", {"method": "pcf", "rays": 9}),
    ("layers", {"method": "filter", "filter": "box", "width": 2.0}),
    ("fragments", {"rays": 16}),
    ("fragments", {"method": "trace", "rays": 9, "far_table": "on", "bias": 0.05, "seed": 3}),
    ("prefiltered", {}),
    ("prefiltered", {"method": "prefilter", "accumulate": "add", "bias": 0.02}),
    ("attenuation", {"filter": "tent", "bias": 0.3}),
    ("mtsm", {"method": "coherence", "rays": 16, "bias": 0.02}),
    ("layers", {"method": "coherence"}),
]


def same(one: np.ndarray, other: np.ndarray) -> bool:
    return one.dtype == other.dtype == np.float32 and np.array_equal(one, other)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize(("kind", "options"), CASES, ids=lambda value: str(value))
def test_world(
    kind: str, options: dict[str, object], channels: int, maps: Maps, tools: Tools, tmp_path: Path
) -> None:
    path, points = maps[kind, channels], world_points(3000)
    expected = tools.lookup(path, points, tmp_path, **options)
    assert 0 < expected.mean() < 1
    values = ds.open(path).at(points, **options)  # type: ignore[arg-type]
    assert values.shape == ((3000,) if channels == 1 else (3000, 3))
    assert same(values, expected)


@pytest.mark.parametrize("channels", [1, 3])
def test_every_kind_in_its_own_way(channels: int, maps: Maps, tools: Tools, tmp_path: Path) -> None:
    """Kinds that there will be, too."""
    points = world_points(300)
    known = [kind for kind, of in maps if of == channels]
    assert set(known) >= {"deep", "mtsm", "layers", "fragments", "prefiltered"}
    for kind in known:
        m = ds.open(maps[kind, channels])
        expected = tools.lookup(m.path, points, tmp_path)  # type: ignore[arg-type]
        assert (m.kind, m.channels) == (kind, channels)
        assert same(m.at(points), expected), kind
        assert same(m.at(points, method=m.default_method), expected), kind
        assert same(m.shadow().at(points), expected), kind


def test_raster(maps: Maps, tools: Tools, tmp_path: Path) -> None:
    points = np.random.default_rng(2).uniform([0, 0, 2.5], [48, 48, 5], (500, 3))
    m = ds.open(maps["deep", 1])
    expected = tools.lookup(maps["deep", 1], points, tmp_path, space="raster", filter="tent")
    assert 0 < expected.mean() < 1
    assert same(m.at(points, space="raster", filter="tent"), expected)


@pytest.mark.parametrize("channels", [1, 3])
def test_hybrid(channels: int, maps: Maps, tools: Tools, tmp_path: Path) -> None:
    m, near = ds.open(maps["prefiltered", channels]), ds.open(maps["fragments", channels])
    points = world_points(300)
    expected = tools.lookup(
        maps["prefiltered", channels], points, tmp_path, method="hybrid", near=near, rays=4
    )
    assert same(m.at(points, method="hybrid", near=near, rays=4), expected)
    with pytest.raises(ds.SettingError, match="needs near"):
        m.at(points, method="hybrid")


def test_rays_through_the_scene(maps: Maps, scenes: dict[int, Path]) -> None:
    scene, points = ds.Scene(scenes[1]), world_points(300)
    truth = scene.shadow(64).at(points)
    found = ds.open(maps["fragments", 1]).at(points, rays=64)
    assert np.abs(truth - found).mean() < 0.1
    hybrid = ds.open(maps["prefiltered", 1]).at(points, method="hybrid", near=scene)
    assert np.abs(truth - hybrid).mean() < 0.15


def test_lights_of_ones_own(maps: Maps) -> None:
    m, points = ds.open(maps["fragments", 1]), world_points(300)
    own = ds.Light([0.5, 4, 0], [0, 0, 0], fov=50, shape="rectangle", size=(0.6, 0.3))
    assert same(m.at(points, light=own, rays=16), m.at(points, rays=16))
    other = ds.Light([0.5, 4, 0], [0, 0, 0], fov=50, shape="disk", radius=0.4)
    assert not same(m.at(points, light=other, rays=16), m.at(points, rays=16))


def test_shapes_and_orders_of_points(deep_map: Path) -> None:
    m, points = ds.open(deep_map), world_points(24)
    expected = m.at(points)
    assert same(m.at(points.reshape(2, 3, 4, 3)), expected.reshape(2, 3, 4))
    assert same(m.at(np.asfortranarray(points)), expected)
    assert same(m.at(points.tolist()), expected)
    assert m.at(points[0]).shape == ()
    assert m.at(np.empty((0, 3))).shape == (0,)
    single = points.astype(np.float32)
    assert same(m.at(single), m.at(single.astype(np.float64)))
    nowhere = np.array([[np.nan, 0, 0], [1e300, 0, 0], [0, 10, 0]])
    assert m.at(nowhere).tolist() == [1, 1, 1]
    for wrong in [points[:, :2], points.T, 3.0]:
        with pytest.raises(ds.SettingError, match="points"):
            m.at(wrong)


def test_threads_change_nothing(maps: Maps) -> None:
    m, points = ds.open(maps["mtsm", 1]), world_points(40_000)
    values = m.at(points, rays=4)
    for threads in [1, 3]:
        assert same(m.at(points, rays=4, threads=threads), values)
    with pytest.raises(ds.SettingError, match="threads"):
        m.at(points, threads=0)


def test_normals_tell_a_bias(maps: Maps) -> None:
    m, points = ds.open(maps["deep", 1]), world_points(5000)
    up = np.broadcast_to([0.0, 1.0, 0.0], points.shape)
    query = {"filter": "tent", "width": 4.0, "bias": "auto"}
    shaded = m.at(points, normals=up, **query)  # type: ignore[arg-type]
    plain = m.at(points, filter="tent", width=4.0)
    assert shaded.mean() > plain.mean() + 1e-4, "less self-shadowing"
    tangents = m.at(points, tangents=up, **query)  # type: ignore[arg-type]
    assert tangents.shape == shaded.shape and not same(tangents, shaded)
    with pytest.raises(ds.SettingError):
        m.at(points, normals=up, tangents=up)
    with pytest.raises(ds.SettingError):
        m.at(points, normals=up[:3])
