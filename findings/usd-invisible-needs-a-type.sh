#!/usr/bin/env bash
# usd-core 26.11 (PyPI): visibility below prims with and without a type.
#
# `visibility = "invisible"` on a group, once an Xform, once a prim without a type (as `def "name"` writes it, and as
# an overlay of another file leaves it), once a Scope; a mesh below each. Beside it a purpose on the same groups.
# Guess: what is invisible hides all that lies below it, whatever its type; a purpose is passed down likewise.
# Seen:  below the prim without a type the mesh is visible ("inherited"): such a prim is not imageable, so its own
#        opinion does not count. Its transform does not either: a prim without a type has none, while the attributes
#        xformOp:translate and xformOpOrder stand there, and children are composed as if they did not. The purpose is
#        lost too.
. "$(dirname "$0")/lib.sh"
python_with usd-core==26.11
"$python" - <<'PY'
from pxr import Sdf, Usd, UsdGeom
from verdict import verdict

layer = Sdf.Layer.CreateAnonymous(".usda")
group = '''
def {type} "{name}"
{{
    token visibility = "invisible"
    uniform token purpose = "guide"
    double3 xformOp:translate = (5, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "mesh"
    {{
    }}
}}
'''
layer.ImportFromString("#usda 1.0\n" + "".join(group.format(type=t, name=t or "none") for t in ("Xform", "Scope", "")))
stage = Usd.Stage.Open(layer)
seen = {}
for name in ("Xform", "Scope", "none"):
    mesh = UsdGeom.Imageable(stage.GetPrimAtPath(f"/{name}/mesh"))
    place = UsdGeom.XformCache().GetLocalToWorldTransform(mesh.GetPrim()).ExtractTranslation()[0]
    seen[name] = [mesh.ComputeVisibility(), mesh.ComputePurpose(), place]
print(seen)
verdict("visibility, purpose and x of a mesh below an Xform", "invisible, guide, 5", seen["Xform"],
        ["invisible", "guide", 5.0])
verdict("below a Scope, which cannot be moved", "invisible, guide, 0", seen["Scope"], ["invisible", "guide", 0.0])
verdict("below a prim without a type", "invisible, guide, 0 or 5", seen["none"], ["inherited", "default", 0.0])
PY
