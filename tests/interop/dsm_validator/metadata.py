"""The metadata that maps of every kind have (section 4)."""

import math
from dataclasses import dataclass

from .attributes import check_attributes
from .fault import demand
from .fields import Fields, integer, real, real_f64
from .json_text import parse

MOST_PIXELS_A_SIDE = 2**31 - 1
I32 = (-(2**31), 2**31 - 1)


@dataclass(frozen=True)
class Metadata:
    fields: Fields
    kind: str
    version: int
    width: int
    height: int
    channels: int
    tolerance: float


def read_metadata(contents, limits):
    fields = Fields(parse(contents, "metadata", limits), "metadata")
    kind = fields.text("kind")
    version = fields.integer("kind_version", 0, 2**32 - 1) if fields.nullable("kind_version") is not None else 1
    fields.one_of("depth_kind", ("planar",))
    channels = fields.integer("channels", 1, 3)
    demand(channels != 2, "metadata: channels", "there are 1 or 3")
    width, height = (fields.integer(key, 1, MOST_PIXELS_A_SIDE) for key in ("width", "height"))
    _check_camera(fields.object_or_null("camera"))
    if fields.nullable("samples") is not None:
        fields.integer("samples", 0, 2**32 - 1)
    _check_filter(fields.object_or_null("filter"))
    _check_light(fields.object_or_null("light"))
    for key in ("data_window", "display_window"):
        _check_window(fields.object_or_null(key))
    if "software" in fields:
        fields.text("software")
    if "attributes" in fields:
        check_attributes(fields.object("attributes"))
    tolerance = fields.real("tolerance", 0, below=1)
    return Metadata(fields, kind, version, width, height, channels, tolerance)


def _check_camera(camera):
    if camera is None:
        return
    for key in ("world_to_camera", "world_to_ndc"):
        if camera.nullable(key) is not None:
            for number in camera.array(key, 16):
                real_f64(number, camera.place(key))


def _check_filter(filter_):
    if filter_ is None:
        return
    shape = filter_.one_of("shape", ("box", "tent", "gaussian"))
    filter_.real("width", least=2 if shape == "tent" else 1)


def _check_light(light):
    if light is None:
        return
    shape = light.one_of("shape", ("point", "rectangle", "disk", "sphere"))
    most = 0 if shape == "point" else math.inf
    for number in light.array("size", 2):
        real(number, light.place("size"), least=0, most=most)


def _check_window(window):
    if window is None:
        return
    least, most = (
        [integer(number, *I32, window.place(key)) for number in window.array(key, 2)] for key in ("min", "max")
    )
    demand(all(a <= b for a, b in zip(least, most)), window.name, "min is above max")
