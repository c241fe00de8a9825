#!/usr/bin/env bash
# Blender 5.0.1, Mitsuba 3.9.1 (PyPI bpy, mitsuba) and ImageMagick 6.9.11 (Debian 12) open a deep OpenEXR file.
#
# A pixel stored back to front: green (0.5, alpha 0.5) at depth 2, then red at depth 1; a second pixel without samples.
# Guess: all refuse it (none knows deep images), or the picture is flattened right, R 0.5 and G 0.25.
# Seen:  all open it as a common picture without a word, with R 0.25 and G 0.5: the OpenEXR library puts the samples
#        together under the hand of programs that ask for a flat picture, in the order in which they are stored. Mitsuba
#        also has Z, 2.5, which is behind both samples. A deep
#        shadow map becomes the alpha of the whole column. A deep file without A is an error instead.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 mitsuba==3.9.1 OpenEXR==3.5.3 numpy==1.26.4
debian_with imagemagick 8:6.9.11.60+dfsg-1.6+deb12u15
cd "$work"
cat > open.py <<'PY'
import os, subprocess, sys
import bpy
from deep_file import write_deep
from verdict import verdict

write_deep("backwards.exr", ("R", "G", "B", "A", "Z"), [[(0, 0.5, 0, 0.5, 2), (0.5, 0, 0, 0.5, 1)], []])
guess = "refused, or 0.5, 0.25, 0, 0.75 and 0, 0, 0, 0"
picture = bpy.data.images.load(os.path.abspath("backwards.exr"))
recorded = [0.25, 0.5, 0.0, 0.75, 0.0, 0.0, 0.0, 0.0]
verdict("the two pixels in Blender", guess, [round(v, 3) for v in picture.pixels], recorded)
read = (
    "import mitsuba as mi, numpy as np; mi.set_variant('scalar_rgb'); bitmap = mi.Bitmap('backwards.exr');"
    "pixel = dict(zip((field.name for field in bitmap.struct_()), np.array(bitmap)[0, 0].tolist()));"
    "print(*(pixel[name] for name in 'RGBAZ'))"
)
pixel = subprocess.run([sys.executable, "-c", read], capture_output=True, text=True, check=True).stdout.split()[-5:]
verdict("R, G, B, A, Z of the first pixel in Mitsuba", guess, [float(v) for v in pixel], [0.25, 0.5, 0.0, 0.75, 2.5])
command = ["convert", "backwards.exr", "-depth", "16", "rgba:-"]
raw = subprocess.run(command, capture_output=True, check=True)
values = [round(int.from_bytes(raw.stdout[i : i + 2], "little") / 65535, 3) for i in range(0, 16, 2)]
verdict("in ImageMagick (the colours with the sRGB curve on), and its messages", guess, [values, raw.stderr.decode()],
        [[0.537, 0.735, 0.0, 0.75, 0.0, 0.0, 0.0, 0.0], ""], tolerance=2e-3)
PY
"$python" open.py | grep -E '^(question|guess|seen|CHANGED)'
