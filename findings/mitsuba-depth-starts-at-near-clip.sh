#!/usr/bin/env bash
# Mitsuba 3.9.1 (PyPI): integrator `depth` and the AOV `depth`.
#
# A perspective camera 5 above a plane looks straight down; only `near_clip` changes. The plane is never clipped.
# Guess: 5 in the middle of the picture for every near_clip (a distance from the camera).
# Seen:  5 - near_clip in the middle, and (5 - near_clip) / cos away from it: the ray starts on the near plane and
#        the depth is counted from there. The AOV of the same picture does the same, while its `position` stays right.
. "$(dirname "$0")/lib.sh"
python_with mitsuba==3.9.1 numpy==2.4.6
"$python" - <<'PY'
import mitsuba as mi, numpy as np
from verdict import verdict

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

def depths(near):
    scene = mi.load_dict({
        "type": "scene",
        "plane": {"type": "rectangle", "to_world": T().scale(50)},
        "light": {"type": "constant"},
        "camera": {
            "type": "perspective", "fov": 2, "near_clip": near,
            "to_world": T().look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "pixel_format": "luminance"},
            "sampler": {"type": "independent", "sample_count": 16},
        },
    })
    depth = mi.render(scene, integrator=mi.load_dict({"type": "depth"}))
    aov = mi.render(scene, integrator=mi.load_dict({"type": "aov", "aovs": "d:depth,p:position"}))
    return [round(float(np.array(depth).ravel()[0]), 2), round(float(np.array(aov).ravel()[0]), 2)]

verdict("depth and AOV depth of a plane 5 away, for near_clip 0.01, 1, 3", "5 and 5, three times",
        [depths(near) for near in (0.01, 1.0, 3.0)], [[4.99, 4.99], [4.0, 4.0], [2.0, 2.0]], tolerance=1e-3)
PY
