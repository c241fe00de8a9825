#!/usr/bin/env bash
# Blender 5.0.1 (PyPI bpy), Cycles: puffs of smoke that overlap.
#
# n boxes of absorbing volume, one inside the other, each with an optical depth of 0.02 from top to bottom.
# Guess: the light below is e^(-0.02 n) for every n (nothing in the scene's settings speaks of a number of volumes).
# Seen:  so it is up to n = 31. From the 32nd on, further volumes are left out without a word: for n = 40 and n = 64
#        the light stays at e^(-0.02 * 31) = 0.54.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4
cat > "$work/scene.py" <<'PY'
import math, bpy
from cycles_scene import add, camera, floor, new_scene, render, shader
from verdict import verdict

DEPTH = 0.02

def box(low, high, smoke):
    mesh = bpy.data.meshes.new("box")
    mesh.from_pydata([(x, y, z) for z in (low, high) for x, y in ((-9, -9), (9, -9), (9, 9), (-9, 9))], [],
                     [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
    mesh.materials.append(smoke)
    add("box", mesh)

def counted(n):
    new_scene()
    floor(lit=True)
    for k in range(n):
        low, high = 2 + 0.001 * k, 4 - 0.001 * k
        box(low, high, shader("ShaderNodeVolumeAbsorption", "Volume", Density=DEPTH / (high - low), Color=(0, 0, 0, 1)))
    camera(0.1, 1, width=0.1)
    return -math.log(float(render().mean())) / DEPTH

verdict("how many of 1, 20, 31, 32, 40, 64 nested volumes take light away", [1, 20, 31, 32, 40, 64],
        [round(counted(n), 1) for n in (1, 20, 31, 32, 40, 64)], [1.0, 20.0, 31.0, 31.0, 31.0, 31.0], tolerance=0.01)
PY
"$python" "$work/scene.py" | grep -E '^(question|guess|seen|CHANGED)'
