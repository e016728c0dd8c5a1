# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what the texture nodes of Blender give at many places: the fixture that the tests of src/pattern read.

    python integrations/blender/scripts/patterns.py [FILE]

FILE is src/pattern/beside_blender.csv if none is named. Needs a Python with bpy (5 or newer) and numpy.

Cycles is asked, which makes the pictures; geometry nodes have code of their own. A picture is rendered in which
each pixel shows one square of a mesh. The square has one value of each attribute, which the nodes take as inputs, and a material for the
options of a node, which emits one of its outputs. A camera without perspective, one sample and a box filter as wide as a pixel leave the
numbers as they are.

A line is `node,options,place,inputs,outputs`. Options are words. Place is x y z w. Inputs and outputs are numbers in the order of the tables
below (INPUTS, and `outputs` of the function that makes the node); a vector or a colour is three numbers.
"""

import math
import os
import random
import sys
import tempfile

import bpy
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
DIMENSIONS = ("1D", "2D", "3D", "4D")
FRACTALS = ("FBM", "MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN")
METRICS = ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")
PROFILES = ("SIN", "SAW", "TRI")
GRADIENTS = ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL")
COLORS = {"Color1": (0.8, 0.25, 0.125, 1.0), "Color2": (0.0625, 0.5, 0.75, 1.0), "Mortar": (0.375, 0.3125, 0.25, 1.0)}

# Sockets that follow the place, by node; an index where a name is not unique.
INPUTS = {
    "Noise": ("Scale", "Detail", "Roughness", "Lacunarity", "Offset", "Gain", "Distortion"),
    "Voronoi": ("Scale", "Detail", "Roughness", "Lacunarity", "Smoothness", "Exponent", "Randomness"),
    "Wave": ("Scale", "Distortion", "Detail", "Detail Scale", "Detail Roughness", "Phase Offset"),
    "Magic": ("Scale", "Distortion"),
    "Brick": ("Scale", "Mortar Size", "Mortar Smooth", "Bias", "Brick Width", "Row Height"),
    "Checker": ("Scale",),
    "Gradient": (),
    "WhiteNoise": (),
    "Gabor": ("Scale", "Frequency", "Anisotropy", 4, 5),
}
# What is written: for each node, groups of outputs that one colour can carry.
OUTPUTS = {
    "Noise": (("Factor",), ("Color",)),
    "Voronoi": (("Distance", "W", "Radius"), ("Color",), ("Position",)),
    "Wave": (("Factor",),),
    "Magic": (("Factor",), ("Color",)),
    "Brick": (("Factor",), ("Color",)),
    "Checker": (("Factor",), ("Color",)),
    "Gradient": (("Factor",),),
    "WhiteNoise": (("Value",), ("Color",)),
    "Gabor": (("Value", "Phase", "Intensity"),),
}


def options():
    """All (node, properties) that are asked."""
    for dimensions in DIMENSIONS:
        for kind in FRACTALS:
            for is_normalized in (True, False) if kind == "FBM" else (True,):
                yield "Noise", {"noise_dimensions": dimensions, "noise_type": kind, "normalize": is_normalized}
        for feature in ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"):
            by_metric = dimensions != "1D" and feature in ("F1", "F2", "SMOOTH_F1")
            for metric in METRICS if by_metric else METRICS[:1]:
                for is_normalized in (False, True) if metric != "CHEBYCHEV" and feature != "N_SPHERE_RADIUS" else (True,):
                    yield "Voronoi", {
                        "voronoi_dimensions": dimensions, "feature": feature, "distance": metric, "normalize": is_normalized
                    }
        yield "WhiteNoise", {"noise_dimensions": dimensions}
    for profile in PROFILES:
        for direction in ("X", "Y", "Z", "DIAGONAL"):
            yield "Wave", {"wave_type": "BANDS", "bands_direction": direction, "wave_profile": profile}
        for direction in ("X", "Y", "Z", "SPHERICAL"):
            yield "Wave", {"wave_type": "RINGS", "rings_direction": direction, "wave_profile": profile}
    for depth in range(11):
        yield "Magic", {"turbulence_depth": depth}
    for offset, offset_frequency, squash, squash_frequency in ((0.5, 2, 1.0, 2), (0.3, 3, 1.7, 2), (0.8, 1, 0.6, 4)):
        yield "Brick", {
            "offset": offset, "offset_frequency": offset_frequency, "squash": squash, "squash_frequency": squash_frequency
        }
    yield "Checker", {}
    for kind in GRADIENTS:
        yield "Gradient", {"gradient_type": kind}
    for kind in ("2D", "3D"):
        yield "Gabor", {"gabor_type": kind}


COUNTS = {"Noise": 9, "Voronoi": 6, "Wave": 4, "Magic": 4, "Brick": 16, "Checker": 30, "Gradient": 8, "WhiteNoise": 10, "Gabor": 24}


def place(chance, index):
    """A place, its kind by the index: near the origin, on whole numbers, far from it."""
    kind = index % 5
    if kind == 2:
        return [float(chance.randint(-3, 3)) for _ in range(4)]
    reach = (1.0, 12.0, 1.0, 2.0, 900.0)[kind]
    return [chance.uniform(-reach, reach) for _ in range(4)]


def noise_inputs(chance, at, index):
    if index == 7:
        at[:] = [value * 3000.0 for value in at]
    elif index == 8:
        at[:] = [math.copysign(2.5e6, value) for value in at]
    scale = (1.0, 5.0, 1.0, -3.7, 0.013, 0.0, 2.0, 1.0, 1.0)[index]
    detail = (0.0, 2.0, 2.5, 15.0, -1.0, 8.3, 2.0, 3.0, 1.0)[index]
    distortion = chance.choice((0.0, 0.8, -2.0)) if detail <= 3.0 else 0.0
    offset = chance.choice((0.0, 0.5, 1.0, -0.3))
    gain = chance.choice((1.0, 0.3, 2.0))
    roughness = chance.choice((0.5, 0.5, 0.3, 0.73, 0.0, -0.2) if distortion else (0.5, 0.8, 1.0, 1.2))
    return [scale, detail, roughness, chance.choice((2.0, 2.0, 1.7, 0.5)), offset, gain, distortion]


def voronoi_inputs(chance, at, index):
    scale = (1.0, 5.0, 1.0, -3.7, 0.5, 0.0)[index]
    detail = (0.0, 0.0, 1.5, 2.0, 3.25, -1.0)[index]
    smoothness = chance.choice((1.0, 0.3, 0.7, 0.0))
    # No whole places with an even lattice: there several cells are at the same distance.
    randomness = chance.choice((1.0, 0.6) if index in (2, 5) else (1.0, 0.0, 0.4, 1.5))
    exponent = chance.choice((0.5, 2.0, 3.5, 1.0))
    return [scale, detail, chance.choice((0.5, 0.8, 1.0, 0.0)), chance.choice((2.0, 1.6)), smoothness, exponent, randomness]


def wave_inputs(chance, at, index):
    distortion = chance.choice((0.0, 1.0, -4.0))
    phase = chance.choice((0.0, 1.3, -7.0))
    detail = chance.choice((0.0, 2.0, 3.4))
    return [chance.choice((1.0, 5.0, -0.4)), distortion, detail, chance.choice((1.0, 2.5)), chance.choice((0.5, 0.7)), phase]


def magic_inputs(chance, at, index):
    return [chance.choice((1.0, 5.0, 0.0, -2.3)), chance.choice((1.0, 0.0, 2.2, -0.7))]


def brick_inputs(chance, at, index):
    width, height = chance.choice(((0.5, 0.25), (0.9, 0.4), (0.3, 0.7)))
    mortar = chance.choice((0.02, 0.1, 0.0, 0.2))
    return [chance.choice((1.0, 5.0, -2.0)), mortar, chance.choice((0.0, 0.1, 1.0)), chance.choice((0.0, -0.4, 0.3)), width, height]


def checker_inputs(chance, at, index):
    return [chance.choice((1.0, 5.0, -2.0, 0.0))]


def gabor_inputs(chance, at, index):
    direction = [chance.uniform(-1.0, 1.0) for _ in range(3)]
    anisotropy = chance.choice((1.0, 0.0, 0.4, 1.7))
    frequency = chance.choice((2.0, 0.7, 5.0, -1.0))
    return [chance.choice((1.0, 5.0, -1.5)), frequency, anisotropy, chance.uniform(-4.0, 4.0), *direction]


def cases():
    """(node, properties, place, inputs) of all, numbers rounded to 32 bits."""
    chance = random.Random(20)
    for node, properties in options():
        for index in range(COUNTS[node]):
            at = place(chance, index)
            make = globals().get(f"{node.lower()}_inputs")
            inputs = make(chance, at, index) if make else []
            # Few digits keep the file small, and are as good as many.
            short = [round(value, 4 if abs(value) < 20.0 else 2) for value in at + inputs]
            numbers = [float(np.float32(value)) for value in short]
            yield node, properties, numbers[:4], numbers[4:]


def attribute(tree, name, output):
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = name
    return node.outputs[output]


def found(sockets, key):
    """The socket of a name or an index, also where the options of the node put it out of use; None if there is none."""
    if isinstance(key, int):
        return sockets[key]
    return next((socket for socket in sockets if socket.name == key), None)


def feed(tree, node, kind):
    """Links the place and the inputs of a texture node to attributes."""
    for name, output in (("Vector", "Vector"), ("W", "Fac")):
        socket = found(node.inputs, name)
        if socket:
            tree.links.new(attribute(tree, name.lower(), output), socket)
    for color, value in COLORS.items():
        socket = found(node.inputs, color)
        if socket:
            socket.default_value = value
    index = 0
    for key in INPUTS[kind]:
        socket = found(node.inputs, key)
        if socket.type == "VECTOR":
            join = tree.nodes.new("ShaderNodeCombineXYZ")
            sockets = list(join.inputs)
            tree.links.new(join.outputs[0], socket)
        else:
            sockets = [socket]
        for each in sockets:
            tree.links.new(attribute(tree, f"input{index}", "Fac"), each)
            index += 1


def material(kind, properties, group):
    """A material that emits a group of the outputs of a node."""
    made = bpy.data.materials.new(kind)
    made.cycles.emission_sampling = "NONE"
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(f"ShaderNodeTex{kind}")
    for name, value in properties.items():
        setattr(node, name, value)
    feed(tree, node, kind)
    source = found(node.outputs, group[0])
    if source.type == "VALUE":
        join = tree.nodes.new("ShaderNodeCombineXYZ")
        for name, socket in zip(group, join.inputs):
            # One that the options put out of use is zero.
            if found(node.outputs, name).enabled:
                tree.links.new(found(node.outputs, name), socket)
        source = join.outputs[0]
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    if source.enabled:
        tree.links.new(source, emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def squares(side, count):
    """A mesh of unit squares, rows from the bottom, as many as are needed."""
    mesh = bpy.data.meshes.new("squares")
    corners = [(x, y, 0.0) for y in range(side + 1) for x in range(side + 1)]
    row = side + 1
    faces = []
    for index in range(count):
        first = index // side * row + index % side
        faces.append((first, first + 1, first + row + 1, first + row))
    mesh.from_pydata(corners, [], faces)
    return mesh


def picture(asked):
    """Renders a pixel for each (material, place, inputs), and returns their colours."""
    side = math.ceil(math.sqrt(len(asked)))
    mesh = squares(side, len(asked))
    for made in dict.fromkeys(entry[0] for entry in asked):
        mesh.materials.append(made)
    slots = {made: slot for slot, made in enumerate(mesh.materials)}
    mesh.polygons.foreach_set("material_index", [slots[entry[0]] for entry in asked])
    vectors = mesh.attributes.new("vector", "FLOAT_VECTOR", "FACE")
    vectors.data.foreach_set("vector", [value for entry in asked for value in entry[1][:3]])
    columns = {"w": [entry[1][3] for entry in asked]}
    for index in range(max(len(entry[2]) for entry in asked)):
        columns[f"input{index}"] = [(entry[2] + [0.0] * 16)[index] for entry in asked]
    for name, values in columns.items():
        mesh.attributes.new(name, "FLOAT", "FACE").data.foreach_set("value", values)
    scene = bpy.context.scene
    scene.collection.objects.link(bpy.data.objects.new("squares", mesh))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = side
    camera.location = (side / 2.0, side / 2.0, 10.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return rendered(scene, side)[: len(asked)]


def rendered(scene, side):
    """The pixels of a scene, bottom row first, RGB of 32 bits."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 1.0
    scene.render.resolution_x = scene.render.resolution_y = side
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "picture.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(side * side * 4, dtype=np.float32)
        image.pixels.foreach_get(pixels)
    return pixels.reshape(-1, 4)[:, :3]


def words(values):
    """Numbers of 32 bits as the shortest text that gives them back."""
    return " ".join(np.format_float_positional(np.float32(value), unique=True, trim="-") for value in values)


def main(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials, asked, lines = {}, [], []
    for kind, properties, at, inputs in cases():
        lines.append([kind, " ".join(str(value) for value in properties.values()), words(at), words(inputs), []])
        for group in OUTPUTS[kind]:
            key = (kind, tuple(properties.items()), group)
            if key not in materials:
                materials[key] = material(*key[:1], properties, group)
            asked.append((materials[key], at, inputs))
    pixels = iter(picture(asked))
    with open(path, "w", encoding="utf-8") as file:
        for line in lines:
            for group in OUTPUTS[line[0]]:
                # A group of numbers is as long as it says; one of a vector or a colour is three.
                is_one = len(group) == 1 and group[0] in ("Factor", "Value")
                line[4].extend(next(pixels)[: 1 if is_one else 3])
            print(*line[:4], words(line[4]), sep=",", file=file)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "src", "pattern", "beside_blender.csv"))
