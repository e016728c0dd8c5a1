# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints what Blender's shader nodes make of given inputs, as Cycles renders them: what our arithmetic of nodes is tested beside.

    python integrations/blender/scripts/node_functions.py > src/graph/functions/beside_blender.csv

Needs a Python with bpy. All nodes are rendered in one picture: a row of pixels for each node with its options, a column for each
tuple of inputs. A pixel is a square that carries its inputs as attributes; its material feeds them to the node and emits the result.

Lines: `family,operation,inputs,outputs`, where numbers are parted by blanks, and the inputs come in the order of the node's sockets.
Two families define what others use: `ramp`, with the stops of a colour ramp (five numbers a stop: position and RGBA), and `table`, with
the samples of a curve (the ends of its range, 1 where it is extrapolated, and the samples of each channel, one channel after another).
"""

import os
import random
import sys
import tempfile
from itertools import compress

import bpy
import numpy as np

COLUMNS = 12
NUMBERS = (-3.5, -2, -1.25, -1, -0.6, -0.25, 0, 0.1, 0.3, 0.5, 0.7, 0.9, 1, 1.3, 2, 3, 4.75)
COLORS = (-0.4, 0, 0.05, 0.2, 0.4, 0.5, 0.55, 0.7, 0.9, 1, 1.4, 2.5)
FACTORS = (-0.5, 0, 0.1, 0.35, 0.5, 0.75, 1, 1.6)
POSITIONS = tuple(i / 16 + 0.013 for i in range(-1, 17, 2)) + (0.2, 0.4, 0.5, 1)
ANGLES = (-4, -1.5, -0.3, 0, 0.2, 0.7, 1.1, 2.9, 6.5)
RAMPS = {
    "plain": ((0, 0, 0, 0, 1), (1, 1, 1, 1, 1)),
    "one": ((0.4, 0.9, 0.2, 0.1, 0.5),),
    "four": ((0.1, 0.9, 0.1, 0.05, 1), (0.35, 0.1, 0.2, 0.8, 0.25), (0.4, 0.2, 0.8, 0.1, 0), (0.85, 1.2, 0.7, 0.9, 0.8)),
    "red": ((0, 0.9, 0.1, 0.1, 1), (0.5, 0.3, 0.2, 0.2, 1), (1, 0.2, 0.9, 0.9, 1)),
    "same": ((0.2, 0.1, 0.5, 0.3, 1), (0.5, 0.7, 0.1, 0.6, 1), (0.5, 0.1, 0.1, 0.9, 0.3), (0.9, 0.3, 0.3, 0.3, 1)),
}
CURVES = {
    "bent": (((0, 0.1), (0.3, 0.8), (0.6, 0.2), (1, 0.9)), "EXTRAPOLATED"),
    "wide": (((-1, 1), (-0.2, -0.5), (0.4, 0.3), (1, -1)), "HORIZONTAL"),
}


class Row:
    """A node with its options: its family and operation, the widths and values of its inputs, and what builds it."""

    def __init__(self, family, operation, build, *slots, width=3, flip=False):
        self.family, self.operation, self.build = family, operation, build
        self.width, self.flip = width, flip
        chance = random.Random(f"{family} {operation}")
        self.widths = [size for size, _ in slots]
        self.samples = []
        for column in range(COLUMNS):
            inputs = []
            for size, values in slots:
                inputs.append([float(chance.choice(values)) for _ in range(size)])
                if values is POSITIONS:
                    inputs[-1] = [values[column]]
            self.samples.append(inputs)


def node(kind, **options):
    """What makes a node with its options: a function of a tree."""

    def make(tree):
        made = tree.nodes.new(kind)
        for name, value in options.items():
            setattr(made, name, value)
        return made

    return make


def sockets(make, inputs, output):
    """What makes a node, and names its sockets, by identifier or index: a function of a tree."""

    def build(tree):
        made = make(tree)
        by_name = {socket.identifier: socket for socket in made.inputs}
        chosen = [made.inputs[i] if isinstance(i, int) else by_name[i] for i in inputs]
        return chosen, next(socket for socket in made.outputs if socket.identifier == output)

    return build


def choices(kind, option):
    """The identifiers of a node's option."""
    return [item.identifier for item in getattr(bpy.types, kind).bl_rna.properties[option].enum_items]


def arithmetic():
    """Rows of the Math, Vector Math, Mix, Map Range and Clamp nodes."""
    for name in choices("ShaderNodeMath", "operation"):
        build = sockets(node("ShaderNodeMath", operation=name), (0, 1, 2), "Value")
        yield Row("math", name.lower(), build, (1, NUMBERS), (1, NUMBERS), (1, NUMBERS), width=1)
    for name in choices("ShaderNodeVectorMath", "operation"):
        value = name in ("DOT_PRODUCT", "DISTANCE", "LENGTH")
        build = sockets(node("ShaderNodeVectorMath", operation=name), (0, 1, 2, 3), "Value" if value else "Vector")
        third = (3, NUMBERS)
        yield Row("vector_math", name.lower(), build, third, third, third, (1, (0, 0.4, 0.8, 1, 1.45, -2)), width=1 if value else 3)
    for name in choices("ShaderNodeMix", "blend_type"):
        make = node("ShaderNodeMix", data_type="RGBA", blend_type=name, clamp_factor=False)
        build = sockets(make, ("Factor_Float", "A_Color", "B_Color"), "Result_Color")
        yield Row("blend", name.lower(), build, (1, FACTORS), (3, COLORS), (3, COLORS))
    build = sockets(node("ShaderNodeMix", data_type="FLOAT", clamp_factor=False), ("Factor_Float", "A_Float", "B_Float"), "Result_Float")
    yield Row("mix", "float", build, (1, FACTORS), (1, NUMBERS), (1, NUMBERS), width=1)
    for mode in ("UNIFORM", "NON_UNIFORM"):
        make = node("ShaderNodeMix", data_type="VECTOR", factor_mode=mode, clamp_factor=False)
        factor = "Factor_Float" if mode == "UNIFORM" else "Factor_Vector"
        build = sockets(make, (factor, "A_Vector", "B_Vector"), "Result_Vector")
        yield Row("mix", mode.lower(), build, (1 if mode == "UNIFORM" else 3, FACTORS), (3, NUMBERS), (3, NUMBERS))
    for name in choices("ShaderNodeClamp", "clamp_type"):
        build = sockets(node("ShaderNodeClamp", clamp_type=name), (0, 1, 2), "Result")
        yield Row("clamp", name.lower(), build, (1, NUMBERS), (1, NUMBERS), (1, NUMBERS), width=1)
    yield from ranges()


def ranges():
    """Rows of the Map Range node."""
    steps = (-1, 0, 1, 3, 4.5)
    for name in choices("ShaderNodeMapRange", "interpolation_type"):
        for clamp in (False, True):
            if clamp and name.startswith("SMOOTH"):
                continue  # they never leave the range
            label = f"{name.lower()}{' clamp' if clamp else ''}"
            make = node("ShaderNodeMapRange", interpolation_type=name, clamp=clamp)
            build = sockets(make, ("Value", "From Min", "From Max", "To Min", "To Max", "Steps"), "Result")
            yield Row("map_range", label, build, *[(1, NUMBERS)] * 5, (1, steps), width=1)
            make = node("ShaderNodeMapRange", interpolation_type=name, clamp=clamp, data_type="FLOAT_VECTOR")
            names = ("Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Steps_FLOAT3")
            yield Row("map_range_vector", label, sockets(make, names, "Vector"), *[(3, NUMBERS)] * 5, (3, steps))


def colors():
    """Rows of the nodes of colours."""
    color = (3, COLORS)
    build = sockets(node("ShaderNodeHueSaturation"), ("Fac", "Color", "Hue", "Saturation", "Value"), "Color")
    yield Row("color", "hue_saturation_value", build, (1, FACTORS), color, (1, (0, 0.2, 0.5, 0.8, 1)), (1, COLORS), (1, COLORS))
    build = sockets(node("ShaderNodeBrightContrast"), ("Color", "Bright", "Contrast"), "Color")
    yield Row("color", "brightness_contrast", build, color, (1, NUMBERS), (1, NUMBERS))
    yield Row("color", "gamma", sockets(node("ShaderNodeGamma"), (0, 1), "Color"), color, (1, (0, 0.2, 1, 2.2, 4)))
    yield Row("color", "invert", sockets(node("ShaderNodeInvert"), (0, 1), "Color"), (1, FACTORS), color)
    yield Row("color", "luma", sockets(node("ShaderNodeRGBToBW"), (0,), "Val"), color, width=1)
    kelvin = (-50, 0, 500, 799, 800, 900, 1000, 1300, 1700, 2700, 4000, 5500, 6500, 9000, 11999, 12000, 40000)
    yield Row("color", "blackbody", sockets(node("ShaderNodeBlackbody"), (0,), "Color"), (1, kelvin))
    nanometers = (0, 379, 380, 382, 411, 440, 467, 500, 523, 555, 580, 600, 633, 700, 779, 781)
    yield Row("color", "wavelength", sockets(node("ShaderNodeWavelength"), (0,), "Color"), (1, nanometers))
    for mode in ("HSV", "HSL"):
        channels = (1, (-0.3, 0, 0.1, 0.3, 0.45, 0.6, 0.75, 0.9, 1, 1.2))
        build = sockets(node("ShaderNodeCombineColor", mode=mode), (0, 1, 2), "Color")
        yield Row("color", f"from_{mode.lower()}", build, channels, channels, channels)
        yield Row("color", f"to_{mode.lower()}", separated(mode), color)


def separated(mode):
    """What separates a colour, and combines the channels to a colour as they are."""

    def build(tree):
        parts, joined = tree.nodes.new("ShaderNodeSeparateColor"), tree.nodes.new("ShaderNodeCombineColor")
        parts.mode = mode
        for index in range(3):
            tree.links.new(parts.outputs[index], joined.inputs[index])
        return [parts.inputs[0]], joined.outputs[0]

    return build


def vectors():
    """Rows of the Mapping and Vector Rotate nodes."""
    whole = (3, NUMBERS)
    for name in choices("ShaderNodeMapping", "vector_type"):
        build = sockets(node("ShaderNodeMapping", vector_type=name), (0, 1, 2, 3), "Vector")
        if name in ("VECTOR", "NORMAL"):
            build = sockets(node("ShaderNodeMapping", vector_type=name), ("Vector", "Rotation", "Scale"), "Vector")
        yield Row("mapping", name.lower(), build, whole, *([whole] if name in ("POINT", "TEXTURE") else []), (3, ANGLES), whole)
    for name in choices("ShaderNodeVectorRotate", "rotation_type"):
        for invert in (False, True) if name not in ("Y_AXIS", "Z_AXIS") else (False,):
            label = f"{name.lower()}{' invert' if invert else ''}"
            make = node("ShaderNodeVectorRotate", rotation_type=name, invert=invert)
            if name == "EULER_XYZ":
                yield Row("rotate", label, sockets(make, ("Vector", "Center", "Rotation"), "Vector"), whole, whole, (3, ANGLES))
            elif name == "AXIS_ANGLE":
                names = ("Vector", "Center", "Axis", "Angle")
                yield Row("rotate", label, sockets(make, names, "Vector"), whole, whole, whole, (1, ANGLES))
            else:
                yield Row("rotate", label, sockets(make, ("Vector", "Center", "Angle"), "Vector"), whole, whole, (1, ANGLES))


def fresnels():
    """Rows of the Fresnel and Layer Weight nodes. We look along -z, so that the normal's z is the cosine."""
    normal = (3, (-1, -0.7, -0.2, 0, 0.05, 0.3, 0.5, 0.8, 1))
    for back in (False, True):
        label = " back" if back else ""
        build = sockets(node("ShaderNodeFresnel"), ("IOR", "Normal"), "Fac")
        yield Row("fresnel", f"fresnel{label}", build, (1, (0, 0.5, 1, 1.33, 1.5, 2.4)), normal, width=1, flip=back)
        for output in ("Fresnel", "Facing"):
            build = sockets(node("ShaderNodeLayerWeight"), ("Blend", "Normal"), output)
            blends = (1, (-0.2, 0, 0.1, 0.4, 0.5, 0.6, 0.9, 1, 1.5))
            yield Row("layer_weight", f"{output.lower()}{label}", build, blends, normal, width=1, flip=back)


def ramps():
    """Rows of the Color Ramp node, and the lines that define the ramps."""
    lines, rows = [], []
    plain = [("RGB", name, "NEAR") for name in ("CONSTANT", "LINEAR", "EASE", "CARDINAL", "B_SPLINE")]
    hues = [(mode, "LINEAR", hue) for mode in ("HSV", "HSL") for hue in ("NEAR", "FAR", "CW", "CCW")]
    both = [("HSV", "CONSTANT", "NEAR"), ("HSL", "B_SPLINE", "FAR")]
    modes = {"four": plain + hues[::4] + hues[1::4] + both, "red": hues, "one": plain[1::3], "same": plain + both[:1]}
    for name, stops in RAMPS.items():
        flat = " ".join(number(np.float32(value)) for stop in stops for value in stop)
        lines.append(f"ramp,{name},{flat},")
        for mode, interpolation, hue in modes.get(name, plain):
            label = " ".join((name, mode, interpolation, hue)).lower()
            make = ramp(stops, mode, interpolation, hue)
            rows.append(Row("ramp_color", label, sockets(make, (0,), "Color"), (1, POSITIONS)))
            if mode == "RGB" and name == "four":
                rows.append(Row("ramp_alpha", label, sockets(make, (0,), "Alpha"), (1, POSITIONS), width=1))
    return rows, lines


def ramp(stops, mode, interpolation, hue):
    """What makes a Color Ramp node."""

    def make(tree):
        made = tree.nodes.new("ShaderNodeValToRGB")
        band = made.color_ramp
        while len(band.elements) > 1:
            band.elements.remove(band.elements[-1])
        for index, (position, *color) in enumerate(stops):
            element = band.elements[0] if index == 0 else band.elements.new(position)
            element.position, element.color = position, color
        band.color_mode, band.interpolation, band.hue_interpolation = mode, interpolation, hue
        return made

    return make


def curves():
    """Rows of the nodes of curves, and the lines with the tables of their curves."""
    lines, rows = [], []
    for name, (points, extend) in CURVES.items():
        for kind, family in (("ShaderNodeFloatCurve", "float"), ("ShaderNodeRGBCurve", "rgb"), ("ShaderNodeVectorCurve", "vector")):
            if (family == "rgb") != (name == "bent"):
                continue
            make = curve(kind, points, extend)
            tree = bpy.data.materials.new("table").node_tree
            lines.append(f"table,{family} {name},{table(make(tree).mapping, family)},")
            size = 1 if family == "float" else 3
            build = sockets(make, (0, 1), {"float": "Value", "rgb": "Color", "vector": "Vector"}[family])
            rows.append(Row("curve", f"{family} {name}", build, (1, FACTORS), (size, NUMBERS + POSITIONS), width=size))
    return rows, lines


def curve(kind, points, extend):
    """What makes a node of curves: each channel's curve is a little lower than the one before it."""

    def make(tree):
        made = tree.nodes.new(kind)
        mapping = made.mapping
        mapping.extend, mapping.use_clip = extend, False
        for index, channel in enumerate(mapping.curves):
            if kind == "ShaderNodeRGBCurve" and index == 3:
                channel.points.new(0.5, 0.7)
                continue
            while len(channel.points) > 2:
                channel.points.remove(channel.points[-2])
            for at, (x, y) in enumerate(points):
                y -= index / 8
                if at < 2:
                    channel.points[at].location = (x, y)
                else:
                    channel.points.new(x, y)
            channel.points[1].handle_type = ("AUTO", "VECTOR", "AUTO_CLAMPED", "AUTO")[index]
        mapping.update()
        return made

    return make


def table(mapping, family):
    """A curve mapping as Cycles samples it: 257 samples between the outermost points of all its curves."""
    used = mapping.curves if family != "float" else mapping.curves[:1]
    first = np.float32(min(channel.points[0].location[0] for channel in used))
    last = np.float32(max(channel.points[-1].location[0] for channel in used))
    mapping.initialize()
    values = [first, last, np.float32(mapping.extend == "EXTRAPOLATED")]
    for channel in used[:3]:
        for index in range(257):
            at = first + np.float32(index) / np.float32(256) * (last - first)
            if family == "rgb":
                at = mapping.evaluate(used[3], at)
            values.append(np.float32(mapping.evaluate(channel, at)))
    return " ".join(number(value) for value in values)


def number(value):
    """A number as text: six digits, as tests need no more."""
    return f"{float(value):.6g}"


def material(row):
    """The material of a row: attributes, the node, emission. Notes which inputs the node uses with its options."""
    made = bpy.data.materials.new(f"{row.family} {row.operation}")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    inputs, result = row.build(tree)
    for index, (socket, width) in enumerate(zip(inputs, row.widths, strict=True)):
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = f"input{index}"
        source = attribute.outputs["Vector"]
        if width == 1:
            parts = tree.nodes.new("ShaderNodeSeparateXYZ")
            tree.links.new(source, parts.inputs[0])
            source = parts.outputs[0]
        tree.links.new(source, socket)
    row.used = [socket.enabled for socket in inputs]
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(result, emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return made


def squares(rows):
    """A mesh of a unit square for each pixel: rows from the top."""
    vertices, faces, materials = [], [], []
    values = np.zeros((6, len(rows) * COLUMNS, 3), dtype=np.float32)
    for y, row in enumerate(rows):
        for x, inputs in enumerate(row.samples):
            for index, slot in enumerate(inputs):
                values[index, len(faces), : len(slot)] = slot
            first = len(vertices)
            vertices += [(x + i, -y - j, 0) for i, j in ((0, 1), (1, 1), (1, 0), (0, 0))]
            faces.append(range(first, first + 4)[:: -1 if row.flip else 1])
            materials.append(y)
    mesh = bpy.data.meshes.new("squares")
    mesh.from_pydata(vertices, [], faces)
    for row in rows:
        mesh.materials.append(material(row))
    mesh.polygons.foreach_set("material_index", materials)
    for index, slot in enumerate(values):
        mesh.attributes.new(f"input{index}", "FLOAT_VECTOR", "FACE").data.foreach_set("vector", slot.ravel())
    return mesh


def render(rows):
    """The picture of all rows, by Cycles at one sample a pixel: an array of rows, columns, and three channels."""
    scene = bpy.context.scene
    scene.collection.objects.link(bpy.data.objects.new("squares", squares(rows)))
    lens = bpy.data.cameras.new("camera")
    lens.type, lens.ortho_scale = "ORTHO", max(COLUMNS, len(rows))
    scene.camera = bpy.data.objects.new("camera", lens)
    scene.camera.location = (COLUMNS / 2, -len(rows) / 2, 10)
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 1, False, False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = COLUMNS, len(rows), 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth, scene.render.image_settings.exr_codec = "32", "ZIP"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "squares.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(len(rows) * COLUMNS * 4, dtype=np.float32)
        image.pixels.foreach_get(pixels)
    return pixels.reshape(len(rows), COLUMNS, 4)[::-1, :, :3]


def main():
    """Prints the lines; what Blender prints meanwhile goes to the standard error."""
    kept = os.dup(1)
    os.dup2(2, 1)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ramp_rows, lines = ramps()
    curve_rows, more = curves()
    rows = [*arithmetic(), *colors(), *vectors(), *fresnels(), *ramp_rows, *curve_rows]
    lines += more
    pixels = render(rows)
    for row, results in zip(rows, pixels, strict=True):
        for inputs, result in zip(row.samples, results, strict=True):
            given = " ".join(number(np.float32(value)) for slot in compress(inputs, row.used) for value in slot)
            lines.append(f"{row.family},{row.operation},{given},{' '.join(number(value) for value in result[: row.width])}")
    sys.stdout.flush()
    os.dup2(kept, 1)
    print("\n".join(dict.fromkeys(lines)))


main()
