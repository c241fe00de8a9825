#!/usr/bin/env bash
# Blender 5.0.1 (PyPI bpy), Cycles: a hair strand whose material is opaque for x < 0.5 and clear beyond.
#
# One strand of two points along x from -2 to 2; seen by the camera against a bright floor, and as its shadow.
# Guess: both show one sharp step at x = 0.5.
# Seen:  the camera sees the step. The shadow is a ramp from 0 to 1 over the whole strand: for shadows the material is
#        asked at the curve's points alone, and their transparencies are interpolated. With a third point in the
#        middle, the ramp is over the second half. So a dashed or textured strand throws a smooth shadow.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4
cat > "$work/scene.py" <<'PY'
import numpy as np
from cycles_scene import camera, floor, material, new_scene, render, strand
from verdict import verdict

def step(tree, output):
    place, parts = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeSeparateXYZ")
    beyond, clear = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeBsdfTransparent")
    beyond.operation, beyond.inputs[1].default_value = "GREATER_THAN", 0.5
    tree.links.new(place.outputs["Position"], parts.inputs[0])
    tree.links.new(parts.outputs["X"], beyond.inputs[0])
    tree.links.new(beyond.outputs[0], clear.inputs[0])
    tree.links.new(clear.outputs[0], output.inputs["Surface"])

def along(points, shadow):
    new_scene(width=8, samples=256).cycles_curves.shape = "RIBBONS"
    floor(lit=shadow)
    camera(0, 1 if shadow else 5, width=4)
    strand([(-2 + 4 * i / (points - 1), 0, 2) for i in range(points)], 0.3, material(step))
    return [round(float(v), 2) for v in render()]

def kind(values):
    return "step" if all(v < 0.05 or v > 0.95 for v in values) else "ramp"

for points in (2, 3):
    seen, shadow = along(points, False), along(points, True)
    print("camera:", seen)
    print("shadow:", shadow)
    verdict(f"{points} points: what the camera sees, and the shadow", "step and step", [kind(seen), kind(shadow)], ["step", "ramp"])
    clear = [round(v, 1) for v in shadow]
    verdict("the shadow's light at 8 places along the strand", "0 0 0 0 0 1 1 1", clear,
            [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 0.9] if points == 2 else [0.0, 0.0, 0.0, 0.0, 0.1, 0.4, 0.6, 0.8], tolerance=0.11)
PY
"$python" "$work/scene.py" | grep -E '^(camera|shadow|question|guess|seen|CHANGED|  *recorded)'
