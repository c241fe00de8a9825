#!/usr/bin/env bash
# trimesh 5.2.0, Open3D 0.20.0, Blender 5.0.1 (PyPI trimesh, open3d, bpy), three.js r187 (npm three 0.187.0): the
# opacity of a material of an OBJ file.
#
# The library says `d 0.7`; or `Tr 0.3`, the transparency, which says the same.
# Guess: opacity 0.7 in each.
# Seen:  d 0.7: 0.7 in Open3D, Blender and three.js, 1 in trimesh (its main colour is opaque, the keys lie unused in
#        `kwargs`). Tr 0.3: 0.7 in Open3D and three.js, 1 in trimesh and in Blender, which leaves the line out.
. "$(dirname "$0")/lib.sh"
python_with trimesh==5.2.0 open3d==0.20.0 bpy==5.0.1 numpy==1.26.4
node_with three@0.187.0
cd "$work"
cat > node/opacity.mjs <<'JS'
import { readFileSync } from 'node:fs';
import { MTLLoader } from 'three/addons/loaders/MTLLoader.js';
const library = new MTLLoader().parse(readFileSync('../card.mtl', 'utf8'), '');
library.preload();
console.log(library.materials.card.opacity);
JS
cat > read.py <<'PY'
import subprocess
from pathlib import Path
import bpy, open3d, trimesh
from verdict import verdict

Path("card.obj").write_text("mtllib card.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl card\nf 1 2 3\n")

def opacities(line):
    Path("card.mtl").write_text(f"newmtl card\nKd 1 0 0\n{line}\n")
    mesh = trimesh.load_mesh("card.obj")
    shown = open3d.io.read_triangle_model("card.obj").materials[0].base_color[3]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.obj_import(filepath=str(Path("card.obj").resolve()))
    blender = bpy.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value
    three = subprocess.run(["node", "opacity.mjs"], cwd="node", capture_output=True, text=True, check=True).stdout
    return [round(float(v), 3) for v in (mesh.visual.material.main_color[3] / 255, shown, blender, three)]

verdict("d 0.7 in trimesh, Open3D, Blender, three.js", [0.7] * 4, opacities("d 0.7"), [1.0, 0.7, 0.7, 0.7])
verdict("Tr 0.3 in the same", [0.7] * 4, opacities("Tr 0.3"), [1.0, 0.7, 1.0, 0.7])
PY
"$python" read.py | grep -E '^(question|guess|seen|CHANGED)'
