#!/usr/bin/env bash
# Blender 5.0.1 (PyPI bpy), Cycles: how often one strand is counted, in its shadow and by the camera.
#
# A strand of five points along x with radius 0.3, a point of a point cloud, and a mesh sphere, all of a material
# that lets 0.9 of the light through; log(light) / log(0.9) is the number of times it was counted.
# Guess: once for ribbons; twice (in and out) for thick curves, points and spheres, the same for camera and shadow.
# Seen:  curve shape RIBBONS and THICK_LINEAR 1 and 1, a point of a cloud 1 and 1, a mesh sphere 2 and 2. Curve shape
#        THICK: 1 for the camera, but from 3 to more than 9 in the shadow, another number at every place along the
#        strand, so that half-clear thick hair throws a shadow that is much too dark, and blotched.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4 usd-core==25.8
cd "$work"
"$python" - <<'PY'
from pxr import Usd, UsdGeom
stage = Usd.Stage.CreateNew("point.usda")
UsdGeom.SetStageUpAxis(stage, "Z")
UsdGeom.SetStageMetersPerUnit(stage, 1)
points = UsdGeom.Points.Define(stage, "/point")
points.CreatePointsAttr([(0, 0, 3)])
points.CreateWidthsAttr([2.0])
stage.SetDefaultPrim(points.GetPrim())
stage.Save()
PY
cat > scene.py <<'PY'
import bpy, numpy as np
from cycles_scene import add, camera, floor, new_scene, render, strand, transparent
from verdict import verdict

def curve(shape):
    bpy.context.scene.cycles_curves.shape = shape
    strand([(-2 + i, 0, 2) for i in range(5)], 0.3, transparent(0.9))

def point(_):
    bpy.ops.wm.usd_import(filepath="point.usda")
    cloud = next(o for o in bpy.data.objects if o.type == "POINTCLOUD")
    cloud.data.materials.clear()
    cloud.data.materials.append(transparent(0.9))

def sphere(_):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, location=(0, 0, 3))
    bpy.context.object.data.materials.append(transparent(0.9))

def counts(make, shape, shadow):
    new_scene(width=33, samples=256)
    floor(lit=shadow)
    make(shape)
    camera(0.01 if make is curve else 0.31, 1 if shadow else 6, width=3.5 if make is curve else 0.1)
    found = np.log(np.maximum(render(), 1e-30)) / np.log(0.9)
    print(f"{shape} {'shadow' if shadow else 'camera'}: from {found.min():.1f} to {found.max():.1f}")
    return found

def summary(make, shape):
    seen, shadow = counts(make, shape, False), counts(make, shape, True)
    times = lambda v: int(round(v.mean())) if v.max() - v.min() < 0.1 else "uneven"
    return [times(seen), times(shadow)], shadow

for make, shape, guess, recorded in (
    (curve, "RIBBONS", "1 and 1", [1, 1]),
    (curve, "THICK_LINEAR", "2 and 2", [1, 1]),
    (curve, "THICK", "2 and 2", [1, "uneven"]),
    (point, "point", "2 and 2", [1, 1]),
    (sphere, "sphere", "2 and 2", [2, 2]),
):
    found, shadow = summary(make, shape)
    verdict(f"{shape}: times counted by the camera and in the shadow", guess, found, recorded)
    if shape == "THICK":
        verdict("does the shadow of THICK count one strand more than 5 times in the middle of the values", "no",
                bool(np.median(shadow) > 5), True)
PY
"$python" scene.py | grep -E '^([a-zA-Z_]+ (camera|shadow)|question|guess|seen|CHANGED)'
