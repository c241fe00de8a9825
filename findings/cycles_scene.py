"""A floor, a sun straight above it, occluders between, and a camera: scenes for Blender's Cycles, one thread, CPU.

A camera under the occluders sees the light that reaches the floor; one above them sees what is behind them.
"""

import math
import os
import tempfile

import bpy
import numpy as np


def new_scene(width=5, height=5, samples=64, transparent_bounces=1024):
    """Blender renders no picture of fewer than 4 pixels a side."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine, cycles.device = "CYCLES", "CPU"
    render.threads_mode, render.threads = "FIXED", 1
    render.resolution_x, render.resolution_y = width, height
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = samples, False, False
    cycles.max_bounces, cycles.transparent_max_bounces = 0, transparent_bounces
    cycles.pixel_filter_type = "BOX"
    scene.world = bpy.data.worlds.new("dark")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[1].default_value = 0
    return scene


def add(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def material(build):
    made = bpy.data.materials.new("material")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    build(tree, tree.nodes.new("ShaderNodeOutputMaterial"))
    return made


def shader(kind, socket="Surface", **inputs):
    """A material of one shader node, its inputs by name."""

    def build(tree, output):
        node = tree.nodes.new(kind)
        for name, value in inputs.items():
            node.inputs[name].default_value = value
        tree.links.new(node.outputs[0], output.inputs[socket])

    return material(build)


def transparent(factor):
    return shader("ShaderNodeBsdfTransparent", Color=(factor, factor, factor, 1))


def floor(lit):
    """A white floor at z = 0: lit by the sun, or bright by itself."""
    mesh = bpy.data.meshes.new("floor")
    mesh.from_pydata([(-1e5, -1e5, 0), (1e5, -1e5, 0), (1e5, 1e5, 0), (-1e5, 1e5, 0)], [], [(0, 1, 2, 3)])
    white = (1, 1, 1, 1)
    mesh.materials.append(shader("ShaderNodeBsdfDiffuse" if lit else "ShaderNodeEmission", Color=white))
    add("floor", mesh)
    if lit:
        sun = bpy.data.lights.new("sun", "SUN")
        sun.energy, sun.angle = math.pi, 0
        add("sun", sun)


def camera(x, z, width):
    """Looks straight down from (x, 0, z), without perspective."""
    data = bpy.data.cameras.new("camera")
    data.type, data.ortho_scale, data.clip_start, data.clip_end = "ORTHO", width, 1e-3, 1e6
    thing = add("camera", data)
    thing.location = (x, 0, z)
    bpy.context.scene.camera = thing


def strand(points, radius, surface):
    curves = bpy.data.hair_curves.new("strand")
    curves.add_curves([len(points)])
    for point, position in zip(curves.points, points):
        point.position, point.radius = position, radius
    curves.materials.append(surface)
    return add("strand", curves)


def render(whole=False):
    """The red channel of the picture's middle row, or of all rows from below."""
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.render.filepath = os.path.join(folder, "picture.exr")
        bpy.ops.render.render(write_still=True)
        picture = bpy.data.images.load(bpy.context.scene.render.filepath)
        width, height = picture.size
        red = np.array(picture.pixels[:]).reshape(height, width, 4)[:, :, 0]
        return red if whole else red[height // 2]
