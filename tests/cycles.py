# SPDX-License-Identifier: MIT
# Renders the spheres of tests/cycles.c with Blender's Cycles.
#   blender -b --factory-startup -P cycles.py -- SCENE.json MAP OUT.exr SAMPLES
# The world of the viewer (+Y up) becomes Blender's (+Z up) by (x, -z, y).
# Spheres see the environment alone, as in the viewer: no shadows, no bounces
# between them. Their material is the Glossy BSDF (GGX, one scattering) of a
# constant colour, which is a metal of F0 = 1.
import json
import sys

import addon_utils
import bpy
from mathutils import Matrix, Vector

scene_path, map_path, out_path, samples = sys.argv[sys.argv.index("--") + 1:]
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

for number, sphere in enumerate(wanted["spheres"]):
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=256, ring_count=128, radius=sphere["radius"],
        location=turned(sphere["centre"]))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    material = bpy.data.materials.new(str(number))
    material.use_nodes = True
    nodes = material.node_tree
    nodes.nodes.clear()
    glossy = nodes.nodes.new("ShaderNodeBsdfGlossy")
    glossy.distribution = "GGX" if sphere["roughness"] > 0 else "SHARP"
    glossy.inputs["Color"].default_value = (1, 1, 1, 1)
    glossy.inputs["Roughness"].default_value = sphere["roughness"]
    output = nodes.nodes.new("ShaderNodeOutputMaterial")
    nodes.links.new(glossy.outputs[0], output.inputs["Surface"])
    ball.data.materials.append(material)
    ball.visible_glossy = ball.visible_diffuse = ball.visible_shadow = False

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
