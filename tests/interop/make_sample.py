"""Writes the deep image the documentation works with: make_sample.py [OUT.exr]

A tuft of curly, half transparent strands on a part of a round floor, and a wisp of smoke (volumetric samples),
seen by a light. Depths and alphas are rounded so that the file stays small.
"""

import sys
from pathlib import Path

import numpy as np
import OpenEXR

SIZE = 48
FIELD = 29.0  # degrees
EYE, TARGET, UP = (1.1, 2.0, 2.7), (-0.02, 0.42, 0.0), (0.0, 1.0, 0.0)
FLOOR_RADIUS = 0.5
FLOOR_CENTRE = (0.1, 0.0)
STRANDS, STEPS = 15, 600
STRAND_WIDTH = 0.03
DEPTH_STEPS = 64  # depths are multiples of one over this
ALPHA_STEPS = 16
LEAST_ALPHA = 1.0 / ALPHA_STEPS


def camera():
    """worldToCamera and worldToNDC for row vectors: right-handed, looking down -z; NDC is [0, 1] with y down."""
    eye, target, up = (np.array(v, np.float64) for v in (EYE, TARGET, UP))
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(back, right), back], axis=1)
    to_camera = np.eye(4)
    to_camera[:3, :3] = rotation
    to_camera[3, :3] = -eye @ rotation
    zoom = 0.5 / np.tan(np.radians(FIELD) / 2)
    near, far = 0.1, 100.0
    to_ndc = np.zeros((4, 4))
    to_ndc[0, 0] = zoom
    to_ndc[1, 1] = -zoom
    to_ndc[2] = (-0.5, -0.5, far / (near - far), -1.0)
    to_ndc[3, 2] = near * far / (near - far)
    return to_camera, to_camera @ to_ndc


def project(points, to_camera, to_ndc):
    """Raster x, y and depth of points (n x 3)."""
    points = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    ndc = points @ to_ndc
    return ndc[:, 0] / ndc[:, 3] * SIZE, ndc[:, 1] / ndc[:, 3] * SIZE, -(points @ to_camera)[:, 2]


def rays(to_camera):
    """Per pixel: direction in the world whose length makes ray parameter = depth; and the common origin."""
    zoom = 0.5 / np.tan(np.radians(FIELD) / 2)
    y, x = np.mgrid[:SIZE, :SIZE]
    along = np.stack([((x + 0.5) / SIZE - 0.5) / zoom, (0.5 - (y + 0.5) / SIZE) / zoom, -np.ones((SIZE, SIZE))], axis=-1)
    return np.array(EYE), along @ to_camera[:3, :3].T


def floor(samples, to_camera):
    origin, along = rays(to_camera)
    depth = -origin[1] / along[..., 1]
    hit = origin + depth[..., None] * along
    inside = np.hypot(hit[..., 0] - FLOOR_CENTRE[0], hit[..., 2] - FLOOR_CENTRE[1]) < FLOOR_RADIUS
    for y, x in np.argwhere(inside & (depth > 0)):
        samples[y * SIZE + x].append((depth[y, x], depth[y, x], 1.0))


def strands(samples, to_camera, to_ndc, rng):
    """Each pixel a strand crosses gets one sample: how much of it the strand covers, at its mean depth."""
    t = np.linspace(0.0, 1.0, STEPS)[:, None]
    for strand in range(STRANDS):
        angle, lean, height = strand * 2.4, rng.uniform(0.15, 0.6), rng.uniform(0.7, 1.0)
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        side = np.array([-out[2], 0.0, out[0]])
        root = out * rng.uniform(0.0, 0.12)
        turns, curl = rng.uniform(1.5, 2.6), rng.uniform(0.07, 0.12)
        twist = 2 * np.pi * (turns * t + rng.random())
        path = root + out * lean * t**1.7 + np.array([0.0, height, 0.0]) * (t - 0.42 * lean * t**2.5)
        path = path + curl * np.sqrt(t) * (np.cos(twist) * side + np.sin(twist) * (out + np.array([0.0, 0.5, 0.0])) / 1.2)
        x, y, depth = project(path, to_camera, to_ndc)
        scale = SIZE * 0.5 / np.tan(np.radians(FIELD) / 2) / depth
        width = STRAND_WIDTH * scale * (1.0 - 0.6 * t[:, 0])
        length = np.hypot(np.gradient(x), np.gradient(y))
        seen = (x >= 0) & (x < SIZE) & (y >= 0) & (y < SIZE)
        pixel = (np.floor(y) * SIZE + np.floor(x)).astype(int)
        for p in np.unique(pixel[seen]):
            here = seen & (pixel == p)
            alpha = 0.9 * min(1.0, float((length * width)[here].sum()))
            mean = float(depth[here].mean())
            samples[p].append((mean, mean, alpha))


def smoke(samples, to_camera):
    """A rising, widening wisp: its extinction integrated along each pixel's ray, one volumetric sample a pixel."""
    origin, along = rays(to_camera)
    stretch = np.linalg.norm(along, axis=-1)
    marched = np.arange(2.0, 4.6, 0.02)
    position = origin + marched[:, None, None, None] * along
    height = position[..., 1]
    centre_x = -0.34 + 0.13 * np.sin(5.5 * height) + 0.1 * height
    centre_z = 0.3 + 0.1 * np.cos(4.5 * height)
    radius = 0.045 + 0.09 * height
    distance = ((position[..., 0] - centre_x) ** 2 + (position[..., 2] - centre_z) ** 2) / radius**2
    density = 6.0 * np.exp(-1.5 * distance) * np.clip(height * 8, 0, 1) * np.clip((1.15 - height) * 3, 0, 1)
    density[density < 0.3] = 0.0
    optical = density.sum(axis=0) * 0.02 * stretch
    for y, x in np.argwhere(optical > 0.05):
        thick = np.flatnonzero(density[:, y, x])
        front, back = marched[thick[0]], marched[thick[-1]] + 0.02
        samples[y * SIZE + x].append((front, back, -np.expm1(-optical[y, x])))


def rounded(samples):
    """Samples in order, on the coarse grids; strands that would weigh nothing are left out."""
    result = []
    for pixel in samples:
        kept = []
        for z, back, alpha in pixel:
            alpha = round(alpha * ALPHA_STEPS) / ALPHA_STEPS
            if alpha < LEAST_ALPHA:
                continue
            front = round(z * DEPTH_STEPS) / DEPTH_STEPS
            behind = max(round(back * DEPTH_STEPS) / DEPTH_STEPS, front + 1 / DEPTH_STEPS) if back > z else front
            kept.append((front, behind, alpha))
        kept.sort()
        opaque = next((i for i, s in enumerate(kept) if s[2] == 1.0), len(kept))
        result.append(kept[: opaque + 1])
    return result


def main(path):
    rng = np.random.default_rng(20)
    to_camera, to_ndc = camera()
    samples = [[] for _ in range(SIZE * SIZE)]
    floor(samples, to_camera)
    strands(samples, to_camera, to_ndc, rng)
    smoke(samples, to_camera)
    samples = rounded(samples)
    channels = {}
    for column, name in enumerate(("Z", "ZBack", "A")):
        array = np.empty(SIZE * SIZE, object)
        for pixel, kept in enumerate(samples):
            if kept:
                array[pixel] = np.array([s[column] for s in kept], np.float16)
        channels[name] = array.reshape(SIZE, SIZE)
    header = {
        "type": OpenEXR.deepscanline,
        "compression": OpenEXR.ZIPS_COMPRESSION,
        "dataWindow": ((0, 0), (SIZE - 1, SIZE - 1)),
        "displayWindow": ((0, 0), (SIZE - 1, SIZE - 1)),
        "worldToCamera": to_camera.astype(np.float32),
        "worldToNDC": to_ndc.astype(np.float32),
        "comments": "A tuft of curls and a wisp of smoke, seen by a light.",
        "owner": "MIT OR Apache-2.0",
        "light": "key",
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))
    count = sum(map(len, samples))
    volumes = sum(s[1] > s[0] for pixel in samples for s in pixel)
    print(f"{path}: {path.stat().st_size} bytes, {count} samples, {volumes} of them volumes")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit(__doc__.splitlines()[0])
    default = Path(__file__).resolve().parents[2] / "docs/sample/tuft.exr"
    main(Path(sys.argv[1]) if len(sys.argv) == 2 else default)
