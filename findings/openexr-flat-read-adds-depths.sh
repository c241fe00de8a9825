#!/usr/bin/env bash
# OpenEXR 3.5.3 (PyPI): a deep file opened with the flat reader `OpenEXR.InputFile`.
#
# Ten samples of a thin fog, each alpha 0.1, all at depth 5. The flat reader puts samples together on its own.
# Guess: alpha 0.6513, and Z 5: the front depth, or a mean of equal depths.
# Seen:  Z 32.57. Depth is put together as if it were a colour already multiplied by alpha, without the
#        multiplication: every sample adds (1 - alpha so far) * Z, so that ten equal depths add up. The flat
#        depth lies far behind everything in the pixel, and moves when one sample is split into two.
. "$(dirname "$0")/lib.sh"
python_with OpenEXR==3.5.3 numpy==2.4.6
cd "$work"
"$python" - <<'PY'
import numpy as np, OpenEXR
from deep_file import write_deep
from verdict import verdict

def flat(path):
    file = OpenEXR.InputFile(path)
    return [float(np.frombuffer(file.channel(name), np.float32)[0]) for name in "AZ"]

write_deep("fog.exr", "AZ", [[(0.1, 5)] * 10])
verdict("A and Z of ten samples (A 0.1, Z 5)", "0.6513 and 5", flat("fog.exr"), [0.6513216, 32.56608])
write_deep("one.exr", "AZ", [[(0.75, 5)]])
write_deep("two.exr", "AZ", [[(0.5, 5), (0.5, 5)]])
verdict("the same surface as one sample, and split into two of alpha 0.5: Z", "5 and 5",
        [flat("one.exr")[1], flat("two.exr")[1]], [5.0, 7.5])
PY
