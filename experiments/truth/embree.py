"""Embree, as a tracer of all hits: the truth for surfaces and strands."""

import ctypes
import os
import subprocess
import time
from pathlib import Path

import numpy as np

from geometry import Mesh, Strands

SHAPES = {"point": 0, "rectangle": 1, "disk": 2, "sphere": 3}
SOURCE = Path(__file__).with_name("tracer.cpp")


class NotBuilt(Exception):
    """The tracer could not be compiled."""


def build(folder):
    """Compiles the tracer into `folder` and loads it."""
    library = Path(folder) / "libtruth.so"
    command = [os.environ.get("CXX", "c++"), "-std=c++17", "-O2", "-fPIC", "-shared", "-pthread"]
    done = subprocess.run([*command, "-o", library, SOURCE, "-lembree3"], capture_output=True, text=True)
    if done.returncode:
        raise NotBuilt(f"the tracer needs a C++ compiler and libembree-dev (Embree 3):\n{done.stderr}")
    loaded = ctypes.CDLL(str(library))
    loaded.truth_new.restype = ctypes.c_void_p
    return loaded


def pointer(array):
    return None if array is None else array.ctypes.data_as(ctypes.c_void_p)


def light_numbers(light):
    right, up = light.half_axes()
    return np.concatenate([light.eye, right, up]).astype(float)


class Truth:
    """A scene's surfaces and strands in Embree."""

    def __init__(self, library, geometries, threads):
        self.library, self.threads = library, threads
        self.scene = ctypes.c_void_p(library.truth_new(threads))
        for geometry in geometries:
            if isinstance(geometry, Mesh):
                self._add_mesh(geometry)
            elif isinstance(geometry, Strands):
                self._add_strands(geometry)
        start = time.monotonic()
        library.truth_commit(self.scene)
        self.build_seconds = time.monotonic() - start

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.library.truth_free(self.scene)

    def _add_mesh(self, mesh):
        positions, triangles = (np.ascontiguousarray(a, t) for a, t in ((mesh.positions, "f4"), (mesh.triangles, "u4")))
        opacity = np.array(mesh.opacity, "f4")
        uvs = None if mesh.uvs is None else np.ascontiguousarray(mesh.uvs, "f4")
        material = mesh.material
        alpha = None if material.alpha is None else np.ascontiguousarray(material.alpha, "f4")
        height, width = alpha.shape if alpha is not None else (0, 0)
        self.library.truth_add_triangles(
            self.scene, len(positions), pointer(positions), len(triangles), pointer(triangles), pointer(opacity),
            pointer(uvs), material.mode, ctypes.c_float(material.cutoff), ctypes.c_float(material.factor),
            width, height, pointer(alpha), int(material.nearest), *material.wrap,
        )  # fmt: skip

    def _add_strands(self, strands):
        first, strand = strands.segments()
        radius = strands.thickness / 2
        points = np.column_stack([strands.points, np.full(len(strands.points), radius)]).astype("f4")
        opacity = np.array(strands.opacity, "f4")
        self.library.truth_add_strands(
            self.scene, len(points), pointer(points), len(first), pointer(first), pointer(strand), pointer(opacity),
            ctypes.c_float(radius),
        )  # fmt: skip

    def visibility(self, light, points, own, side, seed):
        """The light at points, by two halves of `side`² rays with numbers of their own: (n, 2, 3)."""
        points, own = np.ascontiguousarray(points, float), np.ascontiguousarray(own, "i4")
        numbers = light_numbers(light)
        out = np.empty((len(points), 2, 3))
        self.library.truth_visibility(
            self.scene, SHAPES[light.shape], pointer(numbers), ctypes.c_uint64(len(points)), pointer(points),
            pointer(own), side, ctypes.c_uint64(seed), pointer(out), self.threads,
        )  # fmt: skip
        return out

    def picture(self, light, camera, samples, lift, seed):
        """A picture's shadow factors, by two halves of `samples` camera rays a pixel: (height, width, 2, 3)."""
        width, height = camera.resolution
        numbers, eye = light_numbers(light), camera.numbers()
        out = np.empty((height, width, 2, 3))
        self.library.truth_picture(
            self.scene, SHAPES[light.shape], pointer(numbers), pointer(eye), width, height, samples,
            ctypes.c_double(lift), ctypes.c_uint64(seed), pointer(out), self.threads,
        )  # fmt: skip
        return out
