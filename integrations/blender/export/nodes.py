# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates shader nodes as far as they are constants, pictures, and arithmetic on both.

A value is an array (height, width, channels): 1x1 texels for constants, and 1 channel for numbers or 3 for colours and vectors. So one
rule serves constants and pictures: nodes are evaluated texel by texel. What depends on anything but the texture coordinates (noise,
position) has a graph where materials take one: see graphs.py. What has none (view) is replaced by a constant, and said.
"""

from contextlib import contextmanager

import numpy as np

from . import graphs
from .arithmetic import BLENDS, MATHS, shifted
from .rays import IS_OF

SAME_TO_ALL = "rays of all kinds see what {} (Light Path)"

ASLANT = 0.5**0.5
"""Cosine of the angle at which what depends on the eye is looked up."""

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)


def constant(*values):
    """A constant as a value."""
    return np.array(values, dtype=np.float32).reshape(1, 1, -1)


def number(value):
    """A value as a number: the luminance of colours, as Blender converts them."""
    return value if value.shape[2] == 1 else graphs.carried(value, (np.asarray(value) @ LUMINANCE)[:, :, None])


def color(value):
    """A value as a colour or vector."""
    return value if value.shape[2] == 3 else graphs.carried(value, np.repeat(value, 3, axis=2))


def alike(*values):
    """The values at the size of the largest, by the nearest texels."""
    height, width = max(value.shape[0] for value in values), max(value.shape[1] for value in values)

    def sized(value):
        if value.shape[:2] in ((height, width), (1, 1)):
            return value
        rows = np.arange(height) * value.shape[0] // height
        columns = np.arange(width) * value.shape[1] // width
        return value[rows][:, columns]

    return [sized(value) for value in values]


class Evaluator:
    """Evaluates the sockets of one material. `said` lists what was replaced; `uv` is the map and the mapping of its pictures.

    `attribute` gives the values of colour attributes by their names, as values of height n and width 1 for n corners; without it they are
    white. `asked` has the names that were asked for. `ray`: the kind of rays for which nodes are evaluated (any other name: for none of
    them); None for all at once. `has_graphs`: values may have graphs.
    """

    def __init__(self, images, attribute=None, ray=None, has_graphs=False):
        self.images, self.said = images, []
        self.has_graphs, self.known = has_graphs, {}
        self.attribute, self.asked = attribute or (lambda name: constant(1.0, 1.0, 1.0)), set()
        self.ray, self.tells_rays_apart = ray, False
        """What Light Path nodes are asked for, and whether one was."""
        self.vertex_color = None
        """Name of the colour attribute that graphs take."""
        self.painted = False
        """True if the base colour depends on a colour attribute."""
        self.uv = None
        self.plain = {}
        self.parents = []

    def say(self, message):
        """Notes what is replaced."""
        self.said.append(message)

    def input(self, node, name):
        """Value of a node's input, by its name or number."""
        socket = node.inputs[name] if isinstance(name, int) else node.inputs.get(name)
        if socket is None:
            return constant(0.0)
        link = self.link(socket)
        if link is None:
            return self.default(socket)
        value = self.output(link.from_node, link.from_socket)
        wanted = socket.type
        return number(value) if wanted == "VALUE" else color(value) if wanted in {"RGBA", "VECTOR"} else value

    @staticmethod
    def link(socket):
        """The link into a socket, through reroutes; None where there is none."""
        while socket.is_linked and socket.links:
            link = socket.links[0]
            if link.is_muted or not link.is_valid:
                return None
            if link.from_node.type != "REROUTE":
                return link
            socket = link.from_node.inputs[0]
        return None

    @contextmanager
    def source(self, socket):
        """The node that a socket is linked to, and its output, through reroutes and into and out of groups; None for both if there is none.

        Its inputs may be read as long as the context lasts: they may be those of a group.
        """
        parents = list(self.parents)
        try:
            yield self._source(socket)
        finally:
            self.parents = parents

    def _source(self, socket):
        link = self.link(socket)
        while link is not None:
            node, inner = link.from_node, link.from_socket
            if node.type == "GROUP" and not node.mute:
                inner = self.within(node, inner)
                self.parents.append(node)
            elif node.type == "GROUP_INPUT" and self.parents:
                inner = same_socket(self.parents.pop().inputs, inner)
            else:
                return node, inner
            link = self.link(inner) if inner else None
        return None, None

    @staticmethod
    def within(node, socket):
        """The input of a group's active output that an output of its node shows; None where it has none."""
        nodes = node.node_tree.nodes if node.node_tree else ()
        output = next((entry for entry in nodes if entry.type == "GROUP_OUTPUT" and entry.is_active_output), None)
        return same_socket(output.inputs, socket) if output else None

    @staticmethod
    def default(socket):
        """The value that a socket has without a link."""
        value = getattr(socket, "default_value", 0.0)
        if isinstance(value, (int, float)):
            return constant(value)
        if isinstance(value, str) or value is None:
            return constant(0.0)
        return constant(*list(value)[:3])

    def output(self, node, socket):
        """Value of a node's output."""
        if node.mute:
            linked = [entry for entry in node.inputs if entry.is_linked and entry.type == socket.type]
            return self.input(node, list(node.inputs).index(linked[0])) if linked else constant(0.0)
        if not self.has_graphs or node.type in {"GROUP", "GROUP_INPUT"}:
            return self.plainly(node, socket)
        # each output once: a graph may take it at many places
        key = (tuple(parent.as_pointer() for parent in self.parents), node.as_pointer(), socket.identifier)
        if key not in self.known:
            graph = graphs.of_node(self, node, socket)
            said = list(self.said)
            value = self.plainly(node, socket)
            if graph is not None:
                # nothing is replaced
                self.said = said
                value = graphs.computed(value, graph)
            self.known[key] = value
        return self.known[key]

    def plainly(self, node, socket):
        """Value of a node's output without a graph."""
        method = getattr(self, f"node_{node.type.lower()}", None)
        if method is None:
            self.say(f"node `{node.name}` ({node.bl_label}) is replaced by a constant")
            return self.fallback(node, socket)
        return method(node, socket)

    def uv_graph(self, name):
        """Graph of the texture coordinates of a UV map ("": the active one)."""
        if self.uv is None:
            self.uv = (name, np.eye(3))
        elif self.uv[0] != name:
            self.say(f"UV map `{name}`: the one of the material's first picture counts")
        return graphs.Node("uv", "vector3")

    def fallback(self, node, socket):
        """A constant for a node that is not evaluated: the mean of its colours, or a half."""
        colors = [entry for entry in node.inputs if entry.type == "RGBA"]
        if socket.type == "RGBA" and colors:
            return np.mean([self.input(node, list(node.inputs).index(entry)).mean(axis=(0, 1), keepdims=True) for entry in colors], axis=0)
        return constant(0.5) if socket.type == "VALUE" else constant(0.5, 0.5, 0.5)

    # constants

    def node_rgb(self, node, socket):
        return constant(*list(socket.default_value)[:3])

    def node_value(self, node, socket):
        return constant(socket.default_value)

    def node_blackbody(self, node, socket):
        kelvin = float(self.input(node, 0).mean())
        self.say(f"node `{node.name}` (Blackbody) is an approximation")
        return constant(*blackbody(kelvin))

    # the eye

    def node_fresnel(self, node, socket):
        self.say(f"node `{node.name}` ({node.bl_label}) is what it is at 45 degrees")
        return constant(reflected(float(self.input(node, "IOR").mean())))

    def node_layer_weight(self, node, socket):
        self.say(f"node `{node.name}` ({node.bl_label}) is what it is at 45 degrees")
        blend = float(self.input(node, "Blend").mean())
        if socket.name == "Fresnel":
            return constant(reflected(index_of_weight(blend)))
        blend = min(max(blend, 0.0), 1 - 1e-5)
        return constant(1 - ASLANT ** (2 * blend if blend < 0.5 else 0.5 / (1 - blend)))

    # rays

    def node_light_path(self, node, socket):
        self.tells_rays_apart = True
        if self.ray is None:
            self.say(SAME_TO_ALL.format("the camera sees"))
        elif socket.name not in IS_OF:
            self.say(f"{socket.name} of Light Path is 0")
        return constant(float((self.ray or "camera") in IS_OF.get(socket.name, ())))

    # attributes

    def node_vertex_color(self, node, socket):
        if socket.name == "Alpha":
            self.say(f"node `{node.name}`: the alpha of colour attributes is left out")
            return constant(1.0)
        self.asked.add(node.layer_name)
        return self.attribute(node.layer_name)

    def node_attribute(self, node, socket):
        if node.attribute_type != "GEOMETRY" or not node.attribute_name or socket.name == "Alpha":
            self.say(f"node `{node.name}` ({node.bl_label}) is replaced by a constant")
            return self.fallback(node, socket)
        self.asked.add(node.attribute_name)
        value = self.attribute(node.attribute_name)
        return value.mean(axis=2, keepdims=True) if socket.type == "VALUE" else value

    # pictures

    def node_tex_image(self, node, socket):
        pixels = self.images.pixels(node.image) if node.image else None
        if pixels is None:
            if not node.image:
                self.say(f"node `{node.name}` has no image")
            return constant(1.0, 0.0, 1.0) if socket.name == "Color" else constant(1.0)
        self.place(node)
        if node.projection != "FLAT":
            self.say(f"image node `{node.name}`: its projection is replaced by the UV map")
        if node.extension != "REPEAT":
            self.say(f"image node `{node.name}`: the picture repeats outside of 0 to 1")
        part = "alpha" if socket.name == "Alpha" else "color"
        key = (node.image.name_full, part)
        if key not in self.plain:
            self.plain[key] = pixels[:, :, 3:4] if part == "alpha" else pixels[:, :, :3]
        return self.plain[key]

    def image_of(self, value):
        """The image whose colours a value is, unchanged; None if nodes have changed it. Its name is that of the image."""
        for (name, part), array in self.plain.items():
            if array is value and part == "color":
                return name
        return None

    def place(self, node):
        """Notes the UV map and the mapping of an image node: all pictures of a material share one."""
        name, matrix = self.mapping(node.inputs["Vector"], node)
        if self.uv is None:
            self.uv = (name, matrix)
        elif self.uv[0] != name or not np.allclose(self.uv[1], matrix, atol=1e-6):
            self.say(f"image node `{node.name}`: has the UV map and the mapping of the material's first picture")

    def takes_uv(self, socket):
        """Returns true if a vector input has the coordinates of a UV map, moved in their plane or not."""
        with self.source(socket) as (source, output):
            if source is None or source.type == "UVMAP":
                return True
            if source.type == "TEX_COORD":
                return output.name == "UV"
            if source.type != "MAPPING" or any(self.link(source.inputs[name]) for name in ("Location", "Rotation", "Scale") if source.inputs.get(name)):
                return False
            turn = source.inputs["Rotation"].default_value if source.inputs.get("Rotation") else (0, 0, 0)
            return abs(turn[0]) + abs(turn[1]) < 1e-6 and self.takes_uv(source.inputs["Vector"])

    def mapping(self, socket, node):
        """Name of the UV map ("": the active one), and the 3x3 matrix for (u, v, 1), of a vector input."""
        with self.source(socket) as (source, output):
            if source is None:
                return "", np.eye(3)
            if source.type == "UVMAP":
                return source.uv_map, np.eye(3)
            if source.type == "TEX_COORD":
                if output.name != "UV":
                    self.say(f"image node `{node.name}`: {output.name} coordinates are replaced by the UV map")
                return "", np.eye(3)
            if source.type == "MAPPING":
                name, matrix = self.mapping(source.inputs["Vector"], node)
                return name, mapping_matrix(self, source) @ matrix
            self.say(f"image node `{node.name}`: its coordinates ({source.bl_label}) are replaced by the UV map")
            return "", np.eye(3)

    # arithmetic

    def node_mix(self, node, socket):
        kinds = {"FLOAT": (0, 2, 3), "VECTOR": (1 if node.factor_mode == "NON_UNIFORM" else 0, 4, 5), "RGBA": (0, 6, 7)}
        if node.data_type not in kinds:
            self.say(f"node `{node.name}` (Mix of rotations) is replaced by a constant")
            return constant(0.0)
        factor, a, b = alike(*(self.input(node, index) for index in kinds[node.data_type]))
        factor = np.clip(factor, 0, 1) if node.clamp_factor else factor
        return self.blend(node, factor, a, b, node.blend_type if node.data_type == "RGBA" else "MIX", node.clamp_result)

    def node_mix_rgb(self, node, socket):
        factor, a, b = alike(self.input(node, 0), self.input(node, 1), self.input(node, 2))
        return self.blend(node, np.clip(factor, 0, 1), a, b, node.blend_type, node.use_clamp)

    def blend(self, node, factor, a, b, kind, clamp):
        if kind not in BLENDS:
            self.say(f"node `{node.name}`: blending by {kind.lower()} is replaced by mixing")
        mixed = BLENDS.get(kind, BLENDS["MIX"])(factor, a, b).astype(np.float32)
        return np.clip(mixed, 0, 1) if clamp else mixed

    def node_math(self, node, socket):
        a, b, c = alike(self.input(node, 0), self.input(node, 1), self.input(node, 2) if len(node.inputs) > 2 else constant(0.0))
        if node.operation not in MATHS:
            self.say(f"node `{node.name}` (Math, {node.operation.lower()}) passes its first input on")
        value = MATHS.get(node.operation, lambda a, b, c: a)(a, b, c).astype(np.float32)
        return np.clip(value, 0, 1) if node.use_clamp else value

    def node_hue_sat(self, node, socket):
        hue, saturation, value, factor, plain = alike(*(self.input(node, index) for index in range(5)))
        return np.maximum(plain * (1 - factor) + shifted(plain, hue, saturation, value) * factor, 0).astype(np.float32)

    def node_curve_rgb(self, node, socket):
        factor, plain = alike(self.input(node, 0), self.input(node, 1))
        mapping = node.mapping
        mapping.initialize()
        curves = list(mapping.curves)
        # the last curve is that of all channels, and comes first
        value = through(mapping, curves[3], plain)
        value = np.concatenate([through(mapping, curve, value[:, :, index : index + 1]) for index, curve in enumerate(curves[:3])], axis=2)
        return (plain * (1 - factor) + value * factor).astype(np.float32)

    def node_invert(self, node, socket):
        factor, value = alike(self.input(node, 0), self.input(node, 1))
        return value * (1 - factor) + (1 - value) * factor

    def node_gamma(self, node, socket):
        value, gamma = alike(self.input(node, 0), self.input(node, 1))
        return np.power(np.maximum(value, 0), gamma)

    def node_brightcontrast(self, node, socket):
        value, bright, contrast = alike(self.input(node, 0), self.input(node, 1), self.input(node, 2))
        return np.maximum(value * (1 + contrast) + bright - contrast * 0.5, 0)

    def node_rgbtobw(self, node, socket):
        return number(self.input(node, 0))

    def node_clamp(self, node, socket):
        value, low, high = alike(*(self.input(node, index) for index in range(3)))
        return np.clip(value, low, high)

    def node_map_range(self, node, socket):
        value, a, b, c, d = alike(*(self.input(node, index) for index in range(5)))
        share = (value - a) / np.where(b == a, 1, b - a)
        if node.clamp:
            share = np.clip(share, 0, 1)
        return c + share * (d - c)

    def node_valtorgb(self, node, socket):
        value = np.clip(self.input(node, 0)[:, :, 0], 0, 1)
        table = np.array([node.color_ramp.evaluate(step / 1023) for step in range(1024)], dtype=np.float32)
        picked = table[(value * 1023 + 0.5).astype(int)]
        return picked[:, :, 3:4] if socket.name == "Alpha" else picked[:, :, :3]

    def node_separate_color(self, node, socket):
        if getattr(node, "mode", "RGB") != "RGB":
            self.say(f"node `{node.name}` (Separate Color) splits by RGB")
        index = list(node.outputs).index(socket)
        return self.input(node, 0)[:, :, index : index + 1]

    node_seprgb = node_sepxyz = node_separate_color

    def node_combine_color(self, node, socket):
        if getattr(node, "mode", "RGB") != "RGB":
            self.say(f"node `{node.name}` (Combine Color) joins by RGB")
        parts = alike(*(self.input(node, index) for index in range(3)))
        height, width = max(part.shape[0] for part in parts), max(part.shape[1] for part in parts)
        return np.concatenate([np.broadcast_to(part, (height, width, 1)) for part in parts], axis=2)

    node_combrgb = node_combxyz = node_combine_color

    def node_group(self, node, socket):
        inner = self.within(node, socket)
        if inner is None:
            return constant(0.0)
        link = self.link(inner)
        if link is None:
            return self.default(inner)
        self.parents.append(node)
        try:
            return self.output(link.from_node, link.from_socket)
        finally:
            self.parents.pop()

    def node_group_input(self, node, socket):
        parent = self.parents.pop()
        try:
            outer = same_socket(parent.inputs, socket)
            return self.input(parent, list(parent.inputs).index(outer)) if outer else constant(0.0)
        finally:
            self.parents.append(parent)


def index_of_weight(blend):
    """The index of refraction that the Fresnel output of a Layer Weight has for its blend."""
    return 1 / max(1 - blend, 1e-5)


def reflected(index):
    """Share of the light that a surface of some index of refraction reflects at 45 degrees."""
    squared = index * index - 1 + ASLANT * ASLANT
    if squared < 0:
        return 1.0
    root = squared**0.5
    one = (root - ASLANT) / (root + ASLANT)
    other = (ASLANT * (root + ASLANT) - 1) / (ASLANT * (root - ASLANT) + 1)
    return 0.5 * one * one * (1 + other * other)


def through(mapping, curve, values):
    """Values as a curve maps them."""
    low, high = min(float(values.min()), 0.0), max(float(values.max()), 1.0)
    steps = np.linspace(low, high, 1025)
    return np.interp(values, steps, [mapping.evaluate(curve, step) for step in steps])


def same_socket(sockets, socket):
    """That one of some sockets of a group which is the same as a socket on its other side; None where there is none."""
    return next((entry for entry in sockets if entry.identifier == socket.identifier), None)


def mapping_matrix(evaluator, node):
    """The 3x3 matrix by which a Mapping node moves (u, v, 1), of constants; rotation about Z alone counts."""
    place, turn, scale = (
        evaluator.input(node, name).mean(axis=(0, 1)) if node.inputs.get(name) else default
        for name, default in (("Location", np.zeros(3)), ("Rotation", np.zeros(3)), ("Scale", np.ones(3)))
    )
    cos, sin = np.cos(turn[2]), np.sin(turn[2])
    rotate = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    grow = np.diag([scale[0], scale[1], 1.0])
    move = np.array([[1, 0, place[0]], [0, 1, place[1]], [0, 0, 1]])
    if node.vector_type == "TEXTURE":
        return np.linalg.pinv(move @ rotate @ grow)
    return (np.eye(3) if node.vector_type == "VECTOR" else move) @ rotate @ grow


def blackbody(kelvin):
    """Linear RGB of a black body, of the largest channel 1, by the fit of Krystek's chromaticity."""
    t = min(max(kelvin, 1000.0), 15000.0)
    u = (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) / (1 + 8.42420235e-4 * t + 7.08145163e-7 * t * t)
    v = (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) / (1 - 2.89741816e-5 * t + 1.61456053e-7 * t * t)
    x, y = 3 * u / (2 * u - 8 * v + 4), 2 * v / (2 * u - 8 * v + 4)
    xyz = np.array([x / y, 1.0, (1 - x - y) / y])
    rgb = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]) @ xyz
    rgb = np.clip(rgb, 0, None)
    return (rgb / rgb.max()).tolist()
