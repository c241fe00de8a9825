#!/usr/bin/env bash
# OpenVDB 10.0.1 (Debian 12, python3-openvdb) writes, Blender 5.0.1 (PyPI bpy) reads, Cycles renders.
#
# A fog of 20 voxels a side, density 0.05, and the object that holds it scaled along z, the way of the light. Volumes
# are in object space by default: their opacity is to stay when the object is scaled.
# Guess: optical depth 1 for every scale along z, and 2, 4 times that in world space, for scales of 2 and 4.
# Seen:  object space: 1 for one and the same scale in x, y and z, but 0.58, 1.41 and 1.63 for 0.5, 2 and 4 along z alone:
#        all lengths are divided by one mean of the three scales. World space: 0.5, 1, 2, 4, as it should be. So a puff
#        that is squashed along the light is neither as dense as before nor as dense as its new size says.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4
debian_with python3-openvdb 10.0.1-2
cd "$work"
/usr/bin/python3 - <<'PY'
import pyopenvdb as vdb
grid = vdb.FloatGrid()
grid.name, grid.gridClass = "density", vdb.GridClass.FOG_VOLUME
grid.fill((0, 0, 0), (19, 19, 19), 0.05)
vdb.write("fog.vdb", grids=[grid])
PY
cat > scene.py <<'PY'
import math, os, bpy
from cycles_scene import add, camera, floor, new_scene, render, shader
from verdict import verdict

def depth(scale, space):
    new_scene(samples=4096)
    floor(lit=True)
    volume = bpy.data.volumes.new("fog")
    volume.filepath, volume.render.space = os.path.abspath("fog.vdb"), space
    volume.materials.append(shader("ShaderNodeVolumePrincipled", "Volume", Density=1, Color=(0, 0, 0, 1)))
    fog = add("fog", volume)
    fog.location, fog.scale = (-10 * scale[0], -10 * scale[1], 5), scale
    camera(0, 1, width=0.1)
    return round(-math.log(float(render().mean())), 2)

for name, scale, guess, recorded in (
    ("all 4", (4, 4, 4), [1, 4], [1.0, 4.0]),
    ("z 0.5", (1, 1, 0.5), [1, 0.5], [0.58, 0.5]),
    ("z 2", (1, 1, 2), [1, 2], [1.41, 2.0]),
    ("z 4", (1, 1, 4), [1, 4], [1.63, 4.0]),
):
    verdict(f"scale {name}: optical depth along z in object and in world space", guess,
            [depth(scale, "OBJECT"), depth(scale, "WORLD")], recorded, tolerance=0.06)
PY
"$python" scene.py | grep -E '^(question|guess|seen|CHANGED)'
