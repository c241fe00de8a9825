"""USD stages of many kinds written by usd-core, and what usd-core reads in them, as models_made.py has models."""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils, Vt

from models_made import star
from strands_made import ribbon


def placed(rng, prim):
    """A random place in the plane: the matrix, whose vectors are rows."""
    angle, scale, move = rng.uniform(0, 360), rng.uniform(0.4, 1), rng.uniform(-0.4, 0.4, 2)
    form = UsdGeom.XformCommonAPI(prim)
    form.SetTranslate(Gf.Vec3d(*move, 0))
    form.SetRotate(Gf.Vec3f(0, 0, angle))
    form.SetScale(Gf.Vec3f(scale, scale, scale))
    cos, sin = scale * np.cos(np.radians(angle)), scale * np.sin(np.radians(angle))
    return lambda corners: corners @ [[cos, sin], [-sin, cos]] + move


def mesh(stage, path, polygons):
    prim = UsdGeom.Mesh.Define(stage, path)
    points = [Gf.Vec3f(*corner, 0) for polygon in polygons for corner in polygon]
    prim.CreatePointsAttr(points)
    prim.CreateFaceVertexCountsAttr([len(polygon) for polygon in polygons])
    prim.CreateFaceVertexIndicesAttr(list(range(len(points))))
    return prim


def opacity_of(rng):
    return float(np.float32(rng.uniform(0.1, 0.9)))


def make(rng, folder, kind):
    end = {"packages": "usda", "text": "usda"}.get(kind, "usdc")
    path = folder / f"a.{end}"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    root = UsdGeom.Xform.Define(stage, "/World")
    stage.SetDefaultPrim(root.GetPrim())
    outer = placed(rng, root)
    shapes = [star(rng) for _ in range(int(rng.integers(1, 4)))]
    result, keys = [(outer(shape), 1.0) for shape in shapes], ""
    if kind in ("text", "binary", "packages"):
        mesh(stage, "/World/mesh", shapes)
    elif kind == "opacity of all":
        opacity = opacity_of(rng)
        root_opacity = UsdGeom.PrimvarsAPI(root).CreatePrimvar("displayOpacity", Sdf.ValueTypeNames.FloatArray)
        root_opacity.Set(Vt.FloatArray([opacity]))
        mesh(stage, "/World/mesh", shapes)
        result = [(polygon, opacity) for polygon, _ in result]
    elif kind == "opacity of faces":
        prim = mesh(stage, "/World/mesh", shapes)
        values = [opacity_of(rng) for _ in shapes]
        prim.CreateDisplayOpacityPrimvar("uniform").Set(Vt.FloatArray(values))
        result = [(polygon, value) for (polygon, _), value in zip(result, values)]
    elif kind == "hidden and guides":
        mesh(stage, "/World/mesh", shapes)
        mesh(stage, "/World/hidden", [star(rng)]).MakeInvisible()
        mesh(stage, "/World/guide", [star(rng)]).CreatePurposeAttr("guide")
        mesh(stage, "/World/off", [star(rng)]).GetPrim().SetActive(False)
    elif kind == "instances":
        stage.CreateClassPrim("/Shape")
        mesh(stage, "/Shape/mesh", shapes)
        result = []
        for at in range(3):
            prim = UsdGeom.Xform.Define(stage, f"/World/copy{at}")
            prim.GetPrim().GetReferences().AddInternalReference("/Shape")
            prim.GetPrim().SetInstanceable(True)
            inner = placed(rng, prim)
            result += [(outer(inner(shape)), 1.0) for shape in shapes]
    elif kind == "point instancers":
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
        protos = [mesh(stage, f"/World/many/p{at}", [shape]) for at, shape in enumerate(shapes)]
        instancer.CreatePrototypesRel().SetTargets([proto.GetPath() for proto in protos])
        indices = rng.integers(0, len(shapes), 4)
        moves, scales = rng.uniform(-0.5, 0.5, (4, 2)), rng.uniform(0.2, 0.6, 4)
        instancer.CreateProtoIndicesAttr(indices.tolist())
        instancer.CreatePositionsAttr([Gf.Vec3f(*move, 0) for move in moves])
        instancer.CreateScalesAttr([Gf.Vec3f(scale, scale, scale) for scale in scales])
        result = [(outer(shapes[i] * s + m), 1.0) for i, s, m in zip(indices, scales, moves)]
    elif kind == "time samples":
        prim = mesh(stage, "/World/mesh", shapes)
        points = np.concatenate(shapes)
        for time, factor in ((1, 0.2), (5, 1.0), (9, 0.5)):
            prim.GetPointsAttr().Set([Gf.Vec3f(*corner, 0) for corner in points * factor], time)
        time = float(np.float32(rng.uniform(0, 10)))
        factor = float(np.interp(time, (1, 5, 9), (0.2, 1, 0.5)))
        result, keys = [(outer(shape * factor), 1.0) for shape in shapes], f"time = {time!r}\n"
    elif kind == "points":
        centres, widths = rng.uniform(-0.7, 0.7, (5, 2)), rng.uniform(0.1, 0.5, 5)
        prim = UsdGeom.Points.Define(stage, "/World/points")
        prim.CreatePointsAttr([Gf.Vec3f(*centre, 0) for centre in centres])
        prim.CreateWidthsAttr(widths.tolist())
        turn = np.linspace(0, 2 * np.pi, 200, endpoint=False)
        ring = np.stack([np.cos(turn), np.sin(turn)], 1) / 2
        result = [(outer(centre + width * ring), 1.0) for centre, width in zip(centres, widths)]
    elif kind == "curves":
        prim = UsdGeom.BasisCurves.Define(stage, "/World/curves")
        prim.CreateTypeAttr("linear")
        ends, widths = rng.uniform(-0.7, 0.7, (3, 2, 2)), rng.uniform(0.05, 0.3, 3)
        cuts = rng.integers(2, 30, 3)
        points = [a + (b - a) * t for (a, b), n in zip(ends, cuts) for t in np.linspace(0, 1, n)]
        prim.CreatePointsAttr([Gf.Vec3f(*point, 0) for point in points])
        prim.CreateCurveVertexCountsAttr(cuts.tolist())
        prim.CreateWidthsAttr(widths.tolist())
        prim.SetWidthsInterpolation("uniform")
        result = [(outer(ribbon(a, b, (width, width))), 1.0) for (a, b), width in zip(ends, widths)]
    stage.GetRootLayer().Save()
    if kind == "packages":
        packed = folder / "a.usdz"
        UsdUtils.CreateNewUsdzPackage(str(path), str(packed))
        path = packed
    return path, result, keys


def by_usd(path, time=None):
    """The polygons that usd-core reads, with their opacity."""
    stage = Usd.Stage.Open(str(path))
    time = Usd.TimeCode(time) if time is not None else Usd.TimeCode.EarliestTime()
    result = []
    instancers = []

    def world(prim):
        return np.array(UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(time))

    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
        imageable = UsdGeom.Imageable(prim)
        if not imageable or imageable.ComputeVisibility(time) == "invisible":
            continue
        if imageable.ComputePurpose() not in ("default", "render"):
            continue
        if any(prim.GetPath().HasPrefix(instancer) for instancer in instancers):
            continue
        places = [world(prim)]
        if UsdGeom.PointInstancer(prim):
            instancer = UsdGeom.PointInstancer(prim)
            instancers.append(prim.GetPath())
            matrices = instancer.ComputeInstanceTransformsAtTime(time, time)
            protos = instancer.GetPrototypesRel().GetTargets()
            for index, matrix in zip(instancer.GetProtoIndicesAttr().Get(time), matrices):
                proto = stage.GetPrimAtPath(protos[index])
                result += shapes_of(proto, np.array(matrix) @ places[0], time)
            continue
        result += shapes_of(prim, places[0], time)
    return result


def shapes_of(prim, matrix, time):
    def put(points):
        points = np.asarray(points, float)
        if points.shape[1] == 2:
            points = np.concatenate([points, np.zeros((len(points), 1))], 1)
        return (points @ matrix[:3, :3] + matrix[3, :3])[:, :2]

    opacity = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayOpacity")
    values = opacity.ComputeFlattened(time) if opacity and opacity.HasValue() else None
    if UsdGeom.Mesh(prim):
        shape = UsdGeom.Mesh(prim)
        counts, indices = shape.GetFaceVertexCountsAttr().Get(time), shape.GetFaceVertexIndicesAttr().Get(time)
        points = put(shape.GetPointsAttr().Get(time))[np.array(indices)]
        faces = np.split(points, np.cumsum(counts)[:-1])
        if values is None or len(values) == 1:
            values = [1.0 if values is None else values[0]] * len(faces)
        return list(zip(faces, values))
    if UsdGeom.Points(prim):
        shape = UsdGeom.Points(prim)
        turn = np.linspace(0, 2 * np.pi, 200, endpoint=False)
        ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1) / 2
        both = zip(np.array(shape.GetPointsAttr().Get(time)), shape.GetWidthsAttr().Get(time))
        return [(put(centre + ring * width), 1.0) for centre, width in both]
    if UsdGeom.BasisCurves(prim):
        shape = UsdGeom.BasisCurves(prim)
        counts = shape.GetCurveVertexCountsAttr().Get(time)
        lines = np.split(np.array(shape.GetPointsAttr().Get(time)), np.cumsum(counts)[:-1])
        ends = [(line[0, :2].astype(float), line[-1, :2].astype(float)) for line in lines]
        return [(put(ribbon(*pair, (width, width))), 1.0) for pair, width in zip(ends, shape.GetWidthsAttr().Get(time))]
    return []


KINDS = {
    kind: (lambda rng, folder, kind=kind: make(rng, folder, kind))
    for kind in (
        "text",
        "binary",
        "packages",
        "opacity of all",
        "opacity of faces",
        "hidden and guides",
        "instances",
        "point instancers",
        "time samples",
        "points",
        "curves",
    )
}
