#!/usr/bin/env bash
# usd-core 26.11 (PyPI): UsdGeom.BasisCurves.ComputeVaryingDataSize beside ComputeSegmentCounts.
#
# Curves of every type, basis and wrap. The schema: a varying primvar has one value at each segment's end, so one more
# than segments for curves that are open or pinned, and as many as segments for periodic ones.
# Guess: the two functions of the class agree on that, for all kinds of curves.
# Seen:  they disagree for two. Periodic linear curves of 7 points are given 8 values (7 segments, and cubic ones get
#        7); pinned B-splines and Catmull-Rom curves of 7 points are given 5 (6 segments, so 7), as if they were not
#        pinned. Whoever sizes an array by the one and walks it by the other is off by one or two.
. "$(dirname "$0")/lib.sh"
python_with usd-core==26.11
"$python" - <<'PY'
from itertools import product
from pxr import Usd, UsdGeom
from verdict import verdict

stage = Usd.Stage.CreateInMemory()
now = Usd.TimeCode.Default()
wrong, right = {}, 0
for number, (kind, basis, wrap) in enumerate(
    product(("linear", "cubic"), ("bezier", "bspline", "catmullRom"), ("nonperiodic", "periodic", "pinned"))
):
    curves = UsdGeom.BasisCurves.Define(stage, f"/curves{number}")
    curves.CreateTypeAttr(kind)
    curves.CreateBasisAttr(basis)
    curves.CreateWrapAttr(wrap)
    curves.CreateCurveVertexCountsAttr([7])
    segments = curves.ComputeSegmentCounts(now)[0]
    want = segments + (wrap != "periodic")
    size = curves.ComputeVaryingDataSize(now)
    if size == want:
        right += 1
    else:
        wrong[f"{kind} {basis} {wrap}"] = [segments, size]
for name, seen in wrong.items():
    print(f"{name}: segments and varying values {seen}")
verdict("kinds of 18 that agree", 18, right, 13)
verdict("the others", "none", sorted(wrong.items()),
        [("cubic bspline pinned", [6, 5]), ("cubic catmullRom pinned", [6, 5]), ("linear bezier periodic", [7, 8]),
         ("linear bspline periodic", [7, 8]), ("linear catmullRom periodic", [7, 8])])
PY
