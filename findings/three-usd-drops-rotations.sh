#!/usr/bin/env bash
# three.js r187 (npm three 0.187.0), USDLoader, against usd-core 26.11 (PyPI).
#
# Triangles under common transform operations of USD, written by usd-core; where is the point (1, 0, 0) of each?
# Guess: the same place in both.
# Seen:  the loader knows rotateXYZ alone. The other five orders of three angles are left out without a word, and so
#        are translations and scales with a suffix (xformOp:translate:one; :pivot is known); `!resetXformStack!` is
#        ignored, so that the parent's transform is applied all the same; what is invisible or a guide is shown.
. "$(dirname "$0")/lib.sh"
python_with usd-core==26.11
node_with three@0.187.0
cd "$work"
cat > node/points.mjs <<'JS'
import { readFileSync } from 'node:fs';
import { Vector3 } from 'three';
import { USDLoader } from 'three/addons/loaders/USDLoader.js';
const group = await new USDLoader().parse(readFileSync('../scene.usda', 'utf8'));
group.updateMatrixWorld(true);
const points = {};
group.traverse(node => {
    if (node.isMesh && node.visible) points[node.name] = new Vector3(1, 0, 0).applyMatrix4(node.matrixWorld).toArray();
});
console.log(JSON.stringify(points));
JS
"$python" - <<'PY'
import json, subprocess
from pxr import Gf, Usd, UsdGeom
from verdict import verdict

stage = Usd.Stage.CreateNew("scene.usda")
root = UsdGeom.Xform.Define(stage, "/root")
stage.SetDefaultPrim(root.GetPrim())

def triangle(path):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    return mesh

for order in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"):
    getattr(triangle(f"/root/rotate{order}"), f"AddRotate{order}Op")().Set((10, 20, 30))
triangle("/root/plain").AddTranslateOp().Set((0, 5, 0))
triangle("/root/suffix").AddTranslateOp(UsdGeom.XformOp.PrecisionDouble, "one").Set((0, 5, 0))
moved = UsdGeom.Xform.Define(stage, "/root/moved")
moved.AddTranslateOp().Set((100, 0, 0))
reset = triangle("/root/moved/reset")
reset.AddTranslateOp().Set((1, 0, 0))
reset.SetResetXformStack(True)
triangle("/root/invisible").CreateVisibilityAttr("invisible")
triangle("/root/guide").CreatePurposeAttr("guide")
stage.Save()

cache = UsdGeom.XformCache()
want = {prim.GetName(): cache.GetLocalToWorldTransform(prim).Transform(Gf.Vec3d(1, 0, 0))
        for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)}
got = json.loads(subprocess.run(["node", "points.mjs"], cwd="node", capture_output=True, text=True, check=True).stdout)
wrong = [name for name in want if name in got and max(abs(a - b) for a, b in zip(want[name], got[name])) > 1e-6]
verdict("which meshes lie elsewhere than usd-core says", "none", sorted(wrong),
        ["reset", "rotateXZY", "rotateYXZ", "rotateYZX", "rotateZXY", "rotateZYX", "suffix"])
verdict("where the triangle with rotateZYX (10, 20, 30) has its (1, 0, 0)", [round(v, 3) for v in want["rotateZYX"]],
        got["rotateZYX"], [1.0, 0.0, 0.0])
verdict("which of `invisible` and `guide` are shown", "neither", sorted(got.keys() & {"invisible", "guide"}),
        ["guide", "invisible"])
PY
