"""The comparison itself: every scene in every way, by every kind of map and method."""

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import scenes
from embree import Truth
from measure import error
from program import write_scene
from receivers import draw

# The kind that is traced by default.
TRACED = ("fragments", "trace")
METHODS = (
    TRACED,
    ("layers", "trace"),
    ("mtsm", "trace"),
    ("deep", "filter"),
    ("layers", "filter"),
    ("mtsm", "filter"),
    ("layers", "pcf"),
    ("mtsm", "pcf"),
)
PICTURES = ("trace", "filter", "pcf", "reference")
ALL = "all"


@dataclass
class Effort:
    """How much is asked: receivers of a kind, rays along a side of the light in each half, camera rays of a half."""

    receivers: int
    side: int
    picture: int
    # With media a ray is all or nothing.
    media_side: int


FULL = Effort(400, 24, 256, 32)
SMALL = Effort(300, 16, 0, 24)


class Study:
    """Rows of errors, one a receiver kind and method."""

    def __init__(self, program, library, effort, threads, say):
        self.program, self.library, self.effort, self.threads, self.say = program, library, effort, threads, say

    def scene(self, scene, variants, every_method, picture, check):
        """All rows of a scene: every method for the variants in `every_method`."""
        truths = {}
        geometries = scene.geometries()
        if scene.has_media():
            from mitsuba_peer import Peer

            yield from self._variants(scene, variants, every_method, truths, Peer(geometries), self.effort.media_side)
            return
        with Truth(self.library, geometries, self.threads) as embree:
            yield from self._variants(scene, variants, every_method, truths, embree, self.effort.side)
            if picture:
                for variant in every_method:
                    yield from self._pictures(scene, variant, embree)
                yield self._embree_speed(scene, embree)
            if check:
                yield from self._second_opinion(scene, embree)

    def _variants(self, scene, variants, every_method, truths, peer, side):
        for variant in variants:
            light = variant.light(scene.light)
            # Where a scene stands and how large it is changes no answer.
            key = (light.shape, light.size)
            if key not in truths:
                receivers = draw(scene, light, self.effort.receivers)
                points, own = (np.concatenate([getattr(r, name) for r in receivers]) for name in ("points", "own"))
                halves = visibility(peer, light, points, own, side, 7)
                truths[key] = receivers, points, halves
            receivers, points, halves = truths[key]
            methods = METHODS if variant in every_method else (TRACED,)
            if scene.has_media():
                # Layers hold no media.
                methods = [method for method in methods if method[0] != "layers"]
            moved = points * variant.scale + np.array(variant.offset)
            yield from self._methods(scene, light, variant, methods, receivers, moved, halves)

    def _methods(self, scene, light, variant, methods, receivers, moved, halves):
        maps = {}
        with tempfile.TemporaryDirectory() as folder:
            file = write_scene(folder, scene, light, variant)
            for kind, method in methods:
                if kind not in maps:
                    maps[kind] = Path(folder) / f"{kind}.dsm"
                    baked = self.program.bake(file, maps[kind], kind)
                answers, rate = self.program.lookup(maps[kind], moved, method, scene.channels())
                rows = list(kinds_of(receivers, answers, halves))
                self.say(f"{scene.name}, {variant.name}, {kind} {method}: {rows[0][1].rmse:.4f}")
                for name, own in rows:
                    yield {
                        "scene": scene.name, "variant": variant.name, "ask": "lookup", "kind": kind, "method": method,
                        "default": (kind, method) == TRACED, "receivers": name, **own.as_json(),
                    }  # fmt: skip
                if variant == scenes.BASE and (kind, method) == TRACED:
                    yield speed(scene, kind, rate, baked)

    def _pictures(self, scene, variant, embree):
        light = variant.light(scene.light)
        # Far less than what the program leaves a surface by, and more than single precision loses.
        halves = embree.picture(light, scene.camera, self.effort.picture, 2.0**-13, 9).reshape(-1, 2, 3)
        with tempfile.TemporaryDirectory() as folder:
            file = write_scene(folder, scene, light, variant)
            for method in PICTURES:
                path = Path(folder) / "picture.exr"
                own = np.stack([self.program.render(file, path, method, seed).reshape(-1, 3) for seed in (1, 2)], 1)
                found = error(own.mean(1), halves, own)
                self.say(f"{scene.name}, {variant.name}, render {method}: {found.rmse:.4f}")
                yield {
                    "scene": scene.name, "variant": variant.name, "ask": "render", "kind": "", "method": method,
                    "default": method == "trace", "receivers": ALL, **found.as_json(),
                }  # fmt: skip

    def _embree_speed(self, scene, embree):
        receivers = draw(scene, scene.light, self.effort.receivers)
        points, own = (np.concatenate([getattr(r, name) for r in receivers]) for name in ("points", "own"))
        start = time.monotonic()
        embree.visibility(scene.light, points, own, self.effort.side, 7)
        rays = 2 * self.effort.side**2 * len(points)
        return speed(scene, "embree", rays / (time.monotonic() - start) / 1e6, embree.build_seconds)

    def _second_opinion(self, scene, embree):
        """Mitsuba against Embree, where Mitsuba has what the scene has."""
        from mitsuba_peer import Peer

        try:
            peer = Peer(scene.geometries())
        except ValueError:
            return
        receivers = draw(scene, scene.light, self.effort.receivers)
        points, own = (np.concatenate([getattr(r, name) for r in receivers]) for name in ("points", "own"))
        truth = embree.visibility(scene.light, points, own, self.effort.side, 7)
        other = peer.visibility(scene.light, points, self.effort.side, 8)
        found = error(other.mean(1), truth, other)
        self.say(f"{scene.name}, Mitsuba against Embree: {found.rmse:.4f}")
        yield {
            "scene": scene.name, "variant": scenes.BASE.name, "ask": "peers", "kind": "", "method": "mitsuba",
            "default": False, "receivers": ALL, **found.as_json(),
        }  # fmt: skip


def speed(scene, kind, rate, built):
    """Million rays a second on all threads, and seconds to build what is traced."""
    return {
        "scene": scene.name, "variant": scenes.BASE.name, "ask": "speed", "kind": kind, "method": "trace",
        "default": False, "receivers": ALL, "rate": round(rate, 3), "built": round(built, 3),
    }  # fmt: skip


def visibility(peer, light, points, own, side, seed):
    if isinstance(peer, Truth):
        return peer.visibility(light, points, own, side, seed)
    return peer.visibility(light, points, side, seed)


def kinds_of(receivers, answers, halves):
    """The error over all receivers, and of every kind."""
    yield ALL, error(answers, halves)
    start = 0
    for kind in receivers:
        end = start + len(kind.points)
        yield kind.kind, error(answers[start:end], halves[start:end])
        start = end
