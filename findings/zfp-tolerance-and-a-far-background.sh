#!/usr/bin/env bash
# zfp 1.0.1 (zfpy 1.0.1.post0, PyPI): `compress_numpy(..., tolerance=0.01)`.
#
# 64 × 64 float32 depths between 5 and 6; in every eighth row and column one pixel without a hit holds 1e30, as deep
# and depth images have it.
# Guess: every depth comes back within 0.01; the tolerance is absolute, and files with such a pixel are just larger.
# Seen:  no error is raised, and depths beside a 1e30 come back as 0, an error of 6: numbers of one block share an
#        exponent, and 1e30 leaves the others no bits. SZ3 and LERC hold their bounds on the same array.
. "$(dirname "$0")/lib.sh"
python_with zfpy==1.0.1.post0 imagecodecs==2026.3.6 numpy==2.4.6
"$python" - <<'PY'
import imagecodecs, numpy as np, zfpy
from verdict import verdict

TOLERANCE = 0.01
clean = (5 + np.random.default_rng(0).random((64, 64))).astype(np.float32)
holes = clean.copy()
holes[::8, ::8] = 1e30
surface = holes < 1e20

def zfp(depths):
    return zfpy.decompress_numpy(zfpy.compress_numpy(depths, tolerance=TOLERANCE))

def sz3(depths):
    return imagecodecs.sz3_decode(imagecodecs.sz3_encode(depths, "abs", abs=TOLERANCE), depths.shape, depths.dtype)

def lerc(depths):
    return imagecodecs.lerc_decode(imagecodecs.lerc_encode(depths, level=TOLERANCE))

def held(codec, depths):
    error = float(np.abs(np.asarray(codec(depths)).reshape(depths.shape) - depths)[surface].max())
    print(f"{codec.__name__}: largest error of a depth {error:.4f}")
    return error <= TOLERANCE

verdict("is the tolerance held without 1e30: zfp, SZ3, LERC", "yes, yes, yes",
        [held(codec, clean) for codec in (zfp, sz3, lerc)], [True, True, True])
verdict("and with 1e30 beside the depths", "yes, yes, yes",
        [held(codec, holes) for codec in (zfp, sz3, lerc)], [False, True, True])
verdict("how many depths are lost whole (come back as 0) beside one 1e30, of the 15 of its block", "none",
        int((zfp(holes)[:4, :4] == 0).sum()), 15)
PY
