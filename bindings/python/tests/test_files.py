"""Files in and out: conversions, merges, comparisons, checks; errors with file and place."""

from __future__ import annotations

import json
import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import Tools

import deepshadow as ds

Maps = dict[tuple[str, int], Path]


def test_convert_and_back(deep_map: Path, tools: Tools, tmp_path: Path) -> None:
    small, image, again = (tmp_path / name for name in ("small.dsm", "image.exr", "again.dsm"))
    ds.convert(deep_map, small, tolerance=0.01, codec="quantized")
    tools.run("convert", deep_map, tmp_path / "theirs.dsm", "--tolerance=0.01", "--codec=quantized")
    assert small.read_bytes() == (tmp_path / "theirs.dsm").read_bytes()
    told = ds.convert(deep_map, image, exr_type="float", exr_compression="rle", exr_layout="tiled", tile=32)
    assert told["samples"] > 0 and told["error"] < 1e-4
    report = ds.convert(image, again)
    assert report["samples"] == told["samples"] and isinstance(report["notes"], list)
    difference = ds.diff(deep_map, again)
    assert 0 < difference["max"] < 1e-4 and difference["worst"].keys() == {"level", "y", "x", "z", "channel"}
    assert difference["max"] == json.loads(tools.run("diff", deep_map, again, "--json"))["max"]
    assert ds.diff(deep_map, deep_map) == {"max": 0, "mean": 0, "worst": None}
    for wrong in [{"tile": 32}, {"exr_layout": "round"}]:
        with pytest.raises(ds.SettingError):
            ds.convert(deep_map, image, **wrong)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="codec"):
        ds.convert(deep_map, image, codec="exact")


def test_crops_and_products(scenes: dict[int, Path], tmp_path: Path) -> None:
    whole, left, right, merged = (tmp_path / f"{name}.dsm" for name in ("whole", "left", "right", "merged"))
    scene = ds.Scene(scenes[1])
    settings = {"resolution": 32, "tile": 16, "samples": 1}
    ds.bake(scene, whole, **settings)  # type: ignore[arg-type]
    ds.bake(scene, left, crop=(0, 0, 16, 32), **settings)  # type: ignore[arg-type]
    ds.bake(scene, right, crop=(16, 0, 32, 32), **settings)  # type: ignore[arg-type]
    assert ds.merge([left, right], merged) == "crops"
    assert merged.read_bytes() == whole.read_bytes()
    assert ds.merge([whole, whole], merged, tolerance=0.001) == "product"
    one, two = ds.open(whole).slice(np.inf), ds.open(merged).slice(np.inf)
    assert np.abs(one * one - two).max() <= 0.001
    with pytest.raises(ds.SettingError):
        ds.merge([whole, left], merged)


def test_mip_levels(deep_map: Path, tools: Tools, tmp_path: Path) -> None:
    ours, theirs = tmp_path / "ours.dsm", tmp_path / "theirs.dsm"
    ds.mip(deep_map, ours, levels=3, tolerance_scale=0.25)
    tools.run("mip", deep_map, "-o", theirs, "--levels=3", "--tolerance-scale=0.25")
    assert ours.read_bytes() == theirs.read_bytes()
    assert [level.shape for level in ds.open(ours).levels] == [(48, 48), (24, 24), (12, 12)]
    with pytest.raises(ds.SettingError):
        ds.mip(deep_map, ours, tolerance_scale=0)


def test_verify_tells_what_is_wrong(deep_map: Path, tmp_path: Path) -> None:
    assert ds.verify(deep_map) == [] == ds.verify(deep_map, against=deep_map)
    other = tmp_path / "other.dsm"
    ds.bake("builtin:spinning-sphere", other, resolution=48)
    assert any("off by" in line for line in ds.verify(deep_map, against=other))
    data = bytearray(deep_map.read_bytes())
    data[len(data) // 3] ^= 0x10
    broken = tmp_path / "broken.dsm"
    broken.write_bytes(data)
    errors = ds.verify(broken)
    assert errors and all(str(broken) in line or "checksum" in line for line in errors)


def test_errors_have_file_and_place(deep_map: Path, tmp_path: Path) -> None:
    missing = tmp_path / "missing.dsm"
    with pytest.raises(ds.FileError, match="No such file") as raised:
        ds.open(missing)
    assert raised.value.file == str(missing) and raised.value.place is None
    again = pickle.loads(pickle.dumps(raised.value))
    assert (type(again), str(again), again.file) == (ds.FileError, str(raised.value), str(missing))

    data = bytearray(deep_map.read_bytes())
    data[len(data) // 3] ^= 0x10
    broken = tmp_path / "broken.dsm"
    broken.write_bytes(data)
    with pytest.raises(ds.FileError, match="checksum") as raised:
        ds.open(broken).columns()
    assert raised.value.file == str(broken) and raised.value.place is not None
    assert "tile" in raised.value.place

    for length in [0, 3, 64, 500, len(data) - 1]:
        broken.write_bytes(deep_map.read_bytes()[:length])
        with pytest.raises(ds.FileError) as raised:
            ds.open(broken)
        assert raised.value.file == str(broken)

    scene = tmp_path / "scene.toml"
    scene.write_text("[light]\neye = 3\n")
    with pytest.raises(ds.SceneError) as raised_scene:
        ds.Scene(scene)
    assert raised_scene.value.file == str(scene) and raised_scene.value.place == "line 2"
    with pytest.raises(ds.SceneError, match="hairball"):
        ds.Scene("builtin:bald")
    with pytest.raises(ds.FileError) as raised:
        ds.read_deep_exr(deep_map)
    assert raised.value.file == str(deep_map)
    assert issubclass(ds.SettingError, ValueError) and issubclass(ds.FileError, ds.DeepshadowError)
    with pytest.raises(ds.FileError):
        ds.bake("builtin:spinning-sphere", tmp_path / "no" / "such.dsm", resolution=8)


def test_files_that_are_replaced(deep_map: Path, tmp_path: Path) -> None:
    """An open map stays what it was."""
    path = tmp_path / "map.dsm"
    shutil.copy(deep_map, path)
    m = ds.open(path)
    before = m.slice(3.5)
    ds.bake("builtin:spinning-sphere", path, resolution=16)
    assert np.array_equal(m.slice(3.5), before)
    assert ds.open(path).shape == (16, 16)
