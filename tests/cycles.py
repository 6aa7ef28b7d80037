# SPDX-License-Identifier: MIT
# Renders the spheres of tests/cycles.c, or a model, with Blender's Cycles.
#   blender -b --factory-startup -P cycles.py -- SCENE.json MAP OUT.exr SAMPLES
#           [MODEL]
# The world of the viewer (+Y up) becomes Blender's (+Z up) by (x, -z, y).
# Surfaces see the environment alone, as in the viewer: no shadows, no bounces
# between them. Their material is the Glossy BSDF (GGX, one scattering) of a
# constant colour, which is a metal of F0 = 1, or of matte ones the Diffuse BSDF.
import json
import struct
import sys

import addon_utils
import bpy
from mathutils import Matrix, Vector

scene_path, map_path, out_path, samples, *model = sys.argv[
    sys.argv.index("--") + 1:]
with open(scene_path) as f:
    wanted = json.load(f)


def turned(v):
    return Vector((v[0], -v[2], v[1]))


addon_utils.enable("cycles")
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"

world = bpy.data.worlds.new("environment")
world.use_nodes = True
scene.world = world
tree = world.node_tree
texture = tree.nodes.new("ShaderNodeTexEnvironment")
texture.image = bpy.data.images.load(map_path)
texture.projection = "EQUIRECTANGULAR"
texture.interpolation = "Closest"  # light is constant over each pixel
tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])



def shade(material, roughness, colour):
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    if roughness < 0:
        shader = nodes.new("ShaderNodeBsdfDiffuse")
    else:
        shader = nodes.new("ShaderNodeBsdfGlossy")
        shader.distribution = "GGX" if roughness > 0 else "SHARP"
        shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Color"].default_value = (*colour, 1)
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])


# A copy of a .glb whose materials have their numbers as names.
def numbered(path, copy):
    with open(path, "rb") as f:
        data = f.read()
    size = struct.unpack("<I", data[12:16])[0]
    gltf = json.loads(data[20:20 + size])
    for i, material in enumerate(gltf["materials"]):
        material["name"] = str(i)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size:]
    with open(copy, "wb") as f:
        f.write(data[:8] + struct.pack("<II", 20 + len(text) + len(rest),
                                       len(text)) + data[16:20] + text + rest)
    return copy


def sees_the_environment(thing):
    thing.visible_glossy = thing.visible_diffuse = thing.visible_shadow = False


# Fitted into a sphere of radius 1, and alone: the world is black to the camera.
if model:
    import numpy
    numpy.bool = bool  # Blender 3.4 names it so, NumPy 1.24 no longer does
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.import_scene.gltf(filepath=numbered(model[0], out_path + ".glb"))
    for material in bpy.data.materials:
        if material.name.isdigit():
            w = wanted["materials"][int(material.name)]
            shade(material, w["roughness"], w["colour"])
    parts = [o for o in scene.objects if o.type == "MESH"]
    points = [o.matrix_world @ v.co for o in parts for v in o.data.vertices]
    middle = Vector([(min(p[k] for p in points) + max(p[k] for p in points)) / 2
                     for k in range(3)])
    radius = max((p - middle).length for p in points)
    fit = Matrix.Scale(1 / radius, 4) @ Matrix.Translation(-middle)
    for o in scene.objects:
        if o.parent is None:
            o.matrix_world = fit @ o.matrix_world
    for o in parts:
        sees_the_environment(o)
    world.cycles_visibility.camera = False

for number, sphere in enumerate(wanted.get("spheres", [])):
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=256, ring_count=128, radius=sphere["radius"],
        location=turned(sphere["centre"]))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    material = bpy.data.materials.new(str(number))
    shade(material, sphere["roughness"], (1, 1, 1))
    ball.data.materials.append(material)
    sees_the_environment(ball)

camera = bpy.data.cameras.new("camera")
camera.sensor_fit = "VERTICAL"
camera.angle = wanted["fov"]
camera.clip_end = 1000
holder = bpy.data.objects.new("camera", camera)
scene.collection.objects.link(holder)
scene.camera = holder
axes = [turned(wanted[name]).normalized() for name in ("right", "up", "forward")]
holder.matrix_world = Matrix.Translation(turned(wanted["eye"])) @ Matrix((
    axes[0], axes[1], -axes[2])).transposed().to_4x4()

scene.render.resolution_x = wanted["width"]
scene.render.resolution_y = wanted["height"]
cycles = scene.cycles
cycles.samples = int(samples)
cycles.use_adaptive_sampling = False
cycles.use_denoising = False
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.blur_glossy = 0
cycles.pixel_filter_type = "GAUSSIAN"  # BOX is always as wide as a pixel
cycles.filter_width = 0.01
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = out_path
bpy.ops.render.render(write_still=True)
