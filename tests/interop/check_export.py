"""Writes maps back to deep OpenEXR and reads the result with both official clients.

check_export.py --tools PROGRAM [--data DIR] [--generated DIR] [--sample FILE]...

The light through every pixel must be what the source lets through, in each layout, type and compression.
"""

import itertools
from functools import partial
from pathlib import Path

import numpy as np

import deep_truth
from check_lookup import questions, worst
from tool import Failed, Tool, image_arguments, run_cases

LAYOUTS, TYPES, COMPRESSIONS = ("scanline", "tiled"), ("float", "half"), ("zips", "rle", "none", "zstd")

# Depths are kept whole; the alphas of a product round, in half to 11 bits.
ALLOWED = {"float": 1e-6, "half": 2e-3}

REAL = ("colour_only_AR_AG_AB_scan_zips", "oiio_deepalpha", "oiio_deep-nosamples", "openexr_multivariate.deep")
REAL += ("vol_tidy_scan_zips_float", "vol_tidy_tile_zips_half")
GENERATED = ("opaque_volumes", "overlaps", "thin_volumes", "window_negative_tile", "empty_lines_rle", "points_1x17")
GENERATED += ("volumes_colour_scan_zips_float", "volumes_only_red_has_its_own_alpha", "one_transparent_sample", "near_depths")
GENERATED += ("camera_perspective_data_window_inside", "far_depths", "dense_volumes", "flat_depth_scan_zip")


def same_window(source, written):
    for name in ("dataWindow", "displayWindow"):
        if np.any(np.asarray(source.attributes[name]) != np.asarray(written.attributes[name])):
            raise Failed(f"{name} {written.attributes[name]}, wanted {source.attributes[name]}")


def same_matrices(source, written):
    for name in ("worldToCamera", "worldToNDC"):
        if name not in source.attributes:
            continue
        if name not in written.attributes:
            raise Failed(f"{name} is lost")
        # The sources look along -z of their camera space, what is written along +z, as OpenEXR defines it.
        turned = np.diag([1.0, 1.0, -1.0 if name == "worldToCamera" else 1.0, 1.0])
        wanted = np.asarray(source.attributes[name]).reshape(4, 4) @ turned
        if not np.allclose(np.asarray(written.attributes[name]).reshape(4, 4), wanted, rtol=1e-5, atol=1e-5):
            raise Failed(f"{name} {written.attributes[name]}, wanted {wanted}")


def half_can_hold(source):
    """No volume's alpha that lets light through would round to 1: then the volume would block from its front on."""
    volume = source.z_back > source.z
    return not ((source.alpha < 1) & (source.alpha.astype(np.float16) == 1))[volume].any()


def check(tool, path, folder, matrices):
    source = deep_truth.read_part(path)
    pixel, depth = questions(source)
    expected = source.transmittance(pixel, depth)
    image, out = Path(folder) / "image.dsm", Path(folder) / "out.exr"
    tool.expect("convert", path, image, "--tolerance", 0)
    report = []
    types = TYPES if half_can_hold(source) else TYPES[:1]
    combinations = list(itertools.product(LAYOUTS, types, COMPRESSIONS))
    if source.z.size > 20000:
        combinations = combinations[:: len(COMPRESSIONS) + 1]
    largest = {}
    for layout, kind, compression in combinations:
        switches = ("--exr-layout", layout, "--exr-type", kind, "--exr-compression", compression)
        try:
            tool.expect("convert", image, out, *switches)
            (written,) = deep_truth.read_parts(out)
            (again,) = deep_truth._read_with_openimageio(str(out))
            for name in ("offsets", "z", "z_back", "alpha"):
                if not np.array_equal(getattr(written, name), getattr(again, name)):
                    raise Failed(f"the two clients read different {name}")
            same_window(source, written)
            if matrices:
                same_matrices(source, written)
            low, high = expected - ALLOWED[kind], expected + ALLOWED[kind]
            difference = worst(source, pixel, depth, low, high, written.transmittance(pixel, depth))
        except Failed as error:
            raise Failed(f"{' '.join(switches)}: {error}") from error
        largest[kind] = max(largest.get(kind, 0.0), difference)
        out.unlink()
    report.append(f"{len(combinations)} ways")
    report += [f"{kind} within {value:.2g}" for kind, value in largest.items()]
    return ", ".join(report)


def main():
    arguments = image_arguments(__doc__)
    tool = Tool(arguments.tools)
    sources = [(path, True) for path in arguments.sample]
    if arguments.generated:
        sources += [(arguments.generated / f"{stem}.exr", True) for stem in GENERATED]
    if arguments.data:
        sources += [(arguments.data / f"{stem}.exr", False) for stem in REAL]
    run_cases((path.stem, partial(check, tool, path, matrices=matrices)) for path, matrices in sources)


if __name__ == "__main__":
    main()
