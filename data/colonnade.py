# SPDX-License-Identifier: MIT
# Renders an environment by Blender's Cycles: a round colonnade in the evening.
#   blender -b --factory-startup -P data/colonnade.py -- OUT.exr [WIDTH [SAMPLES]]
import math
import random
import sys

import bpy

args = sys.argv[sys.argv.index('--') + 1:]
width = int(args[1]) if len(args) > 1 else 2048
samples = int(args[2]) if len(args) > 2 else 64
random.seed(7)
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def material(name, colour, roughness, scale=0.0, dark=0.6):
    """Noise of that scale turns the colour darker."""
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    nodes, links = m.node_tree.nodes, m.node_tree.links
    shader = nodes['Principled BSDF']
    shader.inputs['Roughness'].default_value = roughness
    shader.inputs['Base Color'].default_value = (*colour, 1)
    if scale:
        noise, mix = nodes.new('ShaderNodeTexNoise'), nodes.new('ShaderNodeMixRGB')
        place = nodes.new('ShaderNodeTexCoord')
        noise.inputs['Scale'].default_value = scale
        noise.inputs['Detail'].default_value = 12
        links.new(place.outputs['Object'], noise.inputs['Vector'])
        mix.inputs[1].default_value = (*(dark * c for c in colour), 1)
        mix.inputs[2].default_value = (*colour, 1)
        links.new(noise.outputs['Fac'], mix.inputs[0])
        links.new(mix.outputs[0], shader.inputs['Base Color'])
    return m


def add(kind, m, **where):
    getattr(bpy.ops.mesh, 'primitive_%s_add' % kind)(**where)
    bpy.context.object.data.materials.append(m)
    return bpy.context.object


stone = material('stone', (0.62, 0.52, 0.42), 0.8, 3, 0.75)
light = material('light stone', (0.75, 0.68, 0.58), 0.6, 5, 0.8)
water = material('water', (0.02, 0.05, 0.06), 0.02)
leaf = material('leaf', (0.05, 0.12, 0.03), 0.7, 20, 0.4)
hill = material('hill', (0.16, 0.17, 0.08), 0.9, 0.05, 0.5)
red = material('terracotta', (0.5, 0.14, 0.07), 0.7, 9, 0.7)

# A floor of slabs with joints, a basin round the middle, steps outside.
for i in range(-9, 10):
    for j in range(-9, 10):
        r = math.hypot(i, j) * 1.2
        if 3.0 < r < 10.5:
            slab = add('cube', random.choice((stone, light, stone)), size=1,
                       location=(1.2 * i, 1.2 * j, -0.05 + 0.004 * random.random()))
            slab.scale = (1.185, 1.185, 0.1)
add('cylinder', stone, radius=60, depth=0.1, location=(0, 0, -0.12), vertices=96)
add('cylinder', water, radius=3.3, depth=0.1, location=(0, 0, -0.06), vertices=96)
rim = add('torus', light, major_radius=3.4, minor_radius=0.14, location=(0, 0, 0.05),
          major_segments=96)

# Columns with an architrave, a gap towards the sun.
count = 22
for i in range(count):
    a = 2 * math.pi * i / count
    x, y = 9.2 * math.cos(a), 9.2 * math.sin(a)
    if i in (2, 3, 4):
        continue
    add('cylinder', light, radius=0.34, depth=4.4, location=(x, y, 2.3), vertices=24)
    for z, s in ((0.15, 1.0), (4.6, 1.05)):
        base = add('cube', light, size=1, location=(x, y, z), rotation=(0, 0, a))
        base.scale = (s, s, 0.3)
    beam = add('cube', stone, size=1, rotation=(0, 0, a + math.pi / count),
               location=(9.2 * math.cos(a + math.pi / count),
                         9.2 * math.sin(a + math.pi / count), 5.0))
    beam.scale = (1.0, 2.9, 0.5)
# Pots with bushes between some of them.
for i in range(1, count, 3):
    a = 2 * math.pi * (i + 0.5) / count
    x, y = 7.6 * math.cos(a), 7.6 * math.sin(a)
    add('cone', red, radius1=0.28, radius2=0.45, depth=0.8, location=(x, y, 0.4))
    bush = add('ico_sphere', leaf, radius=0.7, subdivisions=5, location=(x, y, 1.25))
    push = bush.modifiers.new('push', 'DISPLACE')
    clouds = bpy.data.textures.new('clouds', 'CLOUDS')
    clouds.noise_scale = 0.12
    push.texture, push.strength = clouds, 0.35

# Hills far off.
for i in range(40):
    a, far = random.uniform(0, 2 * math.pi), random.uniform(150, 420)
    h = add('uv_sphere', hill, radius=1, location=(far * math.cos(a), far * math.sin(a), -8),
            segments=48, ring_count=24)
    h.scale = (random.uniform(50, 110), random.uniform(50, 110), random.uniform(14, 40))
    bpy.ops.object.shade_smooth()
add('plane', hill, size=3000, location=(0, 0, -0.6))

world = bpy.data.worlds.new('sky')
scene.world = world
world.use_nodes = True
sky = world.node_tree.nodes.new('ShaderNodeTexSky')
sky.sky_type = 'NISHITA'
sky.sun_elevation = math.radians(17)
sky.sun_rotation = math.radians(40)
sky.sun_intensity = 0.6
sky.dust_density = 1.2
world.node_tree.links.new(sky.outputs[0], world.node_tree.nodes['Background'].inputs[0])
world.node_tree.nodes['Background'].inputs[1].default_value = 0.35

camera = bpy.data.cameras.new('camera')
camera.type = 'PANO'
camera.cycles.panorama_type = 'EQUIRECTANGULAR'
eye = bpy.data.objects.new('eye', camera)
eye.location = (0, 0, 1.6)
eye.rotation_euler = (math.pi / 2, 0, 0)
scene.collection.objects.link(eye)
scene.camera = eye
scene.render.engine = 'CYCLES'
scene.cycles.samples = samples
scene.cycles.use_denoising = False
scene.cycles.sample_clamp_indirect = 20
scene.render.resolution_x = width
scene.render.resolution_y = width // 2
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = 'OPEN_EXR'
scene.render.image_settings.color_depth = '32'
scene.render.image_settings.color_mode = 'RGB'
scene.render.filepath = args[0]
bpy.ops.render.render(write_still=True)
