#!/usr/bin/env bash
# Embree 4.4.0 (the library inside PyPI's embreex 4.4.0.post1), FLAT_LINEAR_CURVE, FLAT_BEZIER_CURVE,
# FLAT_BSPLINE_CURVE against ROUND_LINEAR_CURVE.
#
# One ribbon of radius 0.1 along x; rays in +y towards it, tnear 0, that start 0.15, 0.19, 0.21 and 0.5 before it,
# outside of it each time.
# Guess: a hit each time: tnear is the only lower bound of a ray.
# Seen:  no hit of a flat curve nearer than 2 radii to the ray's origin, whichever curve the ray came from, so that
#        layers of hair lie unseen above a point that is shaded. The factor 2 is a build option
#        (EMBREE_CURVE_SELF_INTERSECTION_AVOIDANCE_FACTOR). The round curve is hit each time.
. "$(dirname "$0")/lib.sh"
python_with embreex==4.4.0.post1 numpy==2.4.6
"$python" - <<'PY'
import ctypes as c, glob, sys
from verdict import verdict

embree = c.CDLL(glob.glob(f"{sys.prefix}/lib/python3*/site-packages/embreex.libs/libembree4*")[0])
pointer = c.c_void_p
for name, result, arguments in (
    ("rtcNewDevice", pointer, [c.c_char_p]),
    ("rtcNewScene", pointer, [pointer]),
    ("rtcNewGeometry", pointer, [pointer, c.c_int]),
    ("rtcSetNewGeometryBuffer", pointer, [pointer, c.c_int, c.c_uint, c.c_int, c.c_size_t, c.c_size_t]),
    ("rtcCommitGeometry", None, [pointer]),
    ("rtcAttachGeometry", c.c_uint, [pointer, pointer]),
    ("rtcCommitScene", None, [pointer]),
    ("rtcIntersect1", None, [pointer, pointer, pointer]),
):
    function = getattr(embree, name)
    function.restype, function.argtypes = result, arguments

INDEX_BUFFER, VERTEX_BUFFER, UINT, FLOAT4, NOTHING = 0, 1, 0x5001, 0x9004, 0xFFFFFFFF
device = embree.rtcNewDevice(b"threads=1")

def scene_of(kind, xs):
    scene, curve = embree.rtcNewScene(device), embree.rtcNewGeometry(device, kind)
    points = (c.c_float * (4 * len(xs)))(*[v for x in xs for v in (x, 0, 0, 0.1)])
    c.memmove(embree.rtcSetNewGeometryBuffer(curve, VERTEX_BUFFER, 0, FLOAT4, 16, len(xs)), points, 16 * len(xs))
    c.memmove(embree.rtcSetNewGeometryBuffer(curve, INDEX_BUFFER, 0, UINT, 4, 1), (c.c_uint * 1)(0), 4)
    embree.rtcCommitGeometry(curve)
    embree.rtcAttachGeometry(scene, curve)
    embree.rtcCommitScene(scene)
    return scene

def is_hit(scene, distance):
    # RTCRayHit: origin, tnear, direction, time, tfar, mask, id, flags; then the normal, u, v, prim, geom, instance.
    memory = c.create_string_buffer(256)
    start = (c.addressof(memory) + 63) // 64 * 64
    floats, words = (c.c_float * 24).from_address(start), (c.c_uint * 24).from_address(start)
    floats[0:9] = [0, -distance, 0, 0, 0, 1, 0, 0, float("inf")]
    words[9] = words[17] = words[18] = words[19] = words[20] = NOTHING
    embree.rtcIntersect1(scene, start, None)
    return words[18] != NOTHING

ENDS, HULL = (-2, 2), (-6, -2, 2, 6)
for name, kind, xs, recorded in (
    ("FLAT_LINEAR_CURVE", 17, ENDS, [False, False, True, True]),
    ("FLAT_BEZIER_CURVE", 25, HULL, [False, False, True, True]),
    ("FLAT_BSPLINE_CURVE", 33, HULL, [False, False, True, True]),
    ("ROUND_LINEAR_CURVE", 16, ENDS, [True, True, True, True]),
):
    scene = scene_of(kind, xs)
    verdict(f"{name}: is it hit from 0.15, 0.19, 0.21, 0.5 away", "yes, four times",
            [is_hit(scene, distance) for distance in (0.15, 0.19, 0.21, 0.5)], recorded)
PY
