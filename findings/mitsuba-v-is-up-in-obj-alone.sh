#!/usr/bin/env bash
# Mitsuba 3.9.1 (PyPI): texture coordinates of shapes `obj`, `ply`, `rectangle` and of `mi.Mesh`.
#
# One square with the same corners and the same (u, v) at each: which uv, and which texel of a bitmap whose upper row
# is 1 and lower row 0, does the point (0.25, 0.1) get?
# Guess: the same for all four: v 0.1, the lower row.
# Seen:  `obj` turns v round on loading (0.9, lower row of the picture), the others don't (0.1, upper row), and the
#        bitmap has v = 0 at its upper row. So the same mesh as .obj and as .ply has an opacity mask upside down.
. "$(dirname "$0")/lib.sh"
python_with mitsuba==3.9.1 numpy==2.4.6
cd "$work"
"$python" - <<'PY'
from pathlib import Path
import mitsuba as mi, numpy as np
from verdict import verdict

mi.set_variant("scalar_rgb")
Path("square.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")
Path("square.ply").write_text("ply\nformat ascii 1.0\nelement vertex 4\n" + "".join(f"property float {n}\n" for n in "xyzuv")
    + "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n3 0 2 3\n")
made = mi.Mesh("made", 4, 2, has_vertex_texcoords=True)
parameters = mi.traverse(made)
parameters["vertex_positions"] = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0]
parameters["vertex_texcoords"] = [0, 0, 1, 0, 1, 1, 0, 1]
parameters["faces"] = [0, 1, 2, 0, 2, 3]
parameters.update()
picture = mi.load_dict({"type": "bitmap", "raw": True, "filter_type": "nearest",
                        "bitmap": mi.Bitmap(np.array([[[1.0]], [[0.0]]], np.float32))})
shapes = {
    "obj": mi.load_dict({"type": "obj", "filename": "square.obj"}),
    "ply": mi.load_dict({"type": "ply", "filename": "square.ply"}),
    "Mesh": made,
    "rectangle": mi.load_dict({"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0.5, 0.5, 0]).scale(0.5)}),
}
seen = {}
for name, shape in shapes.items():
    hit = mi.load_dict({"type": "scene", "shape": shape}).ray_intersect(mi.Ray3f([0.25, 0.1, 5], [0, 0, -1]))
    seen[name] = [round(float(hit.uv.y), 4), float(picture.eval_1(hit))]
verdict("[v, texel] of obj, ply, Mesh, rectangle", "[0.1, 0] four times", list(seen.values()),
        [[0.9, 0.0], [0.1, 1.0], [0.1, 1.0], [0.1, 1.0]])
PY
