"""Converts deep OpenEXR images and compares what lookups answer with the reference transmittance.

check_lookup.py --tools PROGRAM [--data DIR] [--generated DIR] [--sample FILE]...

Every sample depth of every pixel is asked, its float32 neighbours, the middles between and beyond both ends.
"""

import math
import sys
from pathlib import Path

import numpy as np

import deep_truth
from deep_truth import next_above, next_below
from tool import Failed, Tool, image_arguments, run_cases

GOOD = (
    "Leaves",
    "colour_only_AR_AG_AB_scan_zips",
    "oiio_deep-nosamples",
    "oiio_deep-onesample",
    "oiio_deepalpha",
    "oiio_tinydeep",
    "openexr_multivariate.deep",
    "vol_tidy_scan_zips_float",
    "vol_tidy_tile_zips_half",
    "zstd_scan_float_OPENEXR35_ONLY",
)

# Allowed difference for each tolerance asked of the conversion: the stored values are float32.
TOLERANCES = ((0.0, 1e-6), (0.005, 0.005 + 1e-7), (0.02, 0.02 + 1e-7))

FAR = np.float32(3e38)


def questions(part):
    """Pixels and depths (float32) that reach every stretch and both sides of every step of a part."""
    owner = part.sample_pixels()
    pixel = np.concatenate([owner, owner])
    depth = np.concatenate([part.z, part.z_back])
    order = np.lexsort((depth, pixel))
    pixel, depth = pixel[order], depth[order]
    new = np.ones(pixel.size, bool)
    new[1:] = (pixel[1:] != pixel[:-1]) | (depth[1:] != depth[:-1])
    pixel, depth = pixel[new], depth[new]

    between = pixel[1:] == pixel[:-1]
    first, last = np.ones(pixel.size, bool), np.ones(pixel.size, bool)
    first[1:], last[:-1] = ~between, ~between
    low, high = depth[:-1][between].astype(np.float64), depth[1:][between].astype(np.float64)
    empty = np.flatnonzero(np.diff(part.offsets) == 0)
    asked = [
        (pixel, depth),
        (pixel, next_below(depth)),
        (pixel, next_above(depth)),
        *((pixel[:-1][between], (low + share * (high - low)).astype(np.float32)) for share in (0.5, 0.125, 0.9375)),
        (pixel[first], depth[first] * np.float32(0.5)),
        (pixel[last], depth[last] * np.float32(1.5)),
        (pixel[last], np.full(int(last.sum()), FAR)),
        (empty, np.full(empty.size, np.float32(10.0))),
    ]
    pixel = np.concatenate([p for p, _ in asked])
    depth = np.concatenate([d for _, d in asked])
    # At no depth and behind the camera a lookup answers 1 by definition.
    kept = (depth > 0) & np.isfinite(depth)
    return pixel[kept], depth[kept]


def raster_points(part, pixel, depth):
    return np.stack([pixel % part.width + 0.5, pixel // part.width + 0.5, depth.astype(np.float64)], axis=1)


def worst(part, pixel, depth, low, high, got):
    """Raises `Failed` naming the point that lies furthest outside [low, high]; returns the largest |got - middle|."""
    # One channel stands for three equal ones, on either side.
    channels = max(got.shape[1], low.shape[1])
    got, low, high = (np.broadcast_to(a, (len(a), channels)) for a in (got, low, high))
    excess = np.maximum(low - got, got - high)
    excess[~np.isfinite(got)] = np.inf
    if excess.size and excess.max() > 0:
        row, channel = np.unravel_index(np.argmax(excess), excess.shape)
        x, y = pixel[row] % part.width, pixel[row] // part.width
        raise Failed(
            f"{int((excess > 0).any(axis=1).sum())} of {len(got)} points wrong; worst: pixel ({x}, {y}) "
            f"depth {depth[row]:.9g} channel {channel}: got {got[row, channel]:.9g}, "
            f"wanted {low[row, channel]:.9g} to {high[row, channel]:.9g}"
        )
    return float(np.abs(got - (low + high) / 2).max()) if got.size else 0.0


def check_values(tool, part, image, folder, asked, allowed):
    pixel, depth, expected = asked
    got = tool.lookup(image, raster_points(part, pixel, depth), folder, "--space", "raster", "--filter", "point")
    return worst(part, pixel, depth, expected - allowed, expected + allowed, got)


def check_outside(tool, part, image, folder):
    """Beside the map, at depth 0 and behind the camera there is light."""
    w, h = part.width, part.height
    points = [(-0.5, 0.5, 1e9), (w + 0.5, 0.5, 1e9), (0.5, -0.5, 1e9), (0.5, h + 0.5, 1e9), (-1e9, 1e9, 1.0)]
    points += [(0.5, 0.5, 0.0), (w - 0.5, h - 0.5, -1.0)]
    got = tool.lookup(image, np.array(points), folder, "--space", "raster", "--filter", "point")
    if (got != 1.0).any():
        raise Failed(f"{image}: outside the map lookups answer {got.tolist()}, wanted 1 everywhere")


def check_world(tool, part, image, folder):
    """Points in the world, through the matrices of the file: the display window is NDC [0, 1], y down."""
    to_camera, to_ndc = (np.asarray(part.attributes[n], np.float64) for n in ("worldToCamera", "worldToNDC"))
    (left, top), (right, bottom) = part.attributes["displayWindow"]
    corner = part.attributes["dataWindow"][0]
    owner = part.sample_pixels()
    pixel = np.concatenate([owner] * 3)
    depth = np.concatenate([part.z * np.float32(f) for f in (0.99, 1.01, 1.5)]).astype(np.float64)
    keep = depth > 0
    pixel, depth = pixel[keep], depth[keep]
    u = (pixel % part.width + 0.5 + corner[0] - left) / (right - left + 1)
    v = (pixel // part.width + 0.5 + corner[1] - top) / (bottom - top + 1)
    # Row vectors: p M = w (u, v, ., 1) and (p C)_z = -depth are three equations in p beside its own 1.
    system = np.empty((pixel.size, 3, 3))
    known = np.empty((pixel.size, 3))
    for row, share in enumerate((u, v)):
        equation = to_ndc[:, row] - share[:, None] * to_ndc[:, 3]
        system[:, row], known[:, row] = equation[:, :3], -equation[:, 3]
    system[:, 2], known[:, 2] = to_camera[:3, 2], -depth - to_camera[3, 2]
    points = np.linalg.solve(system, known[..., None])[..., 0]
    # Float32 coordinates move the depth a little: any value within 1e-5 of it will do.
    low, high = (part.transmittance(pixel, depth * f) for f in (1 + 1e-5, 1 - 1e-5))
    got = tool.lookup(image, points, folder, "--space", "world", "--filter", "point")
    worst(part, pixel, depth, low - 1e-6, high + 1e-6, got)


def check_description(tool, part, image, tolerance):
    told = tool.json("inspect", image, "--json")

    def equal(name, got, wanted):
        if got != wanted:
            raise Failed(f"{image}: inspect says {name} {got!r}, wanted {wanted!r}")

    equal("kind", told["kind"], "deep")
    equal("width", told["width"], part.width)
    equal("height", told["height"], part.height)
    equal("depth.kind", told["depth"]["kind"], "planar")
    equal("levels", len(told["levels"]), 1)
    equal("levels[0].width", told["levels"][0]["width"], part.width)
    equal("levels[0].height", told["levels"][0]["height"], part.height)
    if not math.isclose(told["tolerance"], tolerance, rel_tol=1e-6):
        raise Failed(f"{image}: inspect says tolerance {told['tolerance']}, wanted {tolerance}")
    if told["levels"][0]["max_error"] > max(tolerance, 1e-6):
        raise Failed(f"{image}: inspect says max_error {told['levels'][0]['max_error']} at tolerance {tolerance}")
    for name in ("channels", "codec", "block", "tile", "samples", "filter", "camera", "light", "attributes"):
        if name not in told:
            raise Failed(f"{image}: inspect --json has no {name}")
    # A stretch may be cut where nothing changes, never widened (an opaque volume's step stands one float32 above).
    depths = told["depth"]["min"], told["depth"]["max"]
    if part.z.size and None not in depths:
        if depths[0] < part.z.min() or depths[1] > next_above(part.z_back.max()):
            raise Failed(f"{image}: inspect says depths {depths}, the samples lie in {part.z.min()}..{part.z_back.max()}")
    return told


def check_pixel(tool, part, image):
    """The vertices of the fullest pixel lie on the reference, on both sides of every step."""
    # The fullest of those that hold light back at all.
    darkening = np.bincount(part.sample_pixels()[(part.alpha > 0).any(axis=1)], minlength=part.pixels)
    fullest = int(np.argmax(darkening))
    x, y = fullest % part.width, fullest // part.width
    told = tool.json("inspect", image, "--json", "--pixel", f"{x},{y}")
    told = told.get("pixel", told)
    if (told["x"], told["y"], told["level"]) != (x, y, 0):
        raise Failed(f"{image}: inspect --pixel {x},{y} answers for {told['x']},{told['y']} level {told['level']}")
    if not darkening[fullest]:
        if told["vertices"]:
            raise Failed(f"{image}: nothing darkens pixel {x},{y}, but it has vertices {told['vertices']}")
        return
    if not told["vertices"]:
        raise Failed(f"{image}: inspect --pixel {x},{y} lists no vertices")
    depth = np.array([v[0] for v in told["vertices"]], np.float32)
    before, after = (np.array([v[i] for v in told["vertices"]], np.float64).reshape(len(depth), -1) for i in (1, 2))
    pixel = np.full(depth.size, fullest)
    expected = part.transmittance(pixel, depth)
    worst(part, pixel, depth, expected - 1e-6, expected + 1e-6, after)
    # On a steep stretch the light one float32 earlier already differs from the left limit.
    earlier = part.transmittance(pixel, next_below(depth))
    worst(part, pixel, depth, expected - 1e-6, earlier + 1e-6, before)


def check_verify(tool, source, image, name):
    against = ("--against", source)
    if name and tool.offers("verify", "--part"):
        against += ("--part", name)
    # Without a switch that names the part, only the first can be compared.
    for extra in ((),) if name and len(against) == 2 else ((), against):
        told = tool.json("verify", image, "--json", *extra)
        if told["ok"] is not True or len(told["files"]) != 1 or told["files"][0]["errors"]:
            raise Failed(f"{image}: verify {' '.join(map(str, extra))} says {told}")


def check_image(tool, source, folder, name=None, world=True):
    """Everything about one part of one image; a line for the report."""
    part = deep_truth.read_part(source, name)
    part_switch = ("--part", name) if name else ()
    image = Path(folder) / f"{Path(source).stem}.dsm"
    pixel, depth = questions(part)
    asked = pixel, depth, part.transmittance(pixel, depth)
    report = [f"{part.z.size} samples, {depth.size} points, {part.channels} ch"]
    for tolerance, allowed in TOLERANCES:
        tool.expect("convert", source, image, "--tolerance", tolerance, *part_switch)
        check_description(tool, part, image, tolerance)
        difference = check_values(tool, part, image, folder, asked, allowed)
        if tolerance == 0.0:
            check_pixel(tool, part, image)
            check_outside(tool, part, image, folder)
            if "worldToCamera" in part.attributes and "worldToNDC" in part.attributes and world:
                check_world(tool, part, image, folder)
                report.append("world too")
        check_verify(tool, source, image, name)
        report.append(f"{difference:.2g} at {tolerance:g}")
        image.unlink()
    return ", ".join(report)


def check_survives(tool, source, folder):
    """Samples nothing defines: a refusal, or a map whose invariants hold."""
    image = Path(folder) / f"{Path(source).stem}.dsm"
    code, _, stderr = tool.run("convert", source, image, "--tolerance", 0)
    if code == 0:
        check_verify(tool, source, image, None)
        image.unlink()
        return "converted, valid"
    if code != 1 or "error:" not in stderr or image.exists():
        raise Failed(f"{source}: exit code {code}, {stderr.strip()!r}, left a file: {image.exists()}")
    return "refused"


def cases(arguments):
    """(title, check, source, rest) for everything to do."""
    if arguments.data:
        for stem in GOOD:
            # Their matrices come from renderers with other conventions.
            yield stem, check_image, arguments.data / f"{stem}.exr", (None, False)
    for source in arguments.sample:
        yield source.stem, check_image, source, ()
    if arguments.generated:
        sources = sorted(arguments.generated.glob("*.exr"))
        if not sources:
            sys.exit(f"no images in {arguments.generated}")
        for source in sources:
            if source.stem.startswith("survive_"):
                yield source.stem, check_survives, source, ()
                continue
            names = [part.name for part in deep_truth.read_parts(source)]
            yield source.stem, check_image, source, ()
            for name in names if len(names) > 1 else ():
                yield f"{source.stem}[{name}]", check_image, source, (name,)


def main():
    arguments = image_arguments(__doc__)
    tool = Tool(arguments.tools)

    def runnable(title, check, source, rest):
        return title, lambda folder: check(tool, source, folder, *rest)

    run_cases(runnable(*case) for case in cases(arguments))


if __name__ == "__main__":
    main()
