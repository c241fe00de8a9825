#!/usr/bin/env bash
# Mitsuba 3.9.1 (PyPI): a strand as `bsplinecurve`, `linearcurve` and `cylinder`, all of radius 0.3, with the BSDF
# `mask` (opacity 0.1) under a directional light, rendered by `volpath`.
#
# Guess: the light under the middle of the strand is the same for the three, 0.9 * 0.9 = 0.81: a tube is entered and
#        left.
# Seen:  0.9 under both curves and 0.81 under the cylinder (and under a sphere): curves show only the side that faces
#        the ray. A strand rebuilt as a mesh or as cylinders casts a shadow twice as dense as the same strand as a curve.
. "$(dirname "$0")/lib.sh"
python_with mitsuba==3.9.1 numpy==2.4.6
cd "$work"
"$python" - <<'PY'
from pathlib import Path
import mitsuba as mi, numpy as np
from verdict import verdict

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f
Path("strand.txt").write_text("".join(f"{x} 0 2 0.3\n" for x in (-4, -2, 0, 2, 4)))

def light_under(shape):
    scene = {
        "type": "scene", "integrator": {"type": "volpath", "max_depth": 2},
        "floor": {"type": "rectangle", "to_world": T().scale(50), "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}},
        "sun": {"type": "directional", "direction": [0, 0, -1], "irradiance": {"type": "rgb", "value": float(np.pi)}},
        "camera": {
            "type": "orthographic", "to_world": T().look_at(origin=[0.1, 0, 1], target=[0.1, 0, 0], up=[0, 1, 0]) @ T().scale([0.01, 0.01, 1]),
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "pixel_format": "luminance"},
            "sampler": {"type": "independent", "sample_count": 16},
        },
    }
    if shape:
        black = {"type": "twosided", "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}
        scene["strand"] = {**shape, "bsdf": {"type": "mask", "opacity": 0.1, "nested": black}}
    return float(np.array(mi.render(mi.load_dict(scene))).mean())

full = light_under(None)
shapes = (
    {"type": "bsplinecurve", "filename": "strand.txt"},
    {"type": "linearcurve", "filename": "strand.txt"},
    {"type": "cylinder", "p0": [-4, 0, 2], "p1": [4, 0, 2], "radius": 0.3},
    {"type": "sphere", "center": [0, 0, 2], "radius": 0.3},
)
verdict("light under bsplinecurve, linearcurve, cylinder, sphere", "0.81 four times",
        [round(light_under(shape) / full, 4) for shape in shapes], [0.9, 0.9, 0.81, 0.81], tolerance=1e-3)
PY
