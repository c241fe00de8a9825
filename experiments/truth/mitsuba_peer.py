"""Mitsuba 3: the truth where there are media, and a second opinion on Embree's where there are none.

Light that passes is found by volumetric path tracing without scattering: everything is black, media only absorb, and
whatever leaves the scene meets an environment of 1. Nothing stands behind the lights.
"""

import glob
import os

import numpy as np

from geometry import MASK, Mesh, Strands, Volume, unit

# Rays at once.
WAVE = 1 << 21
# Masks are laid out finer than their texture, as Mitsuba has no cutoff: so many times, and up to this width.
FINER, WIDEST = 8, 4096


def import_mitsuba():
    """Mitsuba with the newest LLVM that has the names of 18 and later: older ones fail on processors with AVX-512."""
    found = sorted(glob.glob("/usr/lib/*/libLLVM.so.*"), key=lambda path: float(path.split(".so.")[1]))
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", found[-1])
    import mitsuba

    return mitsuba


class Peer:
    """A scene's surfaces and media in Mitsuba."""

    def __init__(self, geometries):
        mi = import_mitsuba()
        mi.set_variant("llvm_ad_rgb")
        self.mi = mi
        self.medium, self.box = None, None
        description = {"type": "scene", "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}}
        for number, geometry in enumerate(geometries):
            if isinstance(geometry, Mesh):
                description[f"mesh{number}"] = self._mesh(f"mesh{number}", geometry)
            elif isinstance(geometry, Volume):
                description["medium box"] = self._box(geometry)
            elif isinstance(geometry, Strands):
                raise ValueError("strands: Mitsuba's curves are round")
        self.scene = mi.load_dict(description)
        self.integrator = mi.load_dict({"type": "volpath", "max_depth": -1, "rr_depth": 1 << 20})

    def _black(self, opacity):
        black = {"type": "twosided", "below": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}
        return black if opacity is None else {"type": "mask", "opacity": opacity, "nested": black}

    def _mesh(self, name, mesh):
        mi = self.mi
        material = mesh.material
        if material.mode == MASK and material.alpha is not None:
            height, width = material.alpha.shape
            finer = max(1, min(FINER, WIDEST // width))
            u, v = ((np.arange(side * finer) + 0.5) / (side * finer) for side in (width, height))
            rows = [material.at(np.stack([u, np.full(len(u), row)], -1)) for row in v]
            bitmap = mi.Bitmap(np.array(rows, "f4")[:, :, None])
            opacity = {"type": "bitmap", "bitmap": bitmap, "raw": True, "filter_type": "nearest"}
        elif len(set(mesh.opacity)) > 1:
            raise ValueError("coloured opacities: Mitsuba's masks are grey")
        else:
            opacity = None if mesh.opacity[0] == 1 else float(mesh.opacity[0])
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(self._black(opacity))
        textured = mesh.uvs is not None
        made = mi.Mesh(name, len(mesh.positions), len(mesh.triangles), properties, False, textured)
        parameters = mi.traverse(made)
        parameters["vertex_positions"] = np.ascontiguousarray(mesh.positions, "f4").ravel()
        parameters["faces"] = np.ascontiguousarray(mesh.triangles, "u4").ravel()
        if textured:
            # As in glTF, v goes down: only Mitsuba's own loaders turn it.
            parameters["vertex_texcoords"] = np.ascontiguousarray(mesh.uvs, "f4").ravel()
        parameters.update()
        return made

    def _box(self, volume):
        mi = self.mi
        # A voxel's value stands in the middle of its cell; around them all one of 0.
        values = np.pad(volume.values, 1)
        low = volume.origin - 1.5 * volume.voxel
        size = np.array(values.shape) * volume.voxel
        to_world = mi.ScalarTransform4f().translate(low.tolist()).scale(size.tolist())
        grid = mi.VolumeGrid(np.ascontiguousarray(values.transpose(2, 1, 0))[..., None])
        self.medium = mi.load_dict({
            "type": "heterogeneous", "albedo": 0.0, "scale": volume.density,
            "sigma_t": {"type": "gridvolume", "grid": grid, "to_world": to_world, "wrap_mode": "clamp"},
        })  # fmt: skip
        self.box = low, low + size
        middle = mi.ScalarTransform4f().translate((low + size / 2).tolist()).scale((size / 2).tolist())
        return {"type": "cube", "to_world": middle, "bsdf": {"type": "null"}, "interior": self.medium}

    def visibility(self, light, points, side, seed):
        """The light at points, by two halves of `side`² rays with numbers of their own: (n, 2, 3)."""
        answers = np.empty((len(points), 2, 3))
        within = np.zeros(len(points), bool)
        if self.box:
            within = np.all((points > self.box[0]) & (points < self.box[1]), 1)
        random = np.random.default_rng(seed)
        for medium, chosen in ((None, np.flatnonzero(~within)), (self.medium, np.flatnonzero(within))):
            for start in range(0, len(chosen), WAVE // side**2):
                part = chosen[start : start + WAVE // side**2]
                for half in range(2):
                    answers[part, half] = self._trace(light, points[part], side, random, medium)
        return answers

    def _trace(self, light, points, side, random, medium):
        mi = self.mi
        i, j = np.divmod(np.arange(side * side), side)
        u, v = ((cell + random.uniform(0, 1, (len(points), side * side))) / side for cell in (i, j))
        to = light_points(light, points[:, None], u, v)
        start = np.repeat(points, side * side, 0)
        direction = unit(to.reshape(-1, 3) - start)
        ray = mi.RayDifferential3f(mi.Point3f(start.T.astype("f4")), mi.Vector3f(direction.T.astype("f4")))
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(int(random.integers(1 << 31)), len(start))
        light_left, _, _ = self.integrator.sample(self.scene, sampler, ray, medium)
        return np.array(light_left).T.reshape(len(points), -1, 3).mean(1)


def light_points(light, receivers, u, v):
    """Points spread evenly over a light, as receivers see it."""
    right, up = light.half_axes()
    if light.shape == "point":
        return np.broadcast_to(light.eye, (*u.shape, 3))
    if light.shape == "rectangle":
        x, y = 2 * u - 1, 2 * v - 1
    else:
        x, y = (np.sqrt(u) * f(2 * np.pi * v) for f in (np.cos, np.sin))
    if light.shape == "sphere":
        axis = unit(receivers - light.eye)
        a = unit(np.cross(axis, [1.0, 0.3, 0.2]))
        right, up = a * light.size / 2, np.cross(axis, a) * light.size / 2
    return light.eye + right * x[..., None] + up * y[..., None]
