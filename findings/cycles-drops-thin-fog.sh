#!/usr/bin/env bash
# OpenVDB 10.0.1 (Debian 12, python3-openvdb) writes, Blender 5.0.1 (PyPI bpy) reads, Cycles renders.
#
# A fog of 20 voxels a side under the sun, with a volume shader whose density multiplies the grid. Grid values times
# shader density times thickness is 1 each time, so that e^-1 = 0.368 of the light should reach the floor.
# Guess: 0.368 each time, up to a few hundredths for the interpolation at the border.
# Seen:  0.37 for grid values 0.05 and 0.0011 (shader density 1 and 45.5), 1.0 (no fog at all) for 0.001 and 0.0005
#        (50 and 100): voxels up to 0.001 are cut away on loading (the volume's `render.clipping`), before the shader
#        makes them thick, so that fog in real units (extinction per metre) can vanish whole.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4
debian_with python3-openvdb 10.0.1-2
cd "$work"
/usr/bin/python3 - <<'PY'
import pyopenvdb as vdb
for value in (0.05, 0.0011, 0.001, 0.0005):
    grid = vdb.FloatGrid()
    grid.name, grid.gridClass = "density", vdb.GridClass.FOG_VOLUME
    grid.fill((0, 0, 0), (19, 19, 19), value)
    vdb.write(f"fog{value}.vdb", grids=[grid])
PY
cat > scene.py <<'PY'
import os, bpy
from cycles_scene import add, camera, floor, new_scene, render, shader
from verdict import verdict

def light(value, factor):
    new_scene(samples=1024)
    floor(lit=True)
    volume = bpy.data.volumes.new("fog")
    volume.filepath = os.path.abspath(f"fog{value}.vdb")
    volume.materials.append(shader("ShaderNodeVolumePrincipled", "Volume", Density=factor, Color=(0, 0, 0, 1)))
    add("fog", volume).location = (-10, -10, 5)
    camera(0, 1, width=1)
    return float(render().mean())

for value, recorded in ((0.05, 0.37), (0.0011, 0.37), (0.001, 1.0), (0.0005, 1.0)):
    verdict(f"light under a fog of voxels {value}, shader density {0.05 / value:.3g}", 0.368,
            round(light(value, 0.05 / value), 3), recorded, tolerance=0.03)
PY
"$python" scene.py | grep -E '^(question|guess|seen|CHANGED)'
