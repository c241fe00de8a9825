#!/usr/bin/env bash
# usd-core 26.11 (PyPI): orientations of a point instancer beside xformOp:orient.
#
# A quarter turn about x, as the orientation of an instance (the schema's type is `quath`) and as xformOp:orient of a
# prim, of type quath. Halves cannot hold the root of 1/2, so the quaternion is not exactly of length 1.
# Guess: both are rotations, off by what a half rounds; both make the same of any quaternion.
# Seen:  xformOp:orient is a rotation. The instance's matrix is not: two edges of a cube of 2 units are 1.99957 long.
#        Of (2, 1, 0, 0) xformOp:orient makes no rotation at all (the angle is twice the arc cosine of the real part,
#        which is cut to 1), the instance a cube that is 4.12 times as large in two directions.
. "$(dirname "$0")/lib.sh"
python_with usd-core==26.11
"$python" - <<'PY'
from pxr import Gf, Usd, UsdGeom
from verdict import verdict

stage = Usd.Stage.CreateInMemory()

def instance(path, quaternion):
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    UsdGeom.Cube.Define(stage, path + "/cube")
    instancer.CreatePrototypesRel().SetTargets([path + "/cube"])
    instancer.CreateProtoIndicesAttr([0])
    instancer.CreatePositionsAttr([(0, 0, 0)])
    instancer.CreateOrientationsAttr([quaternion])
    return instancer.ComputeInstanceTransformsAtTime(0, 0)[0]

def operation(path, quaternion):
    prim = UsdGeom.Xform.Define(stage, path)
    prim.AddOrientOp(UsdGeom.XformOp.PrecisionHalf).Set(quaternion)
    return prim.GetLocalTransformation()

def edges(matrix):
    return [round(matrix.TransformDir(Gf.Vec3d(*axis)).GetLength(), 5) for axis in ((2, 0, 0), (0, 2, 0), (0, 0, 2))]

root = 0.5 ** 0.5
turn, long = Gf.Quath(root, root, 0, 0), Gf.Quath(2, 1, 0, 0)
verdict("edges of a cube of 2 units after a quarter turn by xformOp:orient", "2, 2, 2",
        edges(operation("/turned", turn)), [2.0, 2.0, 2.0])
verdict("the same as an instance", "2, 2, 2", edges(instance("/instances", turn)), [2.0, 1.99957, 1.99957], 1e-5)
verdict("(2, 1, 0, 0) by xformOp:orient leaves (0, 2, 0) at", "turned by 53 degrees",
        [round(x, 3) for x in operation("/long", long).TransformDir(Gf.Vec3d(0, 2, 0))], [0.0, 2.0, 0.0])
verdict("edges with (2, 1, 0, 0) as an instance", "2, 2, 2", edges(instance("/longs", long)), [2.0, 8.24621, 8.24621])
PY
