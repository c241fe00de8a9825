"""Times deep pixels into columns beside OpenEXR's and OpenImageIO's clients, answers compared.

compare_speed.py IMAGE.exr [ROUNDS]: medians of turns, on all cores.
"""

import statistics
import sys
import time

import numpy as np
import OpenEXR
import OpenImageIO as oiio

import deepshadow as ds

path = sys.argv[1]
rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 5


def ours():
    return ds.read_deep_exr(path).z


def openexr():
    with OpenEXR.File(path, separate_channels=True) as file:
        return file.channels()["Z"].pixels


def openimageio():
    source = oiio.ImageInput.open(path)
    data = source.read_native_deep_image(0, 0)
    source.close()
    return data


times = {ours: [], openexr: [], openimageio: []}
answers = {}
for _ in range(rounds):
    for read, seconds in times.items():
        started = time.perf_counter()
        answers[read] = read()
        seconds.append(time.perf_counter() - started)
z = answers[ours]
theirs = np.concatenate([pixel for pixel in answers[openexr].ravel() if pixel is not None])
assert np.array_equal(z, theirs)
data = answers[openimageio]
assert sum(data.samples(pixel) for pixel in range(data.pixels)) == len(z)
mine = statistics.median(times[ours])
print(f"{len(z)} samples into columns: {mine * 1e3:.1f} ms")
for read in (openexr, openimageio):
    theirs = statistics.median(times[read])
    print(f"{read.__name__}: {theirs * 1e3:.1f} ms, {theirs / mine:.1f} times as long")
