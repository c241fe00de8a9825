"""USD stages in every encoding, and what usd-core reads in them.

    pip install usd-core numpy
    python make.py [FOLDER [SEED COUNT]]

Writes text/NAME.usda, binary/NAME.usdc, packed/NAME.usdz and NAME.toml: the shapes of
the stage in the order of their paths. With SEED and COUNT it writes random stages.
"""

import math
import os
import random
import sys

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils, Vt

FOLDER = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))


# What is expected: read through usd-core, curves evaluated here.

BASES = {
    # Rows: weights of the control points for 1, t, t², t³.
    "bezier": [[1, -3, 3, -1], [0, 3, -6, 3], [0, 0, 3, -3], [0, 0, 0, 1]],
    "bspline": [[1 / 6, -1 / 2, 1 / 2, -1 / 6], [4 / 6, 0, -1, 1 / 2],
                [1 / 6, 1 / 2, 1 / 2, -1 / 2], [0, 0, 0, 1 / 6]],
    "catmullRom": [[0, -1 / 2, 1, -1 / 2], [1, 0, -5 / 2, 3 / 2],
                   [0, 1 / 2, 2, -3 / 2], [0, 0, -1 / 2, 1 / 2]],
}
STEPS = [0, 0.25, 0.5, 0.75, 1]


def at(attribute, time):
    """The value at a time; without one the default, else the earliest sample."""
    if time is not None:
        return attribute.Get(time)
    if attribute.GetResolveInfo().GetSource() == Usd.ResolveInfoSourceDefault:
        return attribute.Get()
    value = attribute.Get(Usd.TimeCode.Default())
    if value is None and attribute.GetTimeSamples():
        value = attribute.Get(attribute.GetTimeSamples()[0])
    return value


def code(time):
    return Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)


def evaluate(kind, basis, wrap, control, segment):
    """Values at the steps of a segment of a curve with these control values."""
    control, n = np.asarray(control, float), len(control)
    if kind == "linear":
        a, b = control[segment], control[(segment + 1) % n]
        return [a + (b - a) * t for t in STEPS]
    if wrap == "pinned" and basis != "bezier":
        head, tail = 2 * control[0] - control[1], 2 * control[-1] - control[-2]
        control = np.concatenate([[head], control, [tail]])
    step = 3 if basis == "bezier" else 1
    index = [segment * step + i for i in range(4)]
    if wrap == "periodic":
        index = [i % n for i in index]
    weights = np.array(BASES[basis]) @ np.array([[t ** k for t in STEPS] for k in range(4)])
    return list(weights.T @ control[index])


def spread(values, interpolation, kind, basis, wrap, n, curve, offsets, segments, segment):
    """A primvar at the steps of a segment."""
    if interpolation == "constant":
        return [values[0]] * len(STEPS)
    if interpolation == "uniform":
        return [values[curve]] * len(STEPS)
    if interpolation == "vertex":
        first = offsets["vertex"]
        return evaluate(kind, basis, wrap, values[first:first + n], segment)
    first = offsets["varying"]
    size = segments + (wrap != "periodic")
    a, b = values[first + segment], values[first + (segment + 1) % size]
    return [a + (b - a) * t for t in STEPS]


def opacity_of(prim, time):
    """Values and interpolation of the nearest opacity."""
    found = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayOpacity")
    if not found or not found.HasValue():
        return [1.0], "constant"
    values = found.ComputeFlattened(code(time)) if time is not None else None
    if values is None:
        values = list(at(found.GetAttr(), time))
        indices = at(found.GetIndicesAttr(), time) if found.IsIndexed() else None
        values = [values[i] for i in indices] if indices else values
    return [min(max(float(v), 0.0), 1.0) for v in values], found.GetInterpolation()


def widths_of(prim, time):
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("widths")
    if primvar and primvar.HasValue():
        values, interpolation = list(at(primvar.GetAttr(), time)), primvar.GetInterpolation()
        indices = at(primvar.GetIndicesAttr(), time) if primvar.IsIndexed() else None
        return ([values[i] for i in indices] if indices else values), interpolation
    schema = UsdGeom.Curves(prim) if prim.IsA(UsdGeom.Curves) else UsdGeom.Points(prim)
    values = at(schema.GetWidthsAttr(), time)
    if values is None:
        return [1.0], "constant"
    return list(values), schema.GetWidthsInterpolation()


def shape(prim, matrix, time, outer):
    """A shape's numbers in the world."""
    world = lambda p: list(matrix.Transform(Gf.Vec3d(*map(float, p))))
    m = np.array([[matrix[i][j] for j in range(3)] for i in range(3)])
    scale = abs(np.linalg.det(m)) ** (1 / 3)
    points = [world(p) for p in at(UsdGeom.PointBased(prim).GetPointsAttr(), time) or []]
    opacity, how = opacity_of(prim, time)
    if outer is not None and not UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayOpacity"):
        opacity, how = [outer], "constant"
    item = {"path": str(prim.GetPath()), "kind": prim.GetTypeName()}
    if prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        counts = at(mesh.GetFaceVertexCountsAttr(), time) or []
        corners = at(mesh.GetFaceVertexIndicesAttr(), time) or []
        holes = set(at(mesh.GetHoleIndicesAttr(), time) or [])
        item.update(faces=[], corners=[], opacities=[])
        first = 0
        for face, count in enumerate(counts):
            if face not in holes:
                item["faces"].append(count)
                for corner in range(first, first + count):
                    point = corners[corner]
                    item["corners"] += points[point]
                    key = {"constant": 0, "uniform": face, "varying": point, "vertex": point,
                           "faceVarying": corner}[how]
                    item["opacities"].append(opacity[key])
            first += count
        return item
    widths, width_how = widths_of(prim, time)
    item.update(lengths=[], corners=[], widths=[], opacities=[])
    if prim.IsA(UsdGeom.Points):
        for i, point in enumerate(points):
            item["corners"] += point
            item["widths"].append(widths[0 if width_how == "constant" else i] * scale)
            item["opacities"].append(opacity[0 if how == "constant" else i])
        return item
    curves = UsdGeom.BasisCurves(prim)
    kind, basis, wrap = (at(a, time) for a in
                         (curves.GetTypeAttr(), curves.GetBasisAttr(), curves.GetWrapAttr()))
    counts = at(curves.GetCurveVertexCountsAttr(), time)
    offsets = {"vertex": 0, "varying": 0}
    for curve, n in enumerate(counts):
        if kind == "linear":
            segments = n if wrap == "periodic" else n - 1
        elif basis == "bezier":
            segments = n // 3 if wrap == "periodic" else (n - 1) // 3
        else:
            segments = {"periodic": n, "pinned": n - 1, "nonperiodic": n - 3}[wrap]
        control = points[offsets["vertex"]:offsets["vertex"] + n]
        item["lengths"].append(segments * len(STEPS))
        for segment in range(segments):
            place = (kind, basis, wrap, n, curve, offsets, segments, segment)
            for point in evaluate(kind, basis, wrap, control, segment):
                item["corners"] += list(point)
            item["widths"] += [max(w, 0.0) * scale for w in spread(widths, width_how, *place)]
            item["opacities"] += [min(max(o, 0.0), 1.0) for o in spread(opacity, how, *place)]
        offsets["vertex"] += n
        offsets["varying"] += segments + (wrap != "periodic")
    # The sizes of primvars are usd-core's, but where it does not count as it documents.
    if kind == "linear" and wrap == "nonperiodic" or kind == "cubic" and wrap != "pinned":
        assert offsets["varying"] == curves.ComputeVaryingDataSize(code(time)), (kind, basis, wrap)
    return item


def is_drawn(prim, time):
    image = UsdGeom.Imageable(prim)
    return (not image or image.ComputePurpose() in ("default", "render")), (
        not image or image.ComputeVisibility(code(time)) != "invisible")


def walk(prim, base, time, items, cache, root=None, outer=None):
    """Adds the shapes at and below a prim, as usd-core places them."""
    drawn, visible = is_drawn(prim, time)
    if not visible or not prim.IsActive() or prim.IsAbstract() and root is None:
        return
    if prim.IsA(UsdGeom.PointInstancer):
        return instancer(prim, base, time, items, cache, root, outer) if drawn else None
    if prim.GetTypeName() in ("Mesh", "BasisCurves", "Points") and drawn:
        items.append(shape(prim, place(prim, base, time, cache, root), time, outer))
    children = prim.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsDefined & ~Usd.PrimIsAbstract)) \
        if root is None else prim.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimIsActive))
    for child in sorted(children, key=lambda c: c.GetName()):
        walk(child, base, time, items, cache, root, outer)


def place(prim, base, time, cache, root):
    """To the world; below a prototype, to where that lies, and on with the base."""
    world = cache.GetLocalToWorldTransform(prim)
    if root is None:
        return world
    return world * cache.GetParentToWorldTransform(root).GetInverse() * base


def instancer(prim, base, time, items, cache, root, outer):
    instancer = UsdGeom.PointInstancer(prim)
    which = at(instancer.GetProtoIndicesAttr(), time)
    mask = instancer.ComputeMaskAtTime(code(time)) or [True] * len(which)
    places = instancer.ComputeInstanceTransformsAtTime(
        code(time), code(time), UsdGeom.PointInstancer.ExcludeProtoXform,
        UsdGeom.PointInstancer.IgnoreMask)
    to_world = place(prim, base, time, cache, root)
    paths = instancer.GetPrototypesRel().GetForwardedTargets()
    own = UsdGeom.PrimvarsAPI(prim).GetPrimvar("displayOpacity")
    values = at(own.GetAttr(), time) if own and own.HasValue() else None
    for copy, prototype in enumerate(which):
        if not mask[copy]:
            continue
        found = prim.GetStage().GetPrimAtPath(paths[prototype])
        opacity = float(values[copy]) if values and len(values) == len(which) else outer
        walk(found, places[copy] * to_world, time, items, cache, found, opacity)


def expect(stage, times):
    lines = []
    for time in times:
        lines.append("[[stage]]")
        if time is not None:
            lines.append(f"time = {float(time)}")
        items = []
        walk(stage.GetPseudoRoot(), None, time, items, UsdGeom.XformCache(code(time)))
        for item in items:
            lines.append("[[stage.item]]")
            for key, value in item.items():
                if isinstance(value, str):
                    lines.append(f'{key} = "{value}"')
                else:
                    kind = int if key in ("faces", "lengths") else lambda v: float(f"{float(v):.9g}")
                    lines.append(f"{key} = [{', '.join(str(kind(v)) for v in value)}]")
    return "\n".join(lines) + "\n"


def write(name, root, times, others=()):
    """A root layer, and layers that it names with `.usd`, in every encoding."""
    for folder in ("text", "binary", "packed"):
        os.makedirs(os.path.join(FOLDER, folder), exist_ok=True)
    for folder, kind in (("text", "usda"), ("binary", "usdc")):
        for other, layer in others:
            layer.Export(os.path.join(FOLDER, folder, other + ".usd"), args={"format": kind})
        root.Export(os.path.join(FOLDER, folder, f"{name}.{kind}"))
    text = os.path.join(FOLDER, "text", name + ".usda")
    packed = os.path.join(FOLDER, "packed", name + ".usdz")
    UsdUtils.CreateNewUsdzPackage(os.path.join(FOLDER, "binary", name + ".usdc"), packed)
    with open(os.path.join(FOLDER, name + ".toml"), "w") as file:
        file.write(expect(Usd.Stage.Open(text), times))


# The stages.


def layer(text):
    made = Sdf.Layer.CreateAnonymous(".usda")
    # usd-core wants a line of its own for each statement.
    assert made.ImportFromString("#usda 1.0\n" + text.replace(" }", "\n}")), text
    return made


QUAD = "int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n" \
    "point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n"


def meshes():
    return layer('''(
    upAxis = "Y"
    metersPerUnit = 1
)
def Xform "World" (doc = """A text
with (brackets) and "quotes".""") {
    double3 xformOp:translate = (1, 2, 3)
    float xformOp:rotateX:first = 20
    float3 xformOp:rotateZXY = (10, 20, 30)
    quatf xformOp:orient = (0.5, 0.5, -0.5, 0.5)
    float3 xformOp:scale:uneven = (1, 2, -0.5)
    float3 xformOp:translate:pivot = (0.5, 0.25, 1)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:translate:pivot",
        "xformOp:rotateX:first", "xformOp:rotateZXY", "xformOp:orient", "xformOp:scale:uneven",
        "!invert!xformOp:translate:pivot"]
    float[] primvars:displayOpacity = [0.25] (interpolation = "constant")
    def Mesh "Cage" {
        uniform token subdivisionScheme = "catmullClark"
        int[] faceVertexCounts = [4, 3, 5]
        int[] faceVertexIndices = [0, 1, 2, 3, 1, 4, 2, 0, 3, 5, 6, 7]
        int[] holeIndices = [1]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.5), (2, 0, 1e-1),
            (-1, 1, 0), (-0.5, 0.3, 0), (-1, -1, 0)]
        matrix4d xformOp:transform = ((1, 0, 0, 0), (0.5, 1, 0, 0), (0, 0, 2, 0), (4, 5, 6, 1))
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }
    def Mesh "Faces" {
        QUAD
        float[] primvars:displayOpacity = [0.75] (interpolation = "uniform")
    }
    def Mesh "Corners" {
        int[] faceVertexCounts = [4, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 2, 1, 0]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        float[] primvars:displayOpacity = [0.125, 0.5, 1] (interpolation = "faceVarying")
        int[] primvars:displayOpacity:indices = [0, 1, 2, 1, 0, 1, 2]
    }
    def Scope "Group" {
        double3 xformOp:translate = (9, 9, 9)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Mesh "Vertices" {
            QUAD
            float[] primvars:displayOpacity = [0, 0.5, 1, 2] (interpolation = "vertex")
        }
    }
    def Mesh "Reset" {
        QUAD
        double xformOp:rotateY = 90
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:rotateY"]
    }
    def "Hidden" {
        token visibility = "invisible"
        def Mesh "Below" { QUAD token visibility = "inherited" }
    }
    def Xform "Proxy" {
        uniform token purpose = "proxy"
        def Mesh "Not" { QUAD }
        def Mesh "Drawn" { QUAD uniform token purpose = "render" }
    }
    def Mesh "Guide" { QUAD uniform token purpose = "guide" }
    over Mesh "Over" { QUAD }
    class Mesh "Class" { QUAD }
    def Mesh "Off" (active = false) { QUAD }
    def Mesh "Empty" { }
    def Camera "Eye" { def Mesh "OnIt" { QUAD } }
}
'''.replace("QUAD", QUAD))


def numbers(values):
    if isinstance(values[0], (list, tuple)):
        return "[" + ", ".join(f"({', '.join(f'{v:.7g}' for v in value)})" for value in values) + "]"
    return "[" + ", ".join(f"{v:.7g}" for v in values) + "]"


KINDS = [("linear", "bezier", wrap) for wrap in ("nonperiodic", "periodic", "pinned")]
KINDS += [("cubic", basis, wrap) for basis in ("bezier", "bspline", "catmullRom")
          for wrap in ("nonperiodic", "periodic", "pinned")]


def sizes(kind, basis, wrap, n):
    if kind == "linear":
        segments = n if wrap == "periodic" else n - 1
    elif basis == "bezier":
        segments = n // 3 if wrap == "periodic" else (n - 1) // 3
    else:
        segments = {"periodic": n, "pinned": n - 1, "nonperiodic": n - 3}[wrap]
    return segments + (wrap != "periodic")


def curves_prim(name, kind, basis, wrap, how, opacity_how, rng, extra=""):
    counts = [rng.choice([6, 9] if basis == "bezier" and wrap == "periodic" else [4, 7, 10])
              for _ in range(rng.choice([1, 2, 3]))]
    total, varying = sum(counts), sum(sizes(kind, basis, wrap, n) for n in counts)
    size = {"constant": 1, "uniform": len(counts), "varying": varying, "vertex": total}
    points = [[rng.uniform(-2, 2) for _ in range(3)] for _ in range(total)]
    widths = [rng.uniform(0.05, 0.3) for _ in range(size[how])]
    opacity = [rng.uniform(0, 1) for _ in range(size[opacity_how])]
    return f'''def BasisCurves "{name}" {{
        uniform token type = "{kind}"
        uniform token basis = "{basis}"
        uniform token wrap = "{wrap}"
        int[] curveVertexCounts = {counts}
        point3f[] points = {numbers(points)}
        float[] widths = {numbers(widths)} (interpolation = "{how}")
        float[] primvars:displayOpacity = {numbers(opacity)} (interpolation = "{opacity_how}")
        {extra}
    }}
'''


def curves():
    rng = random.Random(7)
    how = ["constant", "uniform", "varying", "vertex"]
    prims = [curves_prim(f"c{i:02}", *kind, how[i % 4], how[(i // 4 + i) % 4], rng)
             for i, kind in enumerate(KINDS)]
    usual = '''def BasisCurves "usual" {
        int[] curveVertexCounts = [4]
        point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)]
        float[] primvars:widths = [0.25, 0.5] (interpolation = "vertex")
        int[] primvars:widths:indices = [0, 1, 1, 0]
        float[] widths = [9]
    }
'''
    return layer('def Xform "World" { float3 xformOp:scale = (2, 2, 2)\n'
                 'uniform token[] xformOpOrder = ["xformOp:scale"]\n' + "".join(prims) + usual + "}\n")


def points():
    return layer('''
def Points "Even" {
    point3f[] points = [(0, 0, 0), (1, 2, 3)]
    float[] widths = [0.5] (interpolation = "constant")
    int64[] ids = [7, 9007199254740991]
}
def Points "Each" {
    point3f[] points = [(0, 0, 0), (1, 2, 3), (-1, 0.5, 2)]
    float[] widths = [0.5, 0.25, 1]
    float[] primvars:displayOpacity = [0.5, 0.25, 1] (interpolation = "varying")
    float3 xformOp:scale = (3, 3, 3)
    uniform token[] xformOpOrder = ["xformOp:scale"]
}
def Points "None" { point3f[] points = [(5, 5, 5)] }
'''
                 # Binary files have tables of few different numbers, and whole numbers.
                 + many("Table", [0.5, 0.25, 0.125], [0.5, 1]) + many("Whole", range(1, 25), [1]))


def many(name, widths, opacities):
    places = [(i, i * i % 7, -i) for i in range(24)]
    pick = lambda values: [list(values)[i * i % len(values)] for i in range(24)]
    return f'''def Points "{name}" {{
        point3f[] points = {numbers(places)}
        float[] widths = {numbers(pick(widths))}
        float[] primvars:displayOpacity = {numbers(pick(opacities))} (interpolation = "vertex")
    }}
'''


def instances():
    return layer('''(
    defaultPrim = "World"
)
class "_base" { float[] primvars:displayOpacity = [0.5]
    def Mesh "Inherited" { QUAD } }
class Xform "_tree" {
    def Mesh "Leaf" { QUAD }
    def "Deep" { def BasisCurves "Stem" {
        uniform token type = "linear"
        int[] curveVertexCounts = [2]
        point3f[] points = [(0, 0, 0), (0, 1, 0)]
        float[] widths = [0.1] (interpolation = "constant")
    } }
}
def Xform "World" {
    def Xform "A" (instanceable = true
        prepend references = </_tree>) {
        double3 xformOp:translate = (1, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        over "Leaf" { token visibility = "invisible" }
        def Mesh "Extra" { QUAD }
    }
    def Xform "B" (references = [</_tree>, </World/Other>]
        inherits = </_base>) {
        over "Leaf" { double xformOp:translateX = 4
            uniform token[] xformOpOrder = ["xformOp:translateX"] }
        def Mesh "Extra" { QUAD }
    }
    def Xform "Other" { def Mesh "More" { QUAD } }
    def Xform "Variants" (variants = { string shape = "two"
        string look = "none" }
        prepend variantSets = ["shape", "look"]) {
        variantSet "shape" = {
            "one" { def Mesh "One" { QUAD } }
            "two" (payload = </World/Other>) {
                def Mesh "Two" { QUAD }
                variantSet "inner" = { "x" { def Mesh "X" { QUAD } } }
            }
        }
    }
    def Xform "Chosen" (references = </World/Variants>
        variants = { string shape = "one" }) { }
    def PointInstancer "Copies" {
        double3 xformOp:translate = (0, 10, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        rel prototypes = [</World/Copies/P/Tree>, <P/Quad>, </World/Nested>]
        int[] protoIndices = [0, 1, 1, 0, 2]
        int64[] ids = [10, 11, 12, 13, 14]
        int64[] invisibleIds = [12]
        point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 1, 1), (0, 0, 7)]
        quath[] orientations = [(1, 0, 0, 0), (0.7071, 0.7071, 0, 0), (1, 0, 0, 0), (0.5, 0.5, 0.5, 0.5),
            (0.7071, 0, 0, 0.7071)]
        float3[] scales = [(1, 1, 1), (1, 2, 3), (1, 1, 1), (2, 2, 2), (-1, 1, 1)]
        float[] primvars:displayOpacity = [0.1, 0.2, 0.3, 0.4, 0.5] (interpolation = "varying")
        def "P" {
            def Xform "Tree" (references = </_tree>) {
                double3 xformOp:translate = (0, 0, 100)
                uniform token[] xformOpOrder = ["xformOp:translate"]
            }
            def Mesh "Quad" { QUAD }
        }
    }
    over PointInstancer "Nested" {
        rel prototypes = </World/Copies/P/Quad>
        int[] protoIndices = [0, 0]
        point3f[] positions = [(0, 0, 0), (0, 5, 0)]
    }
}
def "Again" (references = </World>) { }
'''.replace("QUAD", QUAD))


def time():
    return layer('''(
    timeCodesPerSecond = 24
    startTimeCode = 1
    endTimeCode = 9
)
def Xform "World" {
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 5: (4, 0, 0), 9: (4, 8, 0), }
    quatf xformOp:orient.timeSamples = { 1: (1, 0, 0, 0), 9: (0.70710678, 0.70710678, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]
    def Mesh "Moving" {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points.timeSamples = {
            1: [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
            3: [(0, 0, 2), (1, 0, 2), (0, 1, 4)]
        }
        token visibility.timeSamples = { 1: "inherited", 6: "invisible" }
    }
    def Points "Born" {
        point3f[] points.timeSamples = { 1: [(0, 0, 0)], 4: [(1, 0, 0), (2, 0, 0)] }
        float[] widths.timeSamples = { 1: [0.5], 4: [0.25, 0.75] }
        float[] primvars:displayOpacity.timeSamples = { 1: [0.5], 5: [1] }
    }
    def Mesh "Still" { QUAD }
}
'''.replace("QUAD", QUAD))


def composed():
    """A root over sublayers, with references into other files at other rates."""
    model = layer('''(
    defaultPrim = "Model"
    timeCodesPerSecond = 48
)
def Xform "Model" (variants = { string size = "small" }
    variantSets = "size") {
    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 48: (48, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "Body" (inherits = </Model/Kind>) { QUAD }
    class "Kind" { float[] primvars:displayOpacity = [0.5] }
    variantSet "size" = {
        "small" { over "Body" { float xformOp:scaleY = 0.5
            uniform token[] xformOpOrder = ["xformOp:scaleY"] } }
        "large" { over "Body" { float3 xformOp:scale = (7, 7, 7)
            uniform token[] xformOpOrder = ["xformOp:scale"] } }
    }
    def PointInstancer "Copies" {
        rel prototypes = </Model/Copies/P>
        int[] protoIndices = [0]
        point3f[] positions = [(0, 0, 3)]
        def Mesh "P" { QUAD }
    }
}
'''.replace("QUAD", QUAD))
    weak = layer('''
def Xform "World" {
    def Xform "One" (references = [@./composed_model.usd@ (offset = 10; scale = 2)]) { }
    def Xform "Two" (payload = @./composed_model.usd@</Model>) { }
    def Mesh "Gone" { QUAD }
    def Mesh "Stays" { QUAD
        double3 xformOp:translate = (1, 1, 1)
        uniform token[] xformOpOrder = ["xformOp:translate"] }
    def "Edited" (references = [@./composed_model.usd@, </World/Stays>]) { }
}
'''.replace("QUAD", QUAD))
    root = layer('''(
    timeCodesPerSecond = 24
    subLayers = [@./composed_weak.usd@ (offset = 4)]
)
over "World" {
    over "One" (variants = { string size = "large" }) { over "Body" { } }
    over "Gone" (active = false) { }
    over "Stays" { double3 xformOp:translate = (2, 3, 4) }
    over "Edited" (delete references = @./composed_model.usd@
        append references = @./composed_model.usd@</Model/Body>) { }
}
''')
    return root, [("composed_model", model), ("composed_weak", weak)]


# Random stages.


def random_op(rng, index):
    kind = rng.choice(["translate", "scale", "rotateX", "rotateY", "rotateZ", "rotateXYZ", "rotateXZY",
                       "rotateYXZ", "rotateYZX", "rotateZXY", "rotateZYX", "orient", "transform"])
    name = f"xformOp:{kind}:n{index}"
    number = lambda: round(rng.uniform(-2, 2), 3)
    if kind in ("rotateX", "rotateY", "rotateZ"):
        return name, rng.choice(["float", "double", "half"]), f"{number() * 90}"
    if kind == "orient":
        quat = [rng.gauss(0, 1) for _ in range(4)]
        size = math.sqrt(sum(part * part for part in quat))
        parts = ", ".join(f"{part / size:.9f}" for part in quat)
        return name, rng.choice(["quatf", "quatd", "quath"]), f"({parts})"
    if kind == "transform":
        rows = [[number() for _ in range(3)] + [0] for _ in range(3)] + [[number() for _ in range(3)] + [1]]
        return name, "matrix4d", "(" + ", ".join(f"({', '.join(map(str, r))})" for r in rows) + ")"
    scale = 90 if kind.startswith("rotate") else 1
    return name, rng.choice(["float3", "double3", "half3"]), f"({number() * scale}, {number() * scale}, {number() * scale})"


def random_prim(rng, name, depth):
    body = ""
    order = []
    for index in range(rng.choice([0, 1, 1, 2, 3])):
        op, kind, value = random_op(rng, index)
        body += f"{kind} {op} = {value}\n"
        order.append(f'"{op}"')
    if rng.random() < 0.1:
        order.insert(0, '"!resetXformStack!"')
    if order:
        body += f"uniform token[] xformOpOrder = [{', '.join(order)}]\n"
    if rng.random() < 0.15:
        body += f'token visibility = "{rng.choice(["invisible", "inherited"])}"\n'
    if rng.random() < 0.3:
        body += f'uniform token purpose = "{rng.choice(["default", "render", "proxy", "guide"])}"\n'
    kind = rng.choice(["Xform", "Xform", "Mesh", "BasisCurves", "Points"]) if depth < 3 else \
        rng.choice(["Mesh", "BasisCurves", "Points"])
    if kind == "BasisCurves":
        how = ["constant", "uniform", "varying", "vertex"]
        return curves_prim(name, *rng.choice(KINDS), rng.choice(how), rng.choice(how), rng, body)
    if kind == "Mesh":
        n = rng.choice([3, 4, 5, 6, 30])
        # Polygons that are not flat may be cut in several ways.
        counts = [3] * rng.choice([1, 3, 20])
        corners = [corner for _ in counts for corner in rng.sample(range(n), 3)]
        points = [[rng.uniform(-2, 2) for _ in range(3)] for _ in range(n)]
        how = rng.choice(["constant", "uniform", "vertex", "varying", "faceVarying", None])
        size = {"constant": 1, "uniform": len(counts), "faceVarying": len(corners)}.get(how, n)
        body += f"int[] faceVertexCounts = {counts}\nint[] faceVertexIndices = {corners}\n"
        body += f"point3f[] points = {numbers(points)}\n"
        if rng.random() < 0.3:
            body += f"int[] holeIndices = {sorted(set(rng.randrange(len(counts)) for _ in range(2)))}\n"
        if how:
            values = [rng.uniform(0, 1) for _ in range(size)]
            body += f'float[] primvars:displayOpacity = {numbers(values)} (interpolation = "{how}")\n'
    elif kind == "Points":
        n = rng.choice([1, 2, 17])
        body += f"point3f[] points = {numbers([[rng.uniform(-2, 2) for _ in range(3)] for _ in range(n)])}\n"
        how = rng.choice(["constant", "vertex", "varying"])
        values = [rng.uniform(0.1, 1) for _ in range(1 if how == "constant" else n)]
        body += f'float[] widths = {numbers(values)} (interpolation = "{how}")\n'
    else:
        if rng.random() < 0.3:
            body += f"float[] primvars:displayOpacity = [{rng.random():.4g}]\n"
        for index in range(rng.choice([1, 2, 3])):
            body += random_prim(rng, f"p{index}", depth + 1)
    return f'def {kind} "{name}" {{\n{body}}}\n'


def random_stage(rng):
    text = ""
    for index in range(2):
        text += f'class Xform "_c{index}" {{\n{random_prim(rng, "p", 2)}}}\n'
    for index in range(4):
        target = f"</_c{rng.randrange(2)}>" if index < 2 or rng.random() < 0.5 else f"</r{rng.randrange(index)}>"
        arc = rng.choice(["references", "payload", "inherits", "specializes"])
        meta = f"prepend {arc} = {target}" if rng.random() < 0.7 else ""
        if rng.random() < 0.4:
            meta += "\ninstanceable = true"
        text += f'def Xform "r{index}" ({meta}) {{\n{random_prim(rng, f"n{index}", 1)}}}\n'
    count = rng.choice([1, 5, 40])
    which = [rng.randrange(3) for _ in range(count)]
    places = [[rng.uniform(-2, 2) for _ in range(3)] for _ in range(count)]
    text += f'''def PointInstancer "many" {{
        rel prototypes = [</many/a>, </_c0>, </r1>]
        int[] protoIndices = {which}
        point3f[] positions = {numbers(places)}
        {random_prim(rng, "a", 2)}
        float3[] scales = {numbers(places)}
        int64[] invisibleIds = [{rng.randrange(count)}]
    }}
'''
    return layer(text)


if len(sys.argv) > 3:
    seed, count = int(sys.argv[2]), int(sys.argv[3])
    for index in range(seed, seed + count):
        write(f"random{index}", random_stage(random.Random(index)), [None])
else:
    write("meshes", meshes(), [None])
    write("curves", curves(), [None])
    write("points", points(), [None])
    write("instances", instances(), [None])
    write("time", time(), [1, 2.5, 4, 7, 20, -3])
    root, others = composed()
    write("composed", root, [0, 16, 34], others)
