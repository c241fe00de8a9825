"""The light that a model stops by what other programs' readers make of it: 1 - V(infinity)."""

import numpy as np
import plyfile
import trimesh

import gltf_reader
from models_made import stopped


def by_trimesh(path, _keys):
    loaded = trimesh.load(path, process=False)
    mesh = loaded.to_mesh() if isinstance(loaded, trimesh.Scene) else loaded
    return stopped([(triangle[:, :2], 1.0) for triangle in np.asarray(mesh.triangles)])


def by_plyfile(path, _keys):
    data = plyfile.PlyData.read(str(path))
    vertices = data["vertex"]
    places = np.stack([vertices["x"], vertices["y"]], 1).astype(float)
    alphas = vertices["alpha"] / 255 if "alpha" in vertices else np.ones(len(places))
    if "tristrips" in data:
        faces = []
        for row in data["tristrips"]["vertex_indices"]:
            for strip in np.split(row, np.flatnonzero(row < 0)):
                strip = strip[strip >= 0]
                faces += [strip[at : at + 3] for at in range(len(strip) - 2)]
    else:
        faces = data["face"]["vertex_indices"]
    return stopped([(places[face], alphas[face[0]]) for face in faces])


def by_pygltflib(path, keys):
    return stopped([(triangle, 1.0) for triangle in gltf_reader.triangles(path, keys)])


def by_usd_core(path, keys):
    from stages_made import by_usd

    time = float(keys.split("=")[1]) if keys else None
    return stopped(by_usd(path, time))


def by_struct(path, _keys):
    from strands_made import by_struct as read

    return stopped([(strand, 1.0) for strand in read(path)])
