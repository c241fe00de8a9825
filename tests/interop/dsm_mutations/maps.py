"""Valid files to change: golden ones, and small maps of every kind that the program makes itself."""

from pathlib import Path

GOLDEN = Path(__file__).resolve().parents[2] / "data" / "dsm-1"
SMALL = ("--resolution", "9x7", "--tile", "4", "--quiet")
SAMPLED = (*SMALL, "--samples", "4")

# By name: the command and its arguments, OUT where the file goes, IN and a name for one of the maps before.
MADE = {
    "deep mono": ("bake", "builtin:hairball", "-o", "OUT", *SAMPLED),
    "deep rgb": ("bake", "builtin:stained-glass", "-o", "OUT", *SAMPLED, "--filter", "tent"),
    "deep plain": ("bake", "builtin:foliage", "-o", "OUT", *SAMPLED, "--block", "none", "--method", "min-link"),
    "deep quantized": ("bake", "builtin:smoke", "-o", "OUT", *SAMPLED, "--codec", "quantized", "--tolerance", "0.01"),
    "deep quantized rgb": (
        "bake", "builtin:stained-glass", "-o", "OUT", *SAMPLED, "--codec", "quantized", "--block", "none",
    ),
    "deep levels": ("bake", "builtin:pipes", "-o", "OUT", *SAMPLED, "--mip", "--side", "lighter"),
    "deep levels rgb": ("mip", "IN deep rgb", "-o", "OUT", "--quiet"),
    "deep crop": ("bake", "builtin:hairball", "-o", "OUT", *SAMPLED, "--crop", "4,0,9,4"),
    "fragments": ("bake", "builtin:fur-plane", "-o", "OUT", *SMALL, "--kind", "fragments"),
    "fragments rgb": ("bake", "builtin:stained-glass", "-o", "OUT", *SMALL, "--kind", "fragments", "--block", "none"),
    "fragments folded": ("bake", "builtin:foliage", "-o", "OUT", *SMALL, "--kind", "fragments", "--layers", "4"),
    "media": ("bake", "builtin:smoke", "-o", "OUT", *SMALL, "--kind", "fragments", "--block", "none"),
    "layers": ("bake", "builtin:foliage", "-o", "OUT", *SMALL, "--kind", "layers", "--layers", "3"),
    "layers rgb": ("bake", "builtin:stained-glass", "-o", "OUT", *SMALL, "--kind", "layers", "--block", "none"),
    "mtsm": ("bake", "builtin:hairball", "-o", "OUT", *SAMPLED, "--kind", "mtsm"),
    "mtsm rgb": ("bake", "builtin:stained-glass", "-o", "OUT", *SAMPLED, "--kind", "mtsm", "--block", "none"),
    "prefiltered": ("bake", "builtin:foliage", "-o", "OUT", *SMALL, "--kind", "prefiltered", "--levels", "y:4"),
    "prefiltered mip": (
        "bake", "builtin:stained-glass", "-o", "OUT", *SMALL, "--kind", "prefiltered", "--levels", "mip",
        "--block", "none",
    ),
    "attenuation": ("bake", "builtin:foliage", "-o", "OUT", *SMALL, "--kind", "attenuation", "--light-samples", "4"),
    "attenuation rgb": (
        "bake", "builtin:stained-glass", "-o", "OUT", *SMALL, "--kind", "attenuation", "--light-samples", "4",
        "--block", "none",
    ),
    "views": ("bake", "builtin:fur-plane", "-o", "OUT", *SMALL, "--kind", "views"),
    "views plain": (
        "bake", "builtin:foliage", "-o", "OUT", *SMALL, "--kind", "views", "--views", "9", "--block", "none",
    ),
}


def golden():
    """(name, bytes) of the golden files, which are small and of every kind."""
    paths = [*sorted(GOLDEN.glob("golden/*.dsm")), *sorted(GOLDEN.glob("*.dsm"))]
    return [(path.stem, path.read_bytes()) for path in paths]


def made(tool, folder):
    """(name, bytes) of the maps that the program makes."""
    paths = {name: Path(folder) / f"{name.replace(' ', '_')}.dsm" for name in MADE}
    files = []
    for name, arguments in MADE.items():
        places = {"OUT": paths[name], **{f"IN {other}": path for other, path in paths.items()}}
        tool.expect(*(places.get(argument, argument) for argument in arguments))
        files.append((name, paths[name].read_bytes()))
    return files
