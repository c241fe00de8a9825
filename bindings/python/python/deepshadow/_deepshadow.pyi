from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Protocol, TypedDict, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Unpack

__all__ = [
    "DeepImage",
    "KINDS",
    "Level",
    "Light",
    "Map",
    "Scene",
    "Shadow",
    "TileCache",
    "View",
    "__version__",
    "bake",
    "convert",
    "diff",
    "from_deep",
    "merge",
    "mip",
    "open",
    "read_deep_exr",
    "verify",
    "write_deep_exr",
]

KINDS: tuple[str, ...]
__version__: str

_Path = str | PathLike[str]
_Floats = npt.NDArray[np.float32]
_Offsets = npt.NDArray[np.uint32]
_Progress = Callable[[int, int], object] | None
_Attributes = Mapping[str, str | int | float | Sequence[float] | tuple[str, object]]
_Camera = Mapping[str, npt.ArrayLike | None]
_Hits = tuple[npt.ArrayLike, npt.ArrayLike, npt.ArrayLike] | tuple[npt.ArrayLike, npt.ArrayLike, npt.ArrayLike, npt.ArrayLike]
_HitFunction = Callable[[npt.NDArray[np.float64], npt.NDArray[np.float64], _Floats], _Hits]

class _HitSource(Protocol):
    def through(self, view: View, /) -> _HitFunction: ...

class _Query(TypedDict, total=False):
    method: str | None
    filter: Literal["point", "box", "tent", "gaussian"] | None
    width: float | None
    level: float | Literal["auto"] | None
    bias: float | Literal["auto"] | None
    rays: int | None
    light: Light | None
    light_size: float | tuple[float, float] | None
    rule: Literal["ratio", "subtract"] | None
    z_threshold: float | None
    far_table: Literal["auto", "on", "off"] | None
    accumulate: Literal["add", "multiply", "max"] | None
    splits: int | None
    reach: float | None
    near: Map | Scene | None
    seed: int | None

class _BakeSettings(TypedDict, total=False):
    kind: str | None
    resolution: int | tuple[int, int] | None
    samples: int | None
    filter: Literal["box", "tent", "gaussian"] | None
    filter_width: float | None
    tolerance: float | None
    layers: int | None
    coverage: Literal[1, 2, 4, 8] | None
    resets: int | None
    method: Literal["greedy", "min-link"] | None
    side: Literal["both", "lighter", "darker"] | None
    light_samples: int | None
    views: int | None
    preset: Literal["nearest", "paper"] | None
    epsilon: float | None
    accumulate: Literal["add", "multiply", "max"] | None
    levels: str | None
    max_level: int | None
    channels: Literal["auto", "mono", "rgb"] | None
    codec: Literal["exact", "quantized"] | None
    depth_error: float | None
    block: Literal["zstd", "none"] | None
    tile: int | None
    mip: bool | None
    crop: tuple[int, int, int, int] | None
    seed: int | None
    attrs: _Attributes | None

class _MapSettings(TypedDict, total=False):
    tolerance: float | None
    method: Literal["greedy", "min-link"] | None
    side: Literal["both", "lighter", "darker"] | None
    codec: Literal["exact", "quantized"] | None
    depth_error: float | None
    block: Literal["zstd", "none"] | None
    tile: int | None

class _ConvertOptions(_MapSettings, total=False):
    part: str | None
    layer: str | None
    channels: str | None
    camera_axis: Literal["+z", "-z"] | None
    ndc: Literal["unit", "screen"] | None
    exr_layout: Literal["scanline", "tiled"] | None
    exr_type: Literal["float", "half"] | None
    exr_compression: Literal["zips", "rle", "zstd", "none"] | None

class _Storage(TypedDict, total=False):
    compression: Literal["zips", "rle", "zstd", "none"] | None
    type: Literal["float", "half"] | None
    layout: Literal["scanline", "tiled"] | None
    tile: int | None

@final
class TileCache:
    def __new__(cls, bytes: int = ...) -> TileCache: ...
    @property
    def statistics(self) -> dict[str, int]: ...

@final
class Level:
    @property
    def view(self) -> int: ...
    @property
    def number(self) -> int: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def origin(self) -> tuple[int, int]: ...
    @property
    def tile_shape(self) -> tuple[int, int]: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def max_error(self) -> float: ...
    @property
    def mean_error(self) -> float: ...

@final
class Light:
    def __new__(
        cls,
        eye: Sequence[float],
        target: Sequence[float],
        up: Sequence[float] = ...,
        *,
        fov: float | None = None,
        extent: float | None = None,
        shape: Literal["point", "rectangle", "disk", "sphere"] | None = None,
        size: tuple[float, float] | None = None,
        radius: float | None = None,
    ) -> Light: ...
    @property
    def eye(self) -> list[float]: ...
    @property
    def target(self) -> list[float]: ...
    @property
    def up(self) -> list[float]: ...
    @property
    def shape(self) -> str: ...
    @property
    def size(self) -> list[float]: ...

@final
class View:
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def eye(self) -> list[float]: ...
    @property
    def perspective(self) -> bool: ...
    @property
    def basis(self) -> npt.NDArray[np.float64]: ...
    def rays(
        self, x: npt.ArrayLike, y: npt.ArrayLike
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...

@final
class Shadow:
    @property
    def channels(self) -> int: ...
    def at(
        self,
        points: npt.ArrayLike,
        *,
        space: Literal["world", "raster"] = "world",
        normals: npt.ArrayLike | None = None,
        tangents: npt.ArrayLike | None = None,
        threads: int | None = None,
    ) -> _Floats: ...

@final
class Scene:
    def __new__(cls, source: _Path) -> Scene: ...
    @classmethod
    def builtins(cls) -> list[str]: ...
    @property
    def light(self) -> Light: ...
    @property
    def warnings(self) -> list[str]: ...
    def shadow(self, rays: int = 256) -> Shadow: ...

@final
class Map:
    @property
    def path(self) -> PathLike[str]: ...
    @property
    def kind(self) -> str: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def channels(self) -> int: ...
    @property
    def levels(self) -> list[Level]: ...
    @property
    def attrs(self) -> dict[str, Any]: ...
    @property
    def camera(self) -> dict[str, npt.NDArray[np.float64] | None] | None: ...
    @property
    def light(self) -> tuple[str, list[float]] | None: ...
    @property
    def metadata(self) -> dict[str, Any]: ...
    @property
    def default_method(self) -> str: ...
    def columns(self, level: int = 0) -> tuple[_Offsets, _Floats, _Floats]: ...
    def to_awkward(self, level: int = 0) -> Any: ...
    def __getitem__(self, at: tuple[int, int], /) -> _Floats: ...
    def contents(self, y: int, x: int, level: int = 0) -> dict[str, Any]: ...
    def slice(self, z: float, level: int = 0, *, threads: int | None = None) -> _Floats: ...
    def shadow(self, **query: Unpack[_Query]) -> Shadow: ...
    def at(
        self,
        points: npt.ArrayLike,
        *,
        space: Literal["world", "raster"] = "world",
        normals: npt.ArrayLike | None = None,
        tangents: npt.ArrayLike | None = None,
        threads: int | None = None,
        **query: Unpack[_Query],
    ) -> _Floats: ...
    def verify(self) -> list[str]: ...
    def summary(self) -> dict[str, Any]: ...
    def stated_errors(self) -> list[dict[str, float]]: ...
    def __reduce__(self) -> tuple[Callable[[_Path], Map], tuple[PathLike[str]]]: ...

@final
class DeepImage:
    @property
    def offsets(self) -> _Offsets: ...
    @property
    def z(self) -> _Floats: ...
    @property
    def zback(self) -> _Floats | None: ...
    @property
    def a(self) -> _Floats | None: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def data_window(self) -> list[int]: ...
    @property
    def display_window(self) -> list[int]: ...
    @property
    def compression(self) -> str: ...
    @property
    def channels(self) -> list[str]: ...
    @property
    def camera(self) -> dict[str, npt.NDArray[np.float64] | None] | None: ...
    @property
    def attrs(self) -> dict[str, Any]: ...
    def to_awkward(self) -> Any: ...

def open(path: _Path, *, cache: TileCache | None = None) -> Map: ...
def bake(
    source: Scene | Map | _Path | _HitFunction | _HitSource,
    output: _Path,
    *,
    light: Light | None = None,
    media: bool = False,
    threads: int | None = None,
    progress: _Progress = None,
    **settings: Unpack[_BakeSettings],
) -> dict[str, Any]: ...
def convert(
    source: _Path,
    output: _Path,
    *,
    threads: int | None = None,
    progress: _Progress = None,
    **options: Unpack[_ConvertOptions],
) -> dict[str, Any]: ...
def mip(
    source: _Path,
    output: _Path,
    *,
    levels: int | None = None,
    tolerance_scale: float = 0.5,
    threads: int | None = None,
    progress: _Progress = None,
) -> None: ...
def merge(
    sources: Sequence[_Path],
    output: _Path,
    *,
    tolerance: float | None = None,
    threads: int | None = None,
    progress: _Progress = None,
) -> Literal["product", "crops"]: ...
def diff(
    a: _Path, b: _Path, *, threads: int | None = None, progress: _Progress = None
) -> dict[str, Any]: ...
def verify(
    path: _Path,
    *,
    against: _Path | None = None,
    part: str | None = None,
    layer: str | None = None,
    channels: str | None = None,
    threads: int | None = None,
    progress: _Progress = None,
) -> list[str]: ...
def read_deep_exr(
    path: _Path,
    *,
    part: str | None = None,
    layer: str | None = None,
    channels: str | None = None,
    threads: int | None = None,
) -> DeepImage: ...
def write_deep_exr(
    path: _Path,
    offsets: npt.ArrayLike,
    z: npt.ArrayLike,
    a: npt.ArrayLike | None = None,
    zback: npt.ArrayLike | None = None,
    *,
    shape: tuple[int, int],
    corner: tuple[int, int] = ...,
    display_window: Sequence[int] | None = None,
    camera: _Camera | None = None,
    attrs: _Attributes | None = None,
    **storage: Unpack[_Storage],
) -> None: ...
def from_deep(
    offsets: npt.ArrayLike,
    z: npt.ArrayLike,
    a: npt.ArrayLike | None,
    zback: npt.ArrayLike | None = None,
    *,
    shape: tuple[int, int],
    output: _Path,
    camera: _Camera | None = None,
    attrs: _Attributes | None = None,
    threads: int | None = None,
    progress: _Progress = None,
    **settings: Unpack[_MapSettings],
) -> dict[str, Any]: ...
