"""The program that is measured: scene files for it, bakes, lookups and pictures."""

import csv
import io
import json
import subprocess
import time
from pathlib import Path

import numpy as np


class Failed(Exception):
    """The program did not do what it was asked."""


class Program:
    """`dsm-tools`, run with what it does by default."""

    def __init__(self, path):
        self.path = Path(path)

    def run(self, *arguments):
        command = [str(self.path), *(str(argument) for argument in arguments)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise Failed(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr.strip()}")
        return done

    def version(self):
        return self.run("--version").stdout.strip()

    def bake(self, scene, output, kind):
        """Bakes a map; the seconds that took."""
        start = time.monotonic()
        self.run("bake", scene, "-o", output, "--kind", kind, "--quiet")
        return time.monotonic() - start

    def lookup(self, map, points, method, channels):
        """The shadow factors at points of the world, (n, 3), and million rays a second."""
        table = Path(map).with_suffix(".csv")
        with table.open("w") as file:
            file.write("x,y,z\n")
            file.writelines(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist())
        done = self.run("lookup", map, "--points", table, "--method", method, "--quiet", "--stats")
        rows = list(csv.reader(io.StringIO(done.stdout)))[1:]
        stats = next(json.loads(line) for line in done.stderr.splitlines() if line.startswith("{"))
        values = np.array(rows, float)
        if len(values) != len(points):
            raise Failed(f"{len(values)} answers for {len(points)} points")
        if values.shape[1] != channels:
            raise Failed(f"{values.shape[1]} channels for {channels}")
        return np.broadcast_to(values, (len(values), 3)), stats["rays"] / stats["lookup_s"] / 1e6

    def render(self, scene, output, method, seed):
        """A picture's shadow factors, (height, width, 3)."""
        import OpenEXR

        self.run("render", scene, "-o", output, "--method", method, "--factor", "--seed", seed, "--quiet")
        with OpenEXR.File(str(output), separate_channels=True) as file:
            channels = file.channels()
            names = ["R", "G", "B"] if "R" in channels else ["Y"] * 3
            return np.stack([channels[name].pixels for name in names], -1).astype(float)


def write_scene(folder, scene, light, variant):
    """Writes the scene's files and its scene file; the path of that."""
    folder = Path(folder)
    scale, offset = variant.scale, np.array(variant.offset)

    def place(point):
        return [float(x) for x in scale * np.asarray(point, float) + offset]

    camera = scene.camera
    lines = [
        "[camera]", f"eye = {place(camera.eye)}", f"target = {place(camera.target)}", f"fov = {camera.fov}",
        f"resolution = {list(camera.resolution)}",
        "[light]", f"eye = {place(light.eye)}", f"target = {place(light.target)}", f"up = {list(light.up)}",
        f"fov = {light.fov}", f'shape = "{light.shape}"',
    ]  # fmt: skip
    size = light.size * scale
    lines.append(f"size = [{size!r}, {size!r}]" if light.shape == "rectangle" else f"radius = {size / 2!r}")
    for thing in scene.things:
        path = thing.write(folder)
        lines += ["[[object]]", f"{thing.key} = {json.dumps(str(path))}"]
        if thing.key == "volume":
            lines.append(f"density = {thing.geometry[0].density / scale!r}")
        else:
            opacity = [float(channel) for channel in thing.opacity]
            lines.append(f"opacity = {opacity if len(set(opacity)) > 1 else opacity[0]}")
        lines.append(f"transform = {{ translate = {place(thing.translate)}, scale = {float(thing.scale * scale)!r} }}")
    path = folder / "scene.toml"
    path.write_text("\n".join(lines) + "\n")
    return path
