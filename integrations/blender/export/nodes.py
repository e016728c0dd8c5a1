# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates shader nodes as far as they are constants, pictures, and arithmetic on both.

A value is an array (height, width, channels): 1x1 texels for constants, and 1 channel for numbers or 3 for colours and vectors. So one
rule serves constants and pictures: nodes are evaluated texel by texel. What depends on anything but the texture coordinates (noise,
position) has a graph where materials take one: see graphs.py. What has none (view) is replaced by a constant, and said.
"""

from contextlib import contextmanager

import numpy as np

from . import eye, graphs, islands, layers, pointiness
from .arithmetic import BLENDS, MATHS, VECTOR_MATHS, shifted
from .images import sized
from .rays import IS_OF

SAME_TO_ALL = "rays of all kinds see what {} (Light Path)"

MOSTLY = {("AMBIENT_OCCLUSION", "AO"): 1.0, ("NEW_GEOMETRY", "Backfacing"): 0.0, ("WIREFRAME", "Factor"): 0.0, ("WIREFRAME", "Fac"): 0.0}
"""What outputs are at most places, where the renderer does not know them: by a node's type and the output's name."""

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

    return [value if value.shape[:2] == (1, 1) else sized(value, height, width) for value in values]


class Evaluator:
    """Evaluates the sockets of one material. `said` lists what was replaced; `uv` is the map and the mapping of its pictures, which are Pictures.

    `attribute` gives the values of colour attributes by their names, as values of height n and width 1 for n corners; without it they are
    white. `asked` has the names that were asked for. `ray`: the kind of rays for which nodes are evaluated (any other name: for none of
    them); None for all at once. `has_graphs`: values may have graphs, and `attributes_vary`: also those that depend on colour attributes alone.
    `cosine`: that of the angle at which the surface is seen; None if it is not known.
    """

    def __init__(self, pictures, attribute=None, ray=None, has_graphs=False, attributes_vary=False, cosine=None):
        self.pictures, self.said = pictures, []
        self.has_graphs, self.attributes_vary, self.cosine, self.known = has_graphs, attributes_vary, cosine, {}
        self.attribute, self.asked = attribute or (lambda name: constant(1.0, 1.0, 1.0)), set()
        self.ray, self.tells_rays_apart = ray, False
        """What Light Path nodes are asked for, and whether one was."""
        self.vertex_color = None
        """Name of the colour attribute that graphs take."""
        self.grids = None
        """Names of the grids that nodes took, of a volume."""
        self.grids_there = ()
        """Names of those that it has."""
        self.painted = False
        """True if the base colour depends on a colour attribute."""
        self.uv = None
        self.plain = {}
        self.parents = []

    def say(self, message):
        """Notes what is replaced."""
        self.said.append(message)

    def seen_at(self, cosine):
        """A new evaluator within the same groups, of what is seen at this cosine."""
        other = Evaluator(self.pictures, self.attribute, self.ray, cosine=cosine)
        other.parents = list(self.parents)
        return other

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
        if not (self.has_graphs or self.cosine is not None) or node.type in {"GROUP", "GROUP_INPUT"}:
            return self.plainly(node, socket)
        # each output once: a graph may take it at many places, and a factor is asked for at many angles
        key = (tuple(parent.as_pointer() for parent in self.parents), node.as_pointer(), socket.identifier)
        if key not in self.known:
            graph = graphs.of_node(self, node, socket) if self.has_graphs else None
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
            return self.replaced(node, socket)
        return method(node, socket)

    def uv_graph(self, name):
        """Graph of the texture coordinates of a UV map ("": the active one)."""
        if self.uv is None:
            self.uv = (name, self.of_mosaic(np.eye(3)))
        elif self.uv[0] != name:
            self.say(f"UV map `{name}`: the one of the material's first picture counts")
        return graphs.Node("uv", "vector3")

    def replaced(self, node, socket):
        """A constant for an output that is not evaluated, which is told: what it mostly is, the mean of the node's colours, or a half."""
        of = f"{socket.name} of " if sum(entry.enabled for entry in node.outputs) > 1 else ""
        self.say(f"{of}node `{node.name}` ({node.bl_label}) is replaced by a constant")
        if (node.type, socket.name) in MOSTLY:
            return constant(MOSTLY[node.type, socket.name])
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
        return constant(layers.reflected(float(self.input(node, "IOR").mean()), self.cosine_of(node)))

    def node_layer_weight(self, node, socket):
        blend, cosine = float(self.input(node, "Blend").mean()), self.cosine_of(node)
        return constant(layers.reflected(eye.index_of_weight(blend), cosine) if socket.name == "Fresnel" else eye.facing(blend, cosine))

    def cosine_of(self, node):
        """Cosine of the angle that a node of the eye has to do with."""
        if self.cosine is None:
            self.say(f"node `{node.name}` ({node.bl_label}) is what it is at 45 degrees")
        cosine = eye.ASLANT if self.cosine is None else self.cosine
        toward = eye.toward(self, node)
        return cosine if toward is None else cosine + (1 - cosine) * float(toward.mean())

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
            return self.replaced(node, socket)
        self.asked.add(node.attribute_name)
        value = self.attribute(node.attribute_name)
        return value.mean(axis=2, keepdims=True) if socket.type == "VALUE" else value

    def node_new_geometry(self, node, socket):
        if socket.name == "Pointiness":
            self.asked.add(pointiness.NAME)
            return pointiness.from_colors(self.attribute(pointiness.NAME))
        if socket.name != "Random Per Island":
            return self.replaced(node, socket)
        self.asked.add(islands.NAME)
        return self.attribute(islands.NAME)[:, :, :1]

    # pictures

    def node_tex_image(self, node, socket):
        picture = self.pictures.of(node) if node.image else None
        pixels = self.pictures.pixels(picture) if picture else None
        if pixels is None:
            if not node.image:
                self.say(f"node `{node.name}` has no image")
            return constant(1.0, 0.0, 1.0) if socket.name == "Color" else constant(1.0)
        self.place(node)
        if node.projection != "FLAT":
            self.say(f"image node `{node.name}`: its projection is replaced by the UV map")
        if node.extension != "REPEAT" and node.image.source != "TILED":
            self.say(f"image node `{node.name}`: the picture repeats outside of 0 to 1")
        part = "alpha" if socket.name == "Alpha" else "color"
        key = (picture, part)
        if key not in self.plain:
            self.plain[key] = pixels[:, :, 3:4] if part == "alpha" else pixels[:, :, :3]
        return self.plain[key]

    def picture_of(self, value):
        """The picture whose colours a value is, unchanged; None if nodes have changed it."""
        for (picture, part), array in self.plain.items():
            if array is value and part == "color":
                return picture
        return None

    def place(self, node):
        """Notes the UV map and the mapping of an image node: all pictures of a material share one."""
        name, matrix = self.mapping(node.inputs["Vector"], node)
        matrix = self.of_mosaic(matrix)
        if self.uv is None:
            self.uv = (name, matrix)
        elif self.uv[0] != name or not np.allclose(self.uv[1], matrix, atol=1e-6):
            self.say(f"image node `{node.name}`: has the UV map and the mapping of the material's first picture")

    def of_mosaic(self, matrix):
        """A mapping to tiles as one to the mosaic of them."""
        mosaic = self.pictures.mosaic
        return mosaic.matrix @ matrix if mosaic else matrix

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

    def node_vect_math(self, node, socket):
        if node.operation not in VECTOR_MATHS:
            return self.replaced(node, socket)
        vectors = (color(self.input(node, index)) if index < len(node.inputs) else constant(0.0, 0.0, 0.0) for index in range(3))
        a, b, c, scale = alike(*vectors, self.input(node, 3) if len(node.inputs) > 3 else constant(1.0))
        return VECTOR_MATHS[node.operation](a, b, c, scale).astype(np.float32)

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
