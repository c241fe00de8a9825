#!/usr/bin/env bash
# Mitsuba 3.9.1 against Blender 5.0.1 (PyPI mitsuba, bpy): a stack of ten cards, each lets 0.9 of the light through.
#
# Sun straight through the stack onto a floor; only the height of the whole stack above the origin and the gap between
# the cards change. log(light) / log(0.9) is the number of cards that were counted.
# Guess: 10 in both, as long as the gap is far above the spacing of float32 there (6e-5 at a height of 1000).
# Seen:  Cycles 10 each time. Mitsuba's volpath 10 at height 10, but at height 1000 5 with gaps of 0.05 and 2 with gaps
#        of 0.01, at 10000 5 with gaps of 0.5: after each card the ray starts anew, moved on by about a
#        ten-thousandth of the distance from the origin, and what lies in that step is passed over. Hair of a scene in
#        centimetres that stands 10 m from its origin lets too much light through.
. "$(dirname "$0")/lib.sh"
python_with mitsuba==3.9.1 bpy==5.0.1 numpy==1.26.4
cd "$work"
cat > mitsuba_counts.py <<'PY'
import mitsuba as mi, numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

def light(cards, height, gap):
    scene = {
        "type": "scene", "integrator": {"type": "volpath", "max_depth": 2},
        "floor": {"type": "rectangle", "to_world": T().translate([0, 0, height - 5]).scale(50),
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}},
        "sun": {"type": "directional", "direction": [0, 0, -1], "irradiance": {"type": "rgb", "value": float(np.pi)}},
        "camera": {
            "type": "orthographic", "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "pixel_format": "luminance"},
            "to_world": T().look_at(origin=[0, 0, height - 1], target=[0, 0, height - 5], up=[0, 1, 0]) @ T().scale([0.01, 0.01, 1]),
            "sampler": {"type": "independent", "sample_count": 16},
        },
    }
    for k in range(cards):
        scene[f"card{k}"] = {
            "type": "rectangle", "to_world": T().translate([0.3, 0.2, height + gap * k]).scale(10),
            "bsdf": {"type": "mask", "opacity": 0.1, "nested": {"type": "twosided", "nested": {
                "type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}},
        }
    return float(np.array(mi.render(mi.load_dict(scene))).mean())

def counted(height, gap):
    return round(float(np.log(light(10, height, gap) / light(0, height, gap)) / np.log(0.9)), 1)
PY
cat > cycles_counts.py <<'PY'
import math, bpy
from cycles_scene import add, camera, floor, new_scene, render, transparent

def counted(height, gap):
    new_scene(samples=16)
    floor(lit=True)
    for k in range(10):
        mesh, z = bpy.data.meshes.new("card"), height + gap * k
        mesh.from_pydata([(-50, -50, z), (50, -50, z), (50, 50, z), (-50, 50, z)], [], [(0, 1, 2, 3)])
        mesh.materials.append(transparent(0.9))
        add("card", mesh)
    camera(0.3, 1, width=0.1)
    return round(math.log(float(render().mean())) / math.log(0.9), 1)
PY
cat > count.py <<'PY'
import sys
from verdict import verdict

if sys.argv[1] == "mitsuba":
    from mitsuba_counts import counted
else:
    from cycles_counts import counted
for height, recorded in ((10, [10.0, 10.0, 10.0]), (1000, [10.0, 5.0, 2.0]), (10000, [5.0, 1.0, 1.0])):
    verdict(f"{sys.argv[1]}: cards counted of 10 at height {height}, gaps 0.5, 0.05, 0.01", [10, 10, 10],
            [counted(height, gap) for gap in (0.5, 0.05, 0.01)], recorded if sys.argv[1] == "mitsuba" else [10.0] * 3, tolerance=0.01)
PY
for renderer in mitsuba cycles; do
    PYTHONPATH="$work:$PYTHONPATH" "$python" count.py $renderer | grep -E '^(question|guess|seen|CHANGED)'
done
