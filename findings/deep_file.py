"""Deep OpenEXR files of one row, written with the official Python module."""

import numpy as np
import OpenEXR


def write_deep(path, names, pixels):
    """`pixels` is a list of pixels, each a list of samples, each a tuple in the order of `names`."""
    channels = {}
    for index, name in enumerate(names):
        row = np.empty((1, len(pixels)), object)
        for x, samples in enumerate(pixels):
            row[0, x] = np.array([sample[index] for sample in samples], np.float32)
        channels[name] = row
    header = {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}
    OpenEXR.File(header, channels).write(path)
