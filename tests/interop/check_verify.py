"""`verify` must notice what is wrong: any changed, missing or added byte of a map, and a map of another image.

check_verify.py --tools PROGRAM --sample FILE.exr
"""

import argparse
import json
import random
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

import deep_truth
from check_lookup import questions
from tool import Failed, Tool

CHANGED_BYTES = 400


def reads_wrong(tool, *arguments):
    """Whether verify fails in the agreed way: exit code 1 and ok = false with an error for the file."""
    code, stdout, stderr = tool.run("verify", *arguments, "--json")
    if code == 0:
        return False
    told = json.loads(stdout)
    if told["ok"] is not False or not told["files"][0]["errors"] or not any(
        line.startswith("error:") for line in stderr.splitlines()
    ):
        raise Failed(f"verify {arguments} exits with {code} but says {stdout} {stderr}")
    return True


def check_bytes(tool, image, folder):
    """Every byte is covered: changed bytes, cut ends and trailing bytes are found, and lookups never crash on them."""
    good = image.read_bytes()
    chance = random.Random(3)
    bad = Path(folder) / "bad.dsm"
    points = Path(folder) / "points.csv"
    points.write_text("x,y,z\n" + "".join(f"{x}.5,{x}.5,3\n" for x in range(0, 48, 5)))
    positions = {*range(min(64, len(good))), *range(len(good) - 64, len(good))}
    positions.update(chance.sample(range(len(good)), min(CHANGED_BYTES, len(good))))
    for position in sorted(positions):
        changed = bytearray(good)
        changed[position] ^= 1 << chance.randrange(8)
        bad.write_bytes(changed)
        if not reads_wrong(tool, bad):
            raise Failed(f"verify passes with byte {position} of {len(good)} changed")
        tool.run("lookup", bad, "--points", points, "--space", "raster")
        tool.run("inspect", bad, "--json")
    for length in sorted({0, 1, 7, 8, len(good) - 1, *chance.sample(range(len(good)), 40)}):
        bad.write_bytes(good[:length])
        if not reads_wrong(tool, bad):
            raise Failed(f"verify passes with {length} of {len(good)} bytes")
    bad.write_bytes(good + b"\0")
    if not reads_wrong(tool, bad):
        raise Failed("verify passes with a trailing byte")
    return f"{len(positions)} changed bytes of {len(good)}, cut ends and a trailing byte found"


def altered(source, change):
    """A copy of a deep image with `change` applied to the samples of its fullest pixel."""
    with OpenEXR.File(str(source), separate_channels=True) as file:
        header = {k: v for k, v in file.header().items() if k not in ("channels", "chunkCount", "version")}
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        fullest = np.argmax([0 if s is None else len(s) for s in channels["Z"].ravel()])
        pixel = np.unravel_index(fullest, channels["Z"].shape)
        change({name: values[pixel] for name, values in channels.items()})
        path = Path(source).with_name("altered.exr")
        with OpenEXR.File(header, dict(channels)) as out:
            out.write(str(path))
    return path


def difference(one, other):
    """The largest difference in the light two images of equal size let through."""
    parts = [deep_truth.read_part(path) for path in (one, other)]
    pixel, depth = (np.concatenate(both) for both in zip(*map(questions, parts)))
    return np.abs(parts[0].transmittance(pixel, depth) - parts[1].transmittance(pixel, depth)).max()


def check_against(tool, sample, image, folder):
    """A map of another image is not within the bound."""
    copy = Path(folder) / "copy.exr"
    copy.write_bytes(sample.read_bytes())

    def other_alpha(samples):
        samples["A"][0] += 0.25 if samples["A"][0] < 0.5 else -0.25

    def other_depth(samples):
        for name in {"Z", "ZBack"} & samples.keys():
            samples[name] *= 1.25

    for tolerance in (0, 0.005):
        tool.expect("convert", sample, image, "--tolerance", tolerance)
        if reads_wrong(tool, image, "--against", altered(copy, lambda samples: None)):
            raise Failed(f"at tolerance {tolerance} verify --against refuses the image the map was made of")
        for change in (other_alpha, other_depth):
            other = altered(copy, change)
            if difference(sample, other) < 0.05:
                raise ValueError(f"{change.__name__} changes too little of {sample}")
            if not reads_wrong(tool, image, "--against", other):
                raise Failed(f"at tolerance {tolerance} verify --against passes with {change.__name__}")
    return "images of another alpha and another depth refused"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tools", required=True, type=Path, help="the program dsm-tools")
    parser.add_argument("--sample", required=True, type=Path, help="a deep image")
    arguments = parser.parse_args()
    tool = Tool(arguments.tools)
    with tempfile.TemporaryDirectory() as folder:
        image = Path(folder) / "image.dsm"
        try:
            tool.expect("convert", arguments.sample, image, "--tolerance", 0)
            print(check_bytes(tool, image, folder), flush=True)
            print(check_against(tool, arguments.sample, image, folder))
        except Failed as error:
            sys.exit(f"FAILED: {error}")


if __name__ == "__main__":
    main()
