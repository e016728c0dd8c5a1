# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for race.py: parts that turn, a character, a flock, a head of skin, and things of patterns. Each stands before a floor."""

import bpy
import compare_cycles
import numpy as np
import support


def cubes(width, frames):
    """27 cubes in three layers that turn by themselves, and two lamps."""
    scene = stage(width, frames, (0, -9, 4))
    lamp(scene, "Key", (-3, -4, 6), 600, 1.0)
    lamp(scene, "Fill", (4, -2, 4), 200, 1.0)
    made = [compare_cycles.material(f"Side {at}", Base_Color=color) for at, color in enumerate(((0.7, 0.1, 0.08, 1), (0.1, 0.3, 0.65, 1), (0.8, 0.6, 0.1, 1)))]
    mesh = box(0.92)
    mesh.materials.append(made[0])
    for layer, turn in enumerate((90, -60, 120)):
        pivot = support.add(scene, f"Layer {layer}", None, (0, 0, 0.6 + layer))
        key(pivot, "rotation_euler", frames, lambda share: (0, 0, np.radians(turn) * share))
        for x in (-1, 0, 1):
            for y in (-1, 0, 1):
                one = support.add(scene, f"Cube {layer} {x} {y}", mesh, (x, y, 0))
                one.parent = pivot
                one.material_slots[0].link, one.material_slots[0].material = "OBJECT", made[(x + y + layer) % 3]
    return scene


def character(width, frames):
    """A body of 19,000 triangles that bends by the bones of an armature and goes a step, two lamps, and a world."""
    scene = stage(width, frames, (0, -6, 1.8))
    lamp(scene, "Key", (-3, -4, 5), 400, 1.0)
    lamp(scene, "Rim", (3, 2, 4), 200, 0.5)
    world(scene, 0.4)
    rings, around, height, bones = 120, 80, 2.6, 5
    up, turn = np.linspace(0, 1, rings), np.linspace(0, 2 * np.pi, around, endpoint=False)
    radius = 0.42 * np.sqrt(np.clip(1 - (2 * up - 1) ** 8, 0.002, 1)) * (1 + 0.25 * np.sin(9 * up))
    x, y = radius[:, None] * np.cos(turn), radius[:, None] * np.sin(turn)
    points = np.stack([x, y, np.broadcast_to(height * up[:, None], x.shape)], axis=2).reshape(-1, 3)
    at = np.arange(rings - 1)[:, None] * around
    beside = (np.arange(around) + 1) % around
    faces = np.stack([at + np.arange(around), at + beside, at + around + beside, at + around + np.arange(around)], axis=2).reshape(-1, 4)
    mesh = support.mesh_of("Body", points, faces)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.append(compare_cycles.material("Skin", Base_Color=(0.6, 0.33, 0.22, 1)))
    body = support.add(scene, "Body", mesh)
    rig = support.add(scene, "Rig", bpy.data.armatures.new("Rig"))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    before = None
    for number in range(bones):
        bone = rig.data.edit_bones.new(f"Bone {number}")
        bone.head, bone.tail = (0, 0, height * number / bones), (0, 0, height * (number + 1) / bones)
        bone.parent, before = before, bone
    bpy.ops.object.mode_set(mode="OBJECT")
    middles = (np.arange(bones) + 0.5) / bones
    for number in range(bones):
        group, weights = body.vertex_groups.new(name=f"Bone {number}"), np.clip(1 - bones * np.abs(up - middles[number]), 0, 1)
        if number in (0, bones - 1):
            weights[(up < middles[0]) if number == 0 else (up > middles[-1])] = 1
        for ring in np.flatnonzero(weights):
            group.add(range(int(ring) * around, (int(ring) + 1) * around), float(weights[ring]), "REPLACE")
    body.modifiers.new("Rig", "ARMATURE").object = rig
    for number, pose in enumerate(rig.pose.bones):
        pose.rotation_mode = "XYZ"
        key(pose, "rotation_euler", frames, lambda share, number=number: (0.25 * np.sin(5 * share + number), 0, 0.35 * np.cos(4 * share + number)))
    key(rig, "location", frames, lambda share: (0.8 * share - 0.4, 0, 0))
    body.parent = rig
    return scene


def flock(width, frames):
    """300 instances of one mesh that fly, a sun, and a world."""
    scene = stage(width, frames, (0, -9, 3.5))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.0, 0.05
    support.add(scene, "Sun", sun, turn=(0.7, 0.3, 0))
    world(scene, 0.5)
    bpy.ops.mesh.primitive_monkey_add(size=0.45)
    first = bpy.context.object
    mesh = first.data
    bpy.data.objects.remove(first)
    mesh.materials.append(compare_cycles.material("Bird", Base_Color=(0.25, 0.3, 0.6, 1), Roughness=0.7))
    dice = np.random.default_rng(5)
    for number in range(300):
        place, way, spin = dice.uniform((-4, -2, 0.5), (4, 6, 4)), dice.normal(0, 0.7, 3), dice.normal(0, 0.8, 3)
        one = support.add(scene, f"Bird {number}", mesh)
        key(one, "location", frames, lambda share, place=place, way=way: place + way * share)
        key(one, "rotation_euler", frames, lambda share, spin=spin: spin * share)
    return scene


def skin(width, frames):
    """A head that rests, of skin into which light goes, two lamps and a world, and a camera that goes around it."""
    scene = stage(width, frames, (0, -5, 1.3))
    lamp(scene, "Key", (-3, -4, 5), 400, 1.0)
    lamp(scene, "Rim", (3, 2, 4), 300, 0.5)
    world(scene, 0.4)
    bpy.ops.mesh.primitive_monkey_add(size=2.0, location=(0, 0, 1.3))
    head = bpy.context.object
    head.data.shade_smooth()
    head.modifiers.new("Smooth", "SUBSURF").render_levels = 2
    material = compare_cycles.material("Skin", Base_Color=(0.8, 0.5, 0.38, 1), Roughness=0.5)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Subsurface Weight"].default_value, shader.inputs["Subsurface Scale"].default_value = 1.0, 0.1
    head.data.materials.append(material)
    camera = scene.camera
    turns = lambda share: np.radians(20 * share - 10)
    key(camera, "location", frames, lambda share: (5 * np.sin(turns(share)), -5 * np.cos(turns(share)), 1.3))
    key(camera, "rotation_euler", frames, lambda share: (np.pi / 2, 0, turns(share)))
    return scene


def patterns(width, frames):
    """Things that rest, each of some forty nodes with noise and cells of eight octaves, and a camera that travels past them."""
    return things(width, frames, patterned)


def plain(width, frames):
    """The same things, each of one colour."""
    return things(width, frames, lambda name, color: compare_cycles.material(name, Base_Color=color, Roughness=0.5))


def things(width, frames, material):
    """Balls and blocks on a floor and before a wall, a sun, and a world; `material(name, color)` makes what they are made of."""
    scene = support.empty(width, width * 9 // 16, (1, frames))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.0, 0.05
    support.add(scene, "Sun", sun, turn=(0.7, 0.3, 0))
    world(scene, 0.5)
    for name, place, turn in (("Floor", (0, 0, 0), (0, 0, 0)), ("Wall", (0, 4, 0), (np.pi / 2, 0, 0))):
        mesh = support.grid(name, 30)
        mesh.materials.append(material(name, (0.6, 0.5, 0.4, 1)))
        support.add(scene, name, mesh, place, turn)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.8)
    first = bpy.context.object
    ball, block = first.data, box(1.3)
    ball.shade_smooth()
    bpy.data.objects.remove(first)
    for number in range(10):
        mesh = (ball if number % 2 else block).copy()
        color = [(0.7, 0.2, 0.1, 1), (0.2, 0.4, 0.6, 1), (0.6, 0.6, 0.2, 1)][number % 3]
        mesh.materials.append(material(f"Thing {number}", color))
        support.add(scene, f"Thing {number}", mesh, ((number % 5 - 2) * 1.9, number // 5 * 2.0 - 0.5, 0.75), (0, 0, 0.4 * number))
    camera = support.add_camera(scene, (0, -9, 3.2), (np.pi / 2 - 0.25, 0, 0), lens=40.0)
    key(camera, "location", frames, lambda share: (1.2 * share - 0.6, -9, 3.2))
    return scene


def patterned(name, color):
    """A material whose base colour, roughness and bump are computed."""
    made = compare_cycles.material(name, Base_Color=color)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    at = nodes.new("ShaderNodeTexCoord").outputs["Object"]
    value = None
    for layer in range(5):
        moved = nodes.new("ShaderNodeMapping")
        moved.inputs["Location"].default_value, moved.inputs["Scale"].default_value = (layer, 0.3, 0), (1 + 0.3 * layer,) * 3
        links.new(at, moved.inputs[0])
        kind = "ShaderNodeTexNoise" if layer % 2 == 0 else "ShaderNodeTexVoronoi"
        texture = nodes.new(kind)
        texture.inputs["Scale"].default_value, texture.inputs["Detail"].default_value = 1.5 + layer, 7.0
        links.new(moved.outputs[0], texture.inputs["Vector"])
        ramp = nodes.new("ShaderNodeValToRGB")
        ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.05, 0.04, 0.03, 1), color
        links.new(texture.outputs[0], ramp.inputs[0])
        bright = nodes.new("ShaderNodeHueSaturation")
        bright.inputs["Hue"].default_value = 0.5 + 0.02 * layer
        links.new(ramp.outputs[0], bright.inputs["Color"])
        math = nodes.new("ShaderNodeMath")
        math.operation = "SMOOTH_MIN"
        links.new(texture.outputs[0], math.inputs[0])
        if value is None:
            value = bright.outputs[0]
        else:
            mix = nodes.new("ShaderNodeMix")
            mix.data_type, mix.blend_type = "RGBA", "OVERLAY" if layer % 2 else "MIX"
            links.new(math.outputs[0], mix.inputs[0])
            links.new(value, mix.inputs[6])
            links.new(bright.outputs[0], mix.inputs[7])
            value = mix.outputs[2]
    shader = nodes["Principled BSDF"]
    links.new(value, shader.inputs["Base Color"])
    wide = nodes.new("ShaderNodeMapRange")
    wide.inputs["To Min"].default_value, wide.inputs["To Max"].default_value = 0.3, 0.8
    links.new(math.outputs[0], wide.inputs[0])
    links.new(wide.outputs[0], shader.inputs["Roughness"])
    return made


def stage(width, frames, eye):
    """A scene with a matt floor, seen from an eye that looks at what stands on it."""
    scene = support.empty(width, width * 9 // 16, (1, frames))
    floor = compare_cycles.material("Floor", Base_Color=(0.5, 0.5, 0.5, 1), Roughness=1.0)
    floor.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0
    mesh = support.grid("Floor", 30)
    mesh.materials.append(floor)
    support.add(scene, "Floor", mesh)
    _, away, up = eye
    support.add_camera(scene, eye, (np.pi / 2 - np.arctan2(up - 1.3, -away), 0, 0), lens=40.0)
    return scene


def lamp(scene, name, place, power, size):
    """A lamp that shines at the middle of what stands on the floor."""
    data = bpy.data.lights.new(name, "AREA")
    data.energy, data.size = power, size
    x, y, z = place
    turn = (np.arctan2(np.hypot(x, y), z - 1.3), 0, np.arctan2(x, -y))
    support.add(scene, name, data, place, turn)


def world(scene, strength):
    """A world of one colour."""
    made = bpy.data.worlds.new("World")
    made.use_nodes = True
    back = made.node_tree.nodes["Background"]
    back.inputs["Color"].default_value, back.inputs["Strength"].default_value = (0.8, 0.9, 1, 1), strength
    scene.world = made


def box(size):
    """A cube."""
    half = size / 2
    points = np.array([(x, y, z) for z in (-half, half) for y in (-half, half) for x in (-half, half)])
    faces = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])
    mesh = support.mesh_of("Box", points, faces)
    # a mesh that a script makes is smooth
    mesh.shade_flat()
    return mesh


def key(item, name, frames, value):
    """Keys a property at each frame, as what is animated by hand or by a simulation has it in the end; `value` takes the share of the shot."""
    for frame in range(0, frames + 2):
        setattr(item, name, value((frame - 1) / max(frames - 1, 1)))
        item.keyframe_insert(name, frame=frame)
