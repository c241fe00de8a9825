#!/usr/bin/env bash
# usd-core 25.8 (PyPI) writes, Blender 5.0.1 (PyPI bpy) reads, Cycles renders: UsdGeomBasisCurves.
#
# Eight points in a zigzag, y = -1.5 and 1.5 in turn, x = 0 … 7; seen from above.
# Guess for basis bspline, wrap nonperiodic: the curve runs from x = 1 to 6 and stays within |y| <= 0.5 (plus its
#        radius 0.05): a B-spline of such a zigzag reaches a third of it. With wrap pinned: from x = 0 to 7.
# Guess for basis catmullRom, wrap nonperiodic: through the points, from x = 1 to 6.
# Seen:  one and the same picture for bspline and catmullRom, nonperiodic and pinned: through all points, from x = 0
#        to 7, |y| up to 1.55. Blender keeps the B-spline as a NURBS curve of order 4; Cycles draws its points as those
#        of a Catmull-Rom curve. Hair that a USD file has as B-splines gets three times its waves.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4 usd-core==25.8
cd "$work"
"$python" - <<'PY'
from pxr import Usd, UsdGeom
for basis in ("bspline", "catmullRom"):
    for wrap in ("nonperiodic", "pinned"):
        stage = Usd.Stage.CreateNew(f"{basis}-{wrap}.usda")
        UsdGeom.SetStageUpAxis(stage, "Z")
        UsdGeom.SetStageMetersPerUnit(stage, 1)
        curves = UsdGeom.BasisCurves.Define(stage, "/curves")
        curves.CreatePointsAttr([(i, i % 2 * 3 - 1.5, 2) for i in range(8)])
        curves.CreateCurveVertexCountsAttr([8])
        curves.CreateTypeAttr("cubic")
        curves.CreateBasisAttr(basis)
        curves.CreateWrapAttr(wrap)
        curves.CreateWidthsAttr([0.1] * 8)
        stage.SetDefaultPrim(curves.GetPrim())
        stage.Save()
PY
cat > scene.py <<'PY'
import bpy, numpy as np
from cycles_scene import camera, new_scene, render, shader
from verdict import verdict

def extent(name):
    new_scene(width=160, height=80, samples=16).cycles_curves.shape = "RIBBONS"
    bpy.ops.wm.usd_import(filepath=f"{name}.usda")
    curves = next(o for o in bpy.data.objects if o.type == "CURVES")
    curves.data.materials.clear()
    curves.data.materials.append(shader("ShaderNodeEmission", Color=(1, 1, 1, 1)))
    camera(3.5, 10, width=8)
    lit = render(whole=True) > 0.1
    rows, columns = np.nonzero(lit)
    return [round(float(v), 1) for v in (columns.min() / 20 - 0.5, (columns.max() + 1) / 20 - 0.5, (rows.max() + 1) / 20 - 2)]

for name, guess in (
    ("bspline-nonperiodic", [1.0, 6.0, 0.55]), ("bspline-pinned", [0.0, 7.0, 0.55]),
    ("catmullRom-nonperiodic", [1.0, 6.0, 1.55]), ("catmullRom-pinned", [0.0, 7.0, 1.55]),
):
    verdict(f"{name}: first x, last x, highest y", guess, extent(name), [0.0, 7.0, 1.5], tolerance=0.11)
PY
"$python" scene.py | grep -E '^(question|guess|seen|CHANGED)'
