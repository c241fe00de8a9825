#!/usr/bin/env bash
# OpenVDB 10.0.1 (Debian 12, python3-openvdb) writes, Blender 5.0.1 (PyPI bpy) reads, Cycles renders.
#
# A fog with a frustum transform, as fog seen from a camera or a light is stored: 20 voxels a side, density 0.1, from
# (-0.5 … 0.5) at z = 0 to (-1 … 1) at z = 10. Light along z through it should be e^-1 = 0.368.
# Guess: shown right, or refused with a message (Blender's volumes have one matrix, which can't be a frustum).
# Seen:  it loads without an error and says its matrix is the identity. It is rendered in voxel coordinates, as a box
#        from 0 to 20 in x, y and z: half of the frustum is empty, and light ten units beside it is blocked (0.135).
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4
debian_with python3-openvdb 10.0.1-2
cd "$work"
/usr/bin/python3 - <<'PY'
import pyopenvdb as vdb
grid = vdb.FloatGrid()
grid.name, grid.gridClass = "density", vdb.GridClass.FOG_VOLUME
grid.fill((0, 0, 0), (19, 19, 19), 0.1)
grid.transform = vdb.createFrustumTransform((0, 0, 0), (19, 19, 19), taper=0.5, depth=10.0, voxelSize=1.0)
corners = [grid.transform.indexToWorld(corner) for corner in ((0, 0, 0), (19, 19, 0), (0, 0, 19), (19, 19, 19))]
assert corners == [(-0.5, -0.5, 0), (0.5, 0.5, 0), (-1, -1, 10), (1, 1, 10)], corners
vdb.write("frustum.vdb", grids=[grid])
PY
cat > scene.py <<'PY'
import os, bpy
from cycles_scene import add, camera, floor, new_scene, render, shader
from verdict import verdict

def fog(x, y):
    """The fog, moved so that its point (x, y) is above the middle of the floor."""
    new_scene(samples=1024)
    floor(lit=True)
    volume = bpy.data.volumes.new("fog")
    volume.filepath = os.path.abspath("frustum.vdb")
    volume.materials.append(shader("ShaderNodeVolumePrincipled", "Volume", Density=1, Color=(0, 0, 0, 1)))
    add("fog", volume).location = (-x, -y, 3)
    camera(0, 1, width=0.1)
    return volume

def light(x, y):
    fog(x, y)
    return round(float(render().mean()), 2)

volume = fog(0, 0)
verdict("does it load, its message, is its matrix the identity", "no, or with a message, or another matrix",
        [volume.grids.load(), volume.grids.error_message, [list(row) for row in volume.grids[0].matrix_object]],
        [True, "", [[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]]])
verdict("light at (-0.48, -0.48), in the fog; at (10, 10) and (18, 18), far outside of it", "0.37, 1, 1",
        [light(-0.48, -0.48), light(10, 10), light(18, 18)], [0.58, 0.135, 0.135], tolerance=0.1)
PY
"$python" scene.py | grep -E '^(question|guess|seen|CHANGED)'
