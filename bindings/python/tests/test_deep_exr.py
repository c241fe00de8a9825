"""Deep OpenEXR images as ragged columns, beside OpenEXR's own client."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import deepshadow as ds

OpenEXR = pytest.importorskip("OpenEXR")
DATA = Path(__file__).resolve().parents[4] / "shared/data/deep"
SAMPLE = Path(__file__).resolve().parents[3] / "docs/sample/tuft.exr"


def ragged(rows: int, columns: int, seed: int = 1) -> dict[str, npt.NDArray[np.float32]]:
    random = np.random.default_rng(seed)
    counts = random.integers(0, 9, rows * columns)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    z = random.uniform(1, 9, offsets[-1]).astype(np.float32)
    return {
        "offsets": offsets,
        "z": z,
        "a": random.uniform(0, 1, len(z)).astype(np.float32),
        "zback": (z + random.uniform(0, 1, len(z))).astype(np.float32),
    }


def theirs(path: Path, names: list[str]) -> list[npt.NDArray[np.float32]]:
    """The channels as OpenEXR's client reads them, pixel after pixel."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        read = []
        for name in names:
            pixels = channels[name].pixels.ravel()
            read.append(np.concatenate([p if p is not None else [] for p in pixels]).astype(np.float32))
        return read


@pytest.mark.parametrize("compression", ["zips", "rle", "none", "zstd"])
@pytest.mark.parametrize("layout", ["scanline", "tiled"])
def test_what_is_written_is_read(compression: str, layout: str, tmp_path: Path) -> None:
    path, made = tmp_path / "image.exr", ragged(23, 41)
    storage = {"compression": compression, "layout": layout}
    camera = {"world_to_camera": np.eye(4), "world_to_ndc": np.arange(16.0).reshape(4, 4)}
    ds.write_deep_exr(
        path, **made, shape=(23, 41), corner=(5, -3), display_window=(0, 0, 99, 49), camera=camera,
        attrs={"owner": "me", "gain": ("float", 0.5)}, **storage,  # type: ignore[arg-type]
    )
    image = ds.read_deep_exr(path)
    assert image.shape == (23, 41) and image.compression == compression.upper()
    assert image.data_window == [5, -3, 45, 19] and image.display_window == [0, 0, 99, 49]
    for name, column in made.items():
        found = getattr(image, name)
        assert np.array_equal(found, column) and not found.flags.writeable, name
    assert image.attrs["owner"] == "me" and image.attrs["gain"] == 0.5
    assert image.camera is not None
    for name, matrix in camera.items():
        assert np.array_equal(image.camera[name], matrix)  # type: ignore[arg-type]
    for threads in [1, 3]:
        assert np.array_equal(ds.read_deep_exr(path, threads=threads).z, made["z"])
    if layout == "scanline":
        z, a, back = theirs(path, ["Z", "A", "ZBack"])
        assert np.array_equal(z, made["z"]) and np.array_equal(a, made["a"])
        assert np.array_equal(back, made["zback"])


def test_their_file_is_read(tmp_path: Path) -> None:
    path, made = tmp_path / "theirs.exr", ragged(7, 5)
    starts = made["offsets"]

    def pixels(column: npt.NDArray[np.float32]) -> npt.NDArray[np.object_]:
        image = np.empty((7, 5), object)
        for i in range(35):
            image[i // 5, i % 5] = column[starts[i] : starts[i + 1]]
        return image

    header = {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.deepscanline}
    channels = {name: pixels(made[key]) for name, key in [("Z", "z"), ("ZBack", "zback"), ("A", "a")]}
    OpenEXR.File(header, channels).write(str(path))
    image = ds.read_deep_exr(path)
    for name, column in made.items():
        assert np.array_equal(getattr(image, name), column), name


def test_colours_and_no_opacity(tmp_path: Path) -> None:
    path, made = tmp_path / "image.exr", ragged(4, 6)
    colours = np.random.default_rng(2).uniform(0, 1, (len(made["z"]), 3)).astype(np.float32)
    ds.write_deep_exr(path, made["offsets"], made["z"], colours, shape=(4, 6))
    image = ds.read_deep_exr(path)
    assert np.array_equal(image.a, colours) and image.zback is None  # type: ignore[arg-type]
    assert image.channels == ["A", "AB", "AG", "AR", "Z"]
    ds.write_deep_exr(path, made["offsets"], made["z"], shape=(4, 6))
    assert ds.read_deep_exr(path).a is None
    ds.write_deep_exr(path, made["offsets"], made["z"], made["a"], shape=(4, 6), type="half")
    half = ds.read_deep_exr(path).a
    assert np.array_equal(half, made["a"].astype(np.float16).astype(np.float32))  # type: ignore[arg-type]
    single = ds.read_deep_exr(path, channels="A=")
    assert single.a is None


def test_columns_that_do_not_fit(tmp_path: Path) -> None:
    path, made = tmp_path / "image.exr", ragged(4, 6)
    for change, words in [
        ({"shape": (4, 7)}, "offsets"),
        ({"a": made["a"][1:]}, "length"),
        ({"zback": made["zback"][1:]}, "length"),
        ({"a": np.zeros((len(made["z"]), 2))}, "samples, 3"),
        ({"offsets": made["offsets"][::-1]}, "offsets"),
        ({"offsets": made["offsets"] + 1}, "offset"),
        ({"compression": "lossy"}, "none of"),
        ({"attrs": {"chunkCount": 3}}, "chunkCount"),
        ({"attrs": {"it": object()}}, "it"),
        ({"camera": {"world": np.eye(4)}}, "world"),
    ]:
        with pytest.raises(ds.SettingError, match=words):
            ds.write_deep_exr(path, **{**made, "shape": (4, 6), **change})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="offsets: integers"):
        ds.write_deep_exr(path, made["offsets"] + 0.5, made["z"], shape=(4, 6))
    assert not path.exists()
    with pytest.raises(ds.FileError):
        ds.write_deep_exr(tmp_path / "no" / "such.exr", **made, shape=(4, 6))  # type: ignore[arg-type]


def test_from_deep_is_a_conversion(deep_map: Path, tmp_path: Path) -> None:
    image, ours, theirs = (tmp_path / name for name in ("image.exr", "ours.dsm", "theirs.dsm"))
    made = ragged(20, 30)
    camera = ds.open(deep_map).camera
    ds.write_deep_exr(image, **made, shape=(20, 30))  # type: ignore[arg-type]
    report = ds.convert(image, theirs, tolerance=0.01)
    told = ds.from_deep(**made, shape=(20, 30), output=ours, camera=camera, tolerance=0.01)  # type: ignore[arg-type]
    assert told["samples"] == report["samples"] == len(made["z"])
    one, other = ds.open(ours), ds.open(theirs)
    for ours_column, theirs_column in zip(one.columns(), other.columns(), strict=True):
        assert np.array_equal(ours_column, theirs_column)
    assert one.camera is not None and camera is not None
    for name, matrix in camera.items():
        assert np.allclose(one.camera[name], matrix, rtol=1e-6, atol=1e-6), name  # type: ignore[arg-type]
    # In plain Python: what each pixel's samples let through in front of a depth, points alone.
    ds.from_deep(made["offsets"], made["z"], made["a"], shape=(20, 30), output=ours)
    image_at = ds.open(ours).slice(5.0)
    for pixel in range(600):
        own = slice(made["offsets"][pixel], made["offsets"][pixel + 1])
        truth = np.prod(1 - made["a"][own][made["z"][own] < 5].astype(np.float64))
        assert image_at[divmod(pixel, 30)] == pytest.approx(truth, abs=1e-6)


def test_awkward(tmp_path: Path) -> None:
    ak = pytest.importorskip("awkward")
    image = ds.read_deep_exr(SAMPLE)
    array = image.to_awkward()
    assert array.fields[0] == "z" and len(array) == image.shape[0]
    assert np.array_equal(ak.to_numpy(ak.flatten(array.z, axis=None)), image.z)


@pytest.mark.skipif(not DATA.is_dir(), reason="the real deep images are not there")
def test_a_real_image() -> None:
    path = DATA / "Leaves.exr"
    image = ds.read_deep_exr(path)
    z, a = theirs(path, ["Z", "A"])
    assert np.array_equal(image.z, z) and np.array_equal(image.a, a)  # type: ignore[arg-type]
