"""Writes deep OpenEXR test images with the official client: generate.py OUTDIR

Each is small and aims at one thing a reader can get wrong. They are seeded: the same bytes every time.
Names that begin with `survive_` hold samples whose meaning nothing defines: a reader must stay sane, no more.
"""

import sys
from pathlib import Path

import numpy as np
import OpenEXR

WIDTH, HEIGHT = 24, 17
ALMOST_NOTHING = 2.0**-24
ALMOST_EVERYTHING = 1.0 - 2.0**-24
ALPHAS = (0.0, ALMOST_NOTHING, 0.1, 0.5, 0.9, ALMOST_EVERYTHING, 1.0)

COMPRESSIONS = {
    "none": OpenEXR.NO_COMPRESSION,
    "rle": OpenEXR.RLE_COMPRESSION,
    "zips": OpenEXR.ZIPS_COMPRESSION,
}


def above(depth):
    return np.nextafter(np.float32(depth), np.float32(np.inf))


class DeepImage:
    """Samples in the order they are added, a list of tuples a pixel; columns in the order of `names`."""

    def __init__(self, names, width=WIDTH, height=HEIGHT):
        self.names = tuple(names)
        self.width, self.height = width, height
        self.samples = [[] for _ in range(width * height)]

    def add(self, pixel, *values):
        assert len(values) == len(self.names)
        self.samples[pixel].append(values)

    def every_pixel(self, rule):
        for pixel in range(self.width * self.height):
            for values in rule(pixel):
                self.add(pixel, *values)
        return self

    def channels(self, types):
        """Object arrays of the client; `types` maps names to dtypes, float32 unless told."""
        result = {}
        for column, name in enumerate(self.names):
            array = np.empty(self.width * self.height, object)
            dtype = types.get(name, np.float32)
            for pixel, samples in enumerate(self.samples):
                if samples:
                    array[pixel] = np.array([s[column] for s in samples], np.float64).astype(dtype)
            result[name] = array.reshape(self.height, self.width)
        return result

    def header(self, compression="zips", tile=None, corner=(0, 0), **attributes):
        x, y = corner
        header = {
            "type": OpenEXR.deeptile if tile else OpenEXR.deepscanline,
            "compression": COMPRESSIONS[compression],
            "dataWindow": ((x, y), (x + self.width - 1, y + self.height - 1)),
            "displayWindow": ((0, 0), (WIDTH - 1, HEIGHT - 1)),
            **attributes,
        }
        if tile:
            header["tiles"] = tile_description(*tile)
        return header

    def part(self, name, types=(), **header):
        return OpenEXR.Part(self.header(name=name, **header), self.channels(dict(types)), name)

    def write(self, path, types=(), **header):
        with OpenEXR.File(self.header(**header), self.channels(dict(types))) as file:
            file.write(str(path))


def tile_description(width, height):
    tile = OpenEXR.TileDescription()
    tile.xSize, tile.ySize = width, height
    tile.mode = OpenEXR.ONE_LEVEL
    tile.roundingMode = OpenEXR.ROUND_DOWN
    return tile


HALF_ALPHA = {"A": np.float16}
HALF_COLOUR = {n: np.float16 for n in ("A", "AR", "AG", "AB", "RA", "GA", "BA")}


def random_points(rng, limit=6):
    """Unsorted points, some at equal depths, with the alphas that matter."""

    def rule(_):
        depths = rng.choice([1.0, 2.0, 2.5, 3.25, 7.0], rng.integers(0, limit)) + rng.choice([0.0, 0.125])
        return [(z, rng.choice(ALPHAS)) for z in depths]

    return rule


def random_volumes(rng, colours, opaque=0.05):
    """Volumes that overlap in part, exactly, and around points; `colours` alphas a sample."""

    def rule(_):
        samples = []
        for _ in range(rng.integers(0, 5)):
            z = float(rng.integers(1, 12)) * 0.5
            thickness = float(rng.choice([0.0, 0.0, 0.5, 1.0, 3.0]))
            alphas = rng.uniform(0.0, 0.95, colours)
            alphas[rng.random(colours) < opaque] = 1.0
            alphas[rng.random(colours) < 0.05] = 0.0
            samples.append((z, z + thickness, *alphas))
            if rng.random() < 0.3:
                samples.append((z, z + thickness, *rng.uniform(0.0, 0.9, colours)))
        return samples

    return rule


def points(out, rng):
    names = ("Z", "A")
    DeepImage(names).every_pixel(random_points(rng)).write(out / "points_scan_zips_float.exr")
    image = DeepImage(names).every_pixel(random_points(rng))
    image.write(out / "points_tile_rle_half.exr", HALF_ALPHA, compression="rle", tile=(8, 8))
    image.write(out / "points_tile_none_half.exr", HALF_ALPHA, compression="none", tile=(16, 5))
    image.write(out / "points_tile_zips_half.exr", {"A": np.float16, "Z": np.float16}, tile=(64, 64))

    # Many samples in few pixels, the others empty.
    crowded = DeepImage(names)
    for pixel in (0, 100, WIDTH * HEIGHT - 1):
        for z in rng.permutation(np.linspace(1.0, 50.0, 800)):
            crowded.add(pixel, z, 0.002)
    crowded.write(out / "crowded_pixels_scan_zips.exr")

    for width, height in ((1, 17), (33, 1), (1, 1)):
        image = DeepImage(names, width, height).every_pixel(random_points(rng))
        image.write(out / f"points_{width}x{height}.exr", compression="rle")

    extra = DeepImage(("R", "G", "B", "A", "Z", "id", "velocity.x", "a_layer_with_a_name_of_more_than_31_bytes.Q"))
    extra.every_pixel(lambda p: [(0.1, 0.2, 0.3, 0.5, 1.0 + p, p, -1.0, 2.0)] * (p % 3))
    extra.write(
        out / "extra_channels.exr",
        {"R": np.float16, "G": np.float16, "B": np.float16, "A": np.float16, "id": np.uint32},
        comments="channels that say nothing about light",
    )

    decreasing = DeepImage(names).every_pixel(random_points(rng))
    decreasing.write(out / "points_decreasing_y.exr", lineOrder=OpenEXR.DECREASING_Y)
    decreasing.write(out / "points_tile_decreasing_y.exr", lineOrder=OpenEXR.DECREASING_Y, tile=(8, 8))


def volumes(out, rng):
    mono, colour = ("Z", "ZBack", "A"), ("Z", "ZBack", "A", "AR", "AG", "AB")
    for compression in COMPRESSIONS:
        image = DeepImage(mono).every_pixel(random_volumes(rng, 1))
        image.write(out / f"volumes_scan_{compression}_float.exr", compression=compression)
        image = DeepImage(colour).every_pixel(random_volumes(rng, 4))
        image.write(out / f"volumes_colour_tile_{compression}_half.exr", HALF_COLOUR, compression=compression, tile=(10, 7))
    image = DeepImage(colour).every_pixel(random_volumes(rng, 4))
    image.write(out / "volumes_colour_scan_zips_float.exr")
    image = DeepImage(("Z", "ZBack", "RA", "GA", "BA")).every_pixel(random_volumes(rng, 3))
    image.write(out / "volumes_named_RA_GA_BA.exr", HALF_COLOUR)
    image = DeepImage(("Z", "ZBack", "A", "AR")).every_pixel(random_volumes(rng, 2))
    image.write(out / "volumes_only_red_has_its_own_alpha.exr")
    image = DeepImage(mono).every_pixel(random_volumes(rng, 1))
    image.write(out / "volumes_half_depths.exr", {n: np.float16 for n in mono}, compression="rle")

    # Overlaps spelled out: apart, touching, partial, nested, exact, and points at both ends and inside.
    pairs = [(1, 2, 3, 4), (1, 2, 2, 3), (1, 3, 2, 4), (1, 4, 2, 3), (1, 2, 1, 2), (1, 3, 1, 2), (1, 3, 2, 3)]
    pairs += [(1, 3, 1, 1), (1, 3, 2, 2), (1, 3, 3, 3), (1, 3, 0.5, 0.5), (1, 1, 1, 1)]
    image = DeepImage(mono)
    for pixel in range(WIDTH * HEIGHT):
        a, b, c, d = pairs[pixel % len(pairs)]
        first, second = ALPHAS[pixel // len(pairs) % len(ALPHAS)], ALPHAS[pixel // 3 % len(ALPHAS)]
        both = [(a, b, first), (c, d, second)]
        for values in both if pixel % 2 else reversed(both):
            image.add(pixel, *values)
    image.write(out / "overlaps.exr")

    image = DeepImage(mono)
    for pixel in range(WIDTH * HEIGHT):
        z = 1.0 + 0.1 * pixel
        image.add(pixel, z, z + 0.5 * (1 + pixel % 3), 1.0)
        if pixel % 2:
            image.add(pixel, z - 0.25, z + 0.25, 0.5)
        if pixel % 5 == 0:
            image.add(pixel, z, z, 0.5)
    image.write(out / "opaque_volumes.exr", compression="none")

    image = DeepImage(mono)
    for pixel in range(WIDTH * HEIGHT):
        z = np.float32(0.37 * (1 + pixel))
        back = z
        for _ in range(1 + pixel % 4):
            back = above(back)
        image.add(pixel, z, back, ALPHAS[pixel % len(ALPHAS)])
        if pixel % 3 == 0:
            image.add(pixel, back, above(back), 0.5)
    image.write(out / "thin_volumes.exr")

    # Optical depths up to 15 alone and 100 together, on thicknesses from tiny to huge.
    image = DeepImage(mono)
    for pixel in range(WIDTH * HEIGHT):
        thickness = 10.0 ** (pixel % 8 - 3)
        for layer in range(1 + pixel % 7):
            image.add(pixel, 1.0 + layer * thickness / 3, 1.0 + (1 + layer) * thickness, ALMOST_EVERYTHING)
    image.write(out / "dense_volumes.exr")

    image = DeepImage(mono).every_pixel(lambda p: [(1.0, 3.0 + p, 2.0 ** -(p % 30)), (2.0, 1.0, 0.5)])
    image.write(out / "back_before_front_is_a_point.exr")


def depths(out, rng):
    names = ("Z", "ZBack", "A")
    far = DeepImage(names)
    near = DeepImage(names)
    for pixel in range(WIDTH * HEIGHT):
        z = np.float32(1e6) + np.float32(pixel)
        far.add(pixel, z, z + rng.choice([0.0, 0.0625, 1000.0]), 0.5)
        far.add(pixel, above(z), above(z), 0.25)
        far.add(pixel, 10.0 ** rng.uniform(7, 38), 0.0, 0.125)
        near.add(pixel, -0.0 if pixel % 2 else 0.0, rng.choice([0.0, 1e-45, 1e-38, 0.5]), 0.5)
        near.add(pixel, *[10.0 ** -rng.integers(1, 45)] * 2, 0.25)
        near.add(pixel, 1e-20, 1e-10, 0.75)
    far.write(out / "far_depths.exr")
    near.write(out / "near_depths.exr")


def windows(out, rng):
    names = ("Z", "A")
    image = DeepImage(names).every_pixel(random_points(rng))
    image.write(out / "window_negative_scan.exr", corner=(-100, -7))
    image.write(out / "window_negative_tile.exr", corner=(-5, -3), tile=(8, 8), compression="none")
    image.write(out / "window_offset.exr", corner=(1000, 2000), compression="rle")

    image = DeepImage(names)
    rule = random_points(rng)
    for y in range(2, HEIGHT, 5):
        for x in range(WIDTH):
            for values in rule(None):
                image.add(y * WIDTH + x, *values)
    for compression in COMPRESSIONS:
        image.write(out / f"empty_lines_{compression}.exr", compression=compression)
    image.write(out / "empty_lines_tile.exr", tile=(4, 2))

    nothing = DeepImage(names)
    nothing.add(0, 1.0, 0.0)
    nothing.write(out / "one_transparent_sample.exr")


def no_alpha(out, rng):
    image = DeepImage(("Z",)).every_pixel(lambda p: [(z,) for z in rng.uniform(1, 9, rng.integers(0, 4))])
    image.write(out / "no_alpha_points.exr")
    image = DeepImage(("Z", "ZBack"))
    image.every_pixel(lambda p: [(z, z + 1) for z in rng.uniform(1, 9, rng.integers(0, 3))])
    image.write(out / "no_alpha_volumes.exr")


def parts(out, rng):
    left = DeepImage(("Z", "A")).every_pixel(random_points(rng))
    right = DeepImage(("Z", "ZBack", "A", "AR", "AG", "AB"), 9, 6).every_pixel(random_volumes(rng, 4))
    with OpenEXR.File([left.part("left"), right.part("right", corner=(3, -4), compression="rle")]) as file:
        file.write(str(out / "two_parts.exr"))
    with OpenEXR.File([left.part("tiles", tile=(8, 8)), right.part("lines", compression="none")]) as file:
        file.write(str(out / "two_parts_tile_and_scan.exr"))

    colour = np.linspace(0, 1, WIDTH * HEIGHT * 3, dtype=np.float32).reshape(HEIGHT, WIDTH, 3)
    flat_header = {
        "type": OpenEXR.scanlineimage,
        "compression": OpenEXR.ZIP_COMPRESSION,
        "name": "beauty",
        "dataWindow": ((0, 0), (WIDTH - 1, HEIGHT - 1)),
        "displayWindow": ((0, 0), (WIDTH - 1, HEIGHT - 1)),
    }
    beauty = OpenEXR.Part(flat_header, {"RGB": colour}, "beauty")
    with OpenEXR.File([beauty, left.part("deep")]) as file:
        file.write(str(out / "flat_colour_and_deep_part.exr"))


def flat(out, rng):
    z = rng.uniform(1.0, 20.0, (HEIGHT, WIDTH)).astype(np.float32)
    z[3:6, 4:9] = np.inf
    header = {"type": OpenEXR.scanlineimage, "dataWindow": ((-4, 2), (WIDTH - 5, HEIGHT + 1))}
    for name, compression in (("zip", OpenEXR.ZIP_COMPRESSION), ("piz", OpenEXR.PIZ_COMPRESSION)):
        with OpenEXR.File({**header, "compression": compression}, {"Z": z.copy()}) as file:
            file.write(str(out / f"flat_depth_scan_{name}.exr"))
    colour = rng.random((HEIGHT, WIDTH, 3)).astype(np.float16)
    tiled = {**header, "type": OpenEXR.tiledimage, "tiles": tile_description(8, 8)}
    with OpenEXR.File({**tiled, "compression": OpenEXR.ZIPS_COMPRESSION}, {"RGB": colour, "Z": z.copy()}) as file:
        file.write(str(out / "flat_depth_tile_with_colour.exr"))


def cameras(out, rng):
    """Matrices for row vectors, the camera looking down -z; NDC [0, 1] with y down covers the display window."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    to_camera = np.eye(4)
    to_camera[:3, :3], to_camera[3, :3] = turn, (0.5, -2.0, -30.0)
    near, far, zoom = 0.5, 200.0, 1.2
    perspective = np.zeros((4, 4))
    perspective[0, 0], perspective[1, 1] = zoom, -zoom * WIDTH / HEIGHT
    perspective[2] = (-0.5, -0.5, far / (near - far), -1.0)
    perspective[3, 2] = near * far / (near - far)
    orthographic = np.diag([1 / 6.0, -WIDTH / HEIGHT / 6.0, 1 / (near - far), 1.0])
    orthographic[3, :3] = (0.5, 0.5, near / (near - far))
    names = ("Z", "A")
    for title, lens in (("perspective", perspective), ("orthographic", orthographic)):
        matrices = {
            "worldToCamera": to_camera.astype(np.float32),
            "worldToNDC": (to_camera @ lens).astype(np.float32),
        }
        image = DeepImage(names).every_pixel(random_points(rng))
        image.write(out / f"camera_{title}.exr", **matrices)
        image = DeepImage(names, 9, 8).every_pixel(random_points(rng))
        image.write(out / f"camera_{title}_data_window_inside.exr", corner=(7, 5), **matrices)


def odd(out, rng):
    """What an importer drops (a depth not finite or behind the camera) and clamps (an alpha outside [0, 1])."""
    image = DeepImage(("Z", "A")).every_pixel(random_points(rng, 4))
    rule = [(np.nan, 0.5), (np.inf, 0.5), (-np.inf, 0.5), (-1.0, 0.5), (2.0, 1.5), (2.0, -0.5)]
    for pixel in range(WIDTH * HEIGHT):
        image.add(pixel, *rule[pixel % len(rule)])
    image.write(out / "odd_values.exr")

    image = DeepImage(("Z", "ZBack", "A")).every_pixel(random_volumes(rng, 1))
    rule = [(1.0, np.nan, 0.5), (1.0, np.inf, 0.5), (-1.0, 2.0, 0.5), (1.0, 2.0, np.nan), (1.0, -np.inf, 0.5), (2.0, 2.0, np.inf)]
    for pixel in range(WIDTH * HEIGHT):
        image.add(pixel, *rule[pixel % len(rule)])
    image.write(out / "survive_odd_backs_and_alphas.exr")


def main(out):
    out.mkdir(parents=True, exist_ok=True)
    for seed, group in enumerate((points, volumes, depths, windows, no_alpha, parts, flat, cameras, odd)):
        group(out, np.random.default_rng(seed))
    print(f"{len(list(out.glob('*.exr')))} images in {out}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.splitlines()[0])
    main(Path(sys.argv[1]))
