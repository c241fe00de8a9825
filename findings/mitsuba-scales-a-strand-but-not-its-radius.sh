#!/usr/bin/env bash
# Mitsuba 3.9.1 (PyPI): `to_world` of a curve shape, of an instance of it, and of a cylinder.
#
# A strand of radius 0.1 from x = -4 to 4, scaled by 2; how thick is it, and does it reach x = 6?
# Guess: radius 0.2 each time.
# Seen:  the curve's points are scaled (it reaches x = 6) and its radius stays 0.1. The same curve in a shapegroup, with
#        the scale on the instance, has 0.2, as the cylinder has. So hair in another unit than its scene keeps the
#        thickness of its file, unless it is instanced.
. "$(dirname "$0")/lib.sh"
python_with mitsuba==3.9.1 numpy==2.4.6
cd "$work"
"$python" - <<'PY'
from pathlib import Path
import mitsuba as mi
from verdict import verdict

mi.set_variant("scalar_rgb")
Path("strand.txt").write_text("".join(f"{x} 0 0 0.1\n" for x in (-4, -2, 0, 2, 4)))
curve = {"type": "linearcurve", "filename": "strand.txt"}
cylinder = {"type": "cylinder", "p0": [-4, 0, 0], "p1": [4, 0, 0], "radius": 0.1}
twice = mi.ScalarTransform4f().scale(2)

def is_hit(scene, x, y):
    return scene.ray_intersect(mi.Ray3f([x, y, 50], [0, 0, -1])).is_valid()

def radius_and_reach(scene):
    scene = mi.load_dict({"type": "scene", **scene})
    low, high = 0.0, 5.0
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if is_hit(scene, 0.1, middle) else (low, middle)
    return [round(low, 3), bool(is_hit(scene, 6, 0))]

seen = [
    radius_and_reach({"strand": {**curve, "to_world": twice}}),
    radius_and_reach({"group": {"type": "shapegroup", "strand": curve},
                      "instance": {"type": "instance", "group": {"type": "ref", "id": "group"}, "to_world": twice}}),
    radius_and_reach({"strand": {**cylinder, "to_world": twice}}),
]
verdict("[radius, reaches x = 6] of a curve, an instance of a curve, a cylinder, all scaled by 2",
        [[0.2, True]] * 3, seen, [[0.1, True], [0.2, True], [0.2, True]])
PY
