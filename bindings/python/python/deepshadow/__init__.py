"""Deep and layered shadow maps of any kind: opened, queried, baked and verified.

>>> import numpy as np, deepshadow as ds
>>> report = ds.bake("builtin:spinning-sphere", "sphere.dsm", resolution=64)
>>> m = ds.open("sphere.dsm")
>>> m.kind, m.shape, m.channels
('deep', (64, 64), 1)
>>> m.at(np.zeros((1, 3)))            # the centre of the sphere is dark
array([0.], dtype=float32)
>>> offsets, z, v = m.columns()       # all visibility functions, without a copy
"""

from ._deepshadow import (
    KINDS,
    DeepImage,
    Level,
    Light,
    Map,
    Scene,
    Shadow,
    TileCache,
    View,
    __version__,
    bake,
    convert,
    diff,
    from_deep,
    merge,
    mip,
    open,
    read_deep_exr,
    verify,
    write_deep_exr,
)
from ._errors import (
    Cancelled,
    DeepshadowError,
    FileError,
    HitSourceError,
    QueryError,
    SceneError,
    SettingError,
)

__all__ = [
    "KINDS",
    "Cancelled",
    "DeepImage",
    "DeepshadowError",
    "FileError",
    "HitSourceError",
    "Level",
    "Light",
    "Map",
    "QueryError",
    "Scene",
    "SceneError",
    "SettingError",
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
