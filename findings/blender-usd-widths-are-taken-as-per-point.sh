#!/usr/bin/env bash
# usd-core 25.8 (PyPI) writes, Blender 5.0.1 (PyPI bpy) reads: `widths` of UsdGeomBasisCurves.
#
# Guess: each way that USD has to give widths ends as half of it at every point.
# Seen:  vertex and constant do. `varying` (of a cubic curve of 8 points: 6 values) and `uniform` (one a curve) are
#        laid on the first points, one after the other, and all points left over get radius 0; `primvars:widths`, which
#        USD puts above `widths`, gives no radius at all. Points of radius 0 are invisible: strands taper off or vanish.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4 usd-core==25.8
cd "$work"
"$python" - <<'PY'
from pxr import Sdf, Usd, UsdGeom
stage = Usd.Stage.CreateNew("widths.usda")
UsdGeom.SetStageUpAxis(stage, "Z")
UsdGeom.SetStageMetersPerUnit(stage, 1)
stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/hair").GetPrim())

def curves(name, counts, kind):
    made = UsdGeom.BasisCurves.Define(stage, f"/hair/{name}")
    made.CreatePointsAttr([(i, 0, 0) for i in range(8)])
    made.CreateCurveVertexCountsAttr(counts)
    made.CreateTypeAttr(kind)
    made.CreateBasisAttr("bspline")
    return made

for name, counts, kind, widths in (
    ("vertex", [8], "cubic", [0.2] * 8),
    ("constant", [8], "cubic", [0.2]),
    ("varying", [8], "cubic", [0.2] * 6),
    ("uniform", [4, 4], "linear", [0.2, 0.4]),
):
    made = curves(name, counts, kind)
    made.CreateWidthsAttr(widths)
    made.SetWidthsInterpolation(name)
    assert made.ComputeInterpolationForSize(len(widths), Usd.TimeCode.Default()) == name
made = curves("primvar", [8], "cubic")
UsdGeom.PrimvarsAPI(made).CreatePrimvar("widths", Sdf.ValueTypeNames.FloatArray, "vertex").Set([0.2] * 8)
stage.Save()
PY
cat > scene.py <<'PY'
import bpy
from cycles_scene import new_scene
from verdict import verdict

new_scene()
bpy.ops.wm.usd_import(filepath="widths.usda")
radii = {o.name: [round(p.radius, 3) for p in o.data.points] for o in bpy.data.objects if o.type == "CURVES"}
for name, guess, recorded in (
    ("vertex", [0.1] * 8, [0.1] * 8),
    ("constant", [0.1] * 8, [0.1] * 8),
    ("varying", [0.1] * 8, [0.1] * 6 + [0.0] * 2),
    ("uniform", [0.1] * 4 + [0.2] * 4, [0.1, 0.2] + [0.0] * 6),
    ("primvar", [0.1] * 8, [0.0] * 8),
):
    verdict(f"radii of {name} widths", guess, radii[name], recorded)
PY
"$python" scene.py | grep -E '^(question|guess|seen|CHANGED)'
