#!/usr/bin/env bash
# Embree 4.4.0 (the library inside PyPI's embreex 4.4.0.post1): rtcSetGeometryTimeRange, from 0.25 to 0.75.
#
# One triangle, with one time step (it stands still) and with two equal ones (motion blur that doesn't move).
# Guess: both exist from 0.25 to 0.75, ends included, and nowhere else: the range says when geometry is there.
# Seen:  with one time step the range is ignored, the triangle is there at all times. With two, 0.25 is in the range and
#        0.75 isn't; the end of a range is only in it if it is 1. A prop that appears for half of the shutter time
#        throws its whole shadow, unless it is given twice the memory.
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
    ("rtcSetGeometryTimeStepCount", None, [pointer, c.c_uint]),
    ("rtcSetGeometryTimeRange", None, [pointer, c.c_float, c.c_float]),
    ("rtcSetNewGeometryBuffer", pointer, [pointer, c.c_int, c.c_uint, c.c_int, c.c_size_t, c.c_size_t]),
    ("rtcCommitGeometry", None, [pointer]),
    ("rtcAttachGeometry", c.c_uint, [pointer, pointer]),
    ("rtcCommitScene", None, [pointer]),
    ("rtcIntersect1", None, [pointer, pointer, pointer]),
):
    function = getattr(embree, name)
    function.restype, function.argtypes = result, arguments

TRIANGLE, INDEX_BUFFER, VERTEX_BUFFER, UINT3, FLOAT3, NOTHING = 0, 0, 1, 0x5003, 0x9003, 0xFFFFFFFF
device = embree.rtcNewDevice(b"threads=1")

def scene_of(steps, first, last):
    scene, triangle = embree.rtcNewScene(device), embree.rtcNewGeometry(device, TRIANGLE)
    embree.rtcSetGeometryTimeStepCount(triangle, steps)
    embree.rtcSetGeometryTimeRange(triangle, first, last)
    for step in range(steps):
        corners = embree.rtcSetNewGeometryBuffer(triangle, VERTEX_BUFFER, step, FLOAT3, 12, 3)
        c.memmove(corners, (c.c_float * 9)(-9, -9, 0, 9, -9, 0, 0, 9, 0), 36)
    c.memmove(embree.rtcSetNewGeometryBuffer(triangle, INDEX_BUFFER, 0, UINT3, 12, 1), (c.c_uint * 3)(0, 1, 2), 12)
    embree.rtcCommitGeometry(triangle)
    embree.rtcAttachGeometry(scene, triangle)
    embree.rtcCommitScene(scene)
    return scene

def is_hit(scene, time):
    # RTCRayHit: origin, tnear, direction, time, tfar, mask, id, flags; then the normal, u, v, prim, geom, instance.
    memory = c.create_string_buffer(256)
    start = (c.addressof(memory) + 63) // 64 * 64
    floats, words = (c.c_float * 24).from_address(start), (c.c_uint * 24).from_address(start)
    floats[0:9] = [0, 0, -5, 0, 0, 0, 1, time, float("inf")]
    words[9] = words[17] = words[18] = words[19] = words[20] = NOTHING
    embree.rtcIntersect1(scene, start, None)
    return words[18] != NOTHING

TIMES = (0.1, 0.25, 0.5, 0.75, 0.9)
guess = [False, True, True, True, False]
for steps, recorded in ((1, [True] * 5), (2, [False, True, True, False, False])):
    scene = scene_of(steps, 0.25, 0.75)
    verdict(f"{steps} time step(s), range 0.25 to 0.75: is it hit at {TIMES}", guess, [is_hit(scene, t) for t in TIMES], recorded)
whole = scene_of(2, 0.5, 1.0)
verdict("2 time steps, range 0.5 to 1: is it hit at 1", True, is_hit(whole, 1.0), True)
PY
