#!/usr/bin/env bash
# Blender 5.0.1 (PyPI bpy): particle hair to USD and Alembic, and back.
#
# Three hairs, root radius 1, tip radius 1, radius scale 0.01, on a plane: Cycles draws them 0.02 thick.
# Guess: both files hold that thickness, as they do for Blender's newer hair curves, and reading them back gives
#        radius 0.01.
# Seen:  the USD file has no `widths`. Read back, from USD and from Alembic, every point has radius 0. Hair curves of
#        radius 0.01 come back as 0.01.
. "$(dirname "$0")/lib.sh"
python_with bpy==5.0.1 numpy==1.26.4
cd "$work"
cat > scene.py <<'PY'
import os, bpy
from cycles_scene import camera, new_scene, render, shader, strand
from verdict import verdict

WHITE = (1, 1, 1, 1)

def export(kind, path):
    new_scene()
    if kind == "particles":
        bpy.ops.mesh.primitive_plane_add()
        bpy.context.object.modifiers.new("hair", "PARTICLE_SYSTEM")
        hair = bpy.context.object.particle_systems[0].settings
        hair.type, hair.count, hair.hair_length = "HAIR", 3, 1
        hair.root_radius, hair.tip_radius, hair.radius_scale = 1, 1, 0.01
    else:
        strand([(0, 0, i / 4) for i in range(5)], 0.01, shader("ShaderNodeEmission", Color=WHITE))
    if path.endswith(".usda"):
        bpy.ops.wm.usd_export(filepath=os.path.abspath(path), export_hair=True)
    else:
        bpy.ops.wm.alembic_export(filepath=os.path.abspath(path), as_background_job=False, export_hair=True)

def radii(path):
    new_scene()
    if path.endswith(".usda"):
        bpy.ops.wm.usd_import(filepath=os.path.abspath(path))
    else:
        bpy.ops.wm.alembic_import(filepath=os.path.abspath(path), as_background_job=False)
    hair = [o for o in bpy.data.objects if o.type == "CURVES"]
    return sorted({round(point.radius, 4) for o in hair for point in o.data.points})

for kind, recorded in (("curves", [0.01]), ("particles", [0.0])):
    for path in (f"{kind}.usda", f"{kind}.abc"):
        export(kind, path)
        verdict(f"radii after {path}", [0.01], radii(path), recorded)
verdict("has the USD file of the particles `widths`", True, "widths" in open("particles.usda").read(), False)
PY
"$python" scene.py | grep -E '^(question|guess|seen|CHANGED)'
