#!/usr/bin/env bash
# Blender 5.0.1 (PyPI bpy), Cycles: an opaque hair strand of radius 0.1 close above a floor.
#
# The strand lies along x at height 0.15, 0.19, 0.21 and 0.5; how much of the sun reaches the floor under it?
# Guess: nothing, at each height and for each shape of curves.
# Seen:  shape RIBBONS (the usual one): all of it up to a height of 0.19, nothing from 0.21 on. Shapes THICK and
#        THICK_LINEAR: nothing. Ribbons nearer than two radii to where a shadow ray starts aren't met, so that stubble,
#        fur that lies flat and the lowest layer of hair throw no shadow on the skin.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4
cat > "$work/scene.py" <<'PY'
from cycles_scene import camera, floor, new_scene, render, shader, strand
from verdict import verdict

def light(shape, height):
    new_scene(samples=16).cycles_curves.shape = shape
    floor(lit=True)
    strand([(-2 + i, 0, height) for i in range(5)], 0.1, shader("ShaderNodeBsdfDiffuse", Color=(0, 0, 0, 1)))
    camera(0.3, 0.01, width=0.02)
    return round(float(render().mean()), 2)

for shape, recorded in (("RIBBONS", [1.0, 1.0, 0.0, 0.0]), ("THICK", [0.0] * 4), ("THICK_LINEAR", [0.0] * 4)):
    verdict(f"{shape}: light under the strand at heights 0.15, 0.19, 0.21, 0.5", [0, 0, 0, 0],
            [light(shape, height) for height in (0.15, 0.19, 0.21, 0.5)], recorded)
PY
"$python" "$work/scene.py" | grep -E '^(question|guess|seen|CHANGED)'
