"""Columns are what the file holds, are not copied, and outlive the map."""

from __future__ import annotations

import gc
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import Tools

import deepshadow as ds

Maps = dict[tuple[str, int], Path]


@pytest.mark.parametrize("channels", [1, 3])
def test_columns_are_the_files(channels: int, maps: Maps, tools: Tools) -> None:
    m = ds.open(maps["deep", channels])
    for index, level in enumerate(m.levels):
        offsets, z, v = m.columns(index)
        pixels = level.shape[0] * level.shape[1]
        assert (offsets.dtype, z.dtype, v.dtype) == (np.uint32, np.float32, np.float32)
        assert offsets.shape == (pixels + 1,) and (np.diff(offsets.astype(int)) >= 0).all()
        assert offsets[-1] == len(z) == len(v)
        assert v.shape == (len(z),) if channels == 1 else (len(z), 3)
    offsets, z, v = m.columns()
    told = json.loads(tools.run("inspect", m.path, "--pixel=20,31", "--json"))
    pixel = 31 * m.shape[1] + 20
    own = slice(offsets[pixel], offsets[pixel + 1])
    rows = np.column_stack([z[own], v[own]])
    assert np.array_equal(m[31, 20], rows)
    text = json.dumps(told)
    assert all(json.dumps(float(str(number))) in text for number in z[own])
    assert np.array_equal(m[-17, -28], rows)
    assert m[0, 0].shape[1] == 1 + channels


def test_columns_outlive_the_map(deep_map: Path) -> None:
    m = ds.open(deep_map)
    offsets, z, v = m.columns()
    copies = [column.copy() for column in (offsets, z, v)]
    del m
    gc.collect()
    churn = [np.zeros(len(z), np.float32) for _ in range(50)]
    for column, copy in zip((offsets, z, v), copies, strict=True):
        assert not column.flags.owndata and not column.flags.writeable
        assert np.array_equal(column, copy)
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 0
        with pytest.raises(ValueError, match="WRITEABLE"):
            column.flags.writeable = True
    del churn


@pytest.mark.parametrize("channels", [1, 3])
def test_awkward(channels: int, maps: Maps) -> None:
    ak = pytest.importorskip("awkward")
    m = ds.open(maps["deep", channels])
    array = m.to_awkward()
    rows, columns = m.shape
    value = "float32" if channels == 1 else "3 * float32"
    assert str(array.type) == f"{rows} * {columns} * var * {{z: float32, v: {value}}}"
    offsets, z, _ = m.columns()
    assert ak.num(array, axis=2).to_numpy().ravel().tolist() == np.diff(offsets).tolist()
    assert np.array_equal(ak.to_numpy(array[31, 20].z), m[31, 20][:, 0])
    assert np.array_equal(ak.to_numpy(ak.flatten(array.z, axis=None)), z)


@pytest.mark.parametrize("channels", [1, 3])
def test_slices(channels: int, maps: Maps) -> None:
    m = ds.open(maps["deep", channels])
    rows, columns = m.shape
    depth = float(np.median(m.columns()[1]))
    image = m.slice(depth)
    assert image.shape == ((rows, columns) if channels == 1 else (rows, columns, 3))
    y, x = np.mgrid[0:rows, 0:columns]
    points = np.stack([x + 0.5, y + 0.5, np.full_like(x, depth, dtype=float)], axis=-1)
    assert np.array_equal(image, m.at(points, space="raster"))
    assert 0 < image.mean() < 1
    assert np.array_equal(m.slice(-np.inf), np.ones_like(image))
    assert m.slice(depth, 1).shape[:2] == m.levels[1].shape
    with pytest.raises(ds.SettingError):
        m.slice(np.nan)


def test_what_a_map_says(maps: Maps, scenes: dict[int, Path], tmp_path: Path) -> None:
    path = tmp_path / "said.dsm"
    attrs = {"shot": "sq010", "frame": 7, "gain": 0.1, "axis": [1.0, 2.0, 3.0], "raw": ("mine", b"\0\1")}
    ds.bake(ds.Scene(scenes[1]), path, resolution=(32, 16), samples=1, attrs=attrs)
    m = ds.open(path)
    assert (m.kind, m.shape, m.channels) == ("deep", (16, 32), 1)
    assert {name: m.attrs[name] for name in attrs} == attrs | {"raw": b"\0\1"}
    assert m.light == ("rectangle", [pytest.approx(0.6), pytest.approx(0.3)])
    assert m.camera is not None
    to_camera, to_ndc = m.camera["world_to_camera"], m.camera["world_to_ndc"]
    assert to_camera is not None and to_ndc is not None
    assert np.allclose(to_camera @ [0.5, 4.0, 0.0, 1.0], [0, 0, 0, 1])
    ndc = to_ndc @ [0.0, 0.0, 0.0, 1.0]
    assert np.allclose(ndc[:2] / ndc[3], 0.5), "the target is in the middle"
    assert m.levels[0].shape == (16, 32) and m.levels[0].tile_shape == (64, 64)
    assert m.summary() and m.stated_errors()[0]["max"] <= m.levels[0].tolerance
    assert m.verify() == [] and "deep" in repr(m)
    again = pickle.loads(pickle.dumps(m))
    assert again.shape == m.shape


def test_kinds_without_functions(maps: Maps) -> None:
    m = ds.open(maps["fragments", 1])
    with pytest.raises(ds.QueryError, match="fragments") as raised:
        m.columns()
    assert raised.value.file == str(maps["fragments", 1])
    contents = [m.contents(y, x) for y in range(20, 28) for x in range(20, 28)]
    assert any(found["rows"] for found in contents)
    assert all(len(row) == len(found["columns"]) for found in contents for row in found["rows"])


def test_places_that_are_not_there(deep_map: Path) -> None:
    m = ds.open(deep_map)
    for y, x in [(48, 0), (0, 48), (-49, 0)]:
        with pytest.raises(IndexError, match="outside"):
            m[y, x]
    with pytest.raises(IndexError, match="level 99"):
        m.columns(99)
    with pytest.raises(ds.FileError):
        m.contents(99, 0)
