# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs: what shader nodes compute at each place of a surface, written as MaterialX.

The evaluator of nodes.py knows constants and pictures. What neither can say, such as noise, is a value with a graph: the node that
gives it, with its inputs, which are constants, pictures, or such nodes again. The value itself is a constant that stands for it wherever
the renderer takes no graph.
"""

import hashlib
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

import numpy as np

from . import eye, islands, pointiness

SAMPLES = 257
"""Samples of a curve."""


class Computed(np.ndarray):
    """A constant that stands for what a graph gives; or, of a graph that depends on colour attributes alone, the value itself.

    Arithmetic on it is a graph as well: what is made of it by the functions of OF_ARRAYS has one.
    """

    graph = None

    def __array_ufunc__(self, function, method, *inputs, out=None, **options):
        plain = [np.asarray(value).view(np.ndarray) if isinstance(value, np.ndarray) else value for value in inputs]
        if out is not None:
            options["out"] = tuple(np.asarray(value).view(np.ndarray) for value in out)
        result = getattr(function, method)(*plain, **options)
        known = OF_ARRAYS.get(function.__name__)
        if method != "__call__" or known is None or all(getattr(value, "graph", None) is None for value in inputs):
            return result
        category, names = known
        taken = [value if isinstance(value, np.ndarray) and value.ndim == 3 else np.asarray(value, dtype=np.float32).reshape(1, 1, -1) for value in inputs]
        kind = "color3" if result.shape[2] == 3 else "float"
        return computed(result, Node(category, kind, dict(zip(names, map(operand, taken)))))


OF_ARRAYS = {
    "add": ("add", ("in1", "in2")),
    "subtract": ("subtract", ("in1", "in2")),
    "multiply": ("multiply", ("in1", "in2")),
    "divide": ("divide", ("in1", "in2")),
    "true_divide": ("divide", ("in1", "in2")),
    "maximum": ("max", ("in1", "in2")),
    "minimum": ("min", ("in1", "in2")),
    "sqrt": ("sqrt", ("in",)),
    "clip": ("clamp", ("in", "low", "high")),
}
"""Functions of numpy, by their names: the category of each, and the names of its inputs."""


def computed(value, graph):
    """A value with its graph: its mean, if that depends on the place."""
    value = np.asarray(value, dtype=np.float32)
    kept = (value.mean(axis=(0, 1), keepdims=True) if graph.is_of_place else value).view(Computed)
    kept.graph = graph
    return kept


def graph_of(value):
    """The graph of a value; None of one that constants, pictures and colour attributes tell."""
    graph = getattr(value, "graph", None)
    return graph if graph is not None and graph.is_of_place else None


def carried(before, after):
    """A value made of another one by a conversion that links make as well: it keeps the graph."""
    graph = getattr(before, "graph", None)
    return computed(after, graph) if graph is not None else after


@dataclass(eq=False)
class Node:
    """A node of MaterialX."""

    category: str
    kind: str
    """Type of its output, or `multioutput`."""
    inputs: dict = field(default_factory=dict)
    """By name: numbers, a text, a node, or the picture of an array."""
    output: str = ""
    """Name of the output that is meant, where there are several."""

    def __post_init__(self):
        taken = [value for value in self.inputs.values() if isinstance(value, Node)]
        self.asks_random = self.category == RANDOM or any(node.asks_random for node in taken)
        """True if it takes the number by which copies of a mesh differ."""
        self.attributes = frozenset().union({self.inputs["attribute"]} if self.category == ATTRIBUTE else (), *(node.attributes for node in taken))
        """Names of the colour attributes that it takes."""
        # what ramps make of pointiness is another thing between vertices than a mean of what they make of it there
        self.is_of_place = self.category in SOURCES or pointiness.NAME in self.attributes or any(node.is_of_place for node in taken)
        """True if it depends on more than colour attributes, or is to be computed at each place all the same."""


# what the nodes of Blender are called, and what they take: by their types

TEXTURES = {
    "TEX_NOISE": ("blender_noise", {"dimensions": "noise_dimensions", "kind": "noise_type", "normalize": "normalize"}),
    "TEX_VORONOI": ("blender_voronoi", {"dimensions": "voronoi_dimensions", "feature": "feature", "distance": "distance", "normalize": "normalize"}),
    "TEX_WAVE": ("blender_wave", {"profile": "wave_profile"}),
    "TEX_MAGIC": ("blender_magic", {"depth": "turbulence_depth"}),
    "TEX_CHECKER": ("blender_checker", {}),
    "TEX_BRICK": (
        "blender_brick",
        {"offset": "offset", "offset_frequency": "offset_frequency", "squash": "squash", "squash_frequency": "squash_frequency"},
    ),
    "TEX_GRADIENT": ("blender_gradient", {"kind": "gradient_type"}),
    "TEX_WHITE_NOISE": ("blender_white_noise", {"dimensions": "noise_dimensions"}),
    "TEX_GABOR": ("blender_gabor", {}),
}
"""Textures: the category, and the options by the properties that have them. Inputs have Blender's names in small letters."""

ARITHMETIC = {
    "MATH": ("blender_math", ("a", "b", "c"), {"operation": "operation", "clamp": "use_clamp"}),
    "VECT_MATH": ("blender_vector_math", ("a", "b", "c", "scale"), {"operation": "operation"}),
    "MIX_RGB": ("blender_mix_color", ("factor", "a", "b"), {"blend": "blend_type", "clamp_result": "use_clamp"}),
    "CLAMP": ("blender_clamp", ("value", "min", "max"), {"kind": "clamp_type"}),
    "MAPPING": ("blender_mapping", ("vector", "location", "rotation", "scale"), {"kind": "vector_type"}),
    "VECTOR_ROTATE": ("blender_vector_rotate", ("vector", "center", "axis", "angle", "rotation"), {"kind": "rotation_type", "invert": "invert"}),
    "SEPXYZ": ("blender_separate_xyz", ("vector",), {}),
    "COMBXYZ": ("blender_combine_xyz", ("x", "y", "z"), {}),
    "SEPARATE_COLOR": ("blender_separate_color", ("color",), {"mode": "mode"}),
    "COMBINE_COLOR": ("blender_combine_color", ("red", "green", "blue"), {"mode": "mode"}),
    "SEPRGB": ("blender_separate_color", ("color",), {}),
    "COMBRGB": ("blender_combine_color", ("red", "green", "blue"), {}),
    "HUE_SAT": ("blender_hue_saturation", ("hue", "saturation", "value", "factor", "color"), {}),
    "BRIGHTCONTRAST": ("blender_bright_contrast", ("color", "bright", "contrast"), {}),
    "GAMMA": ("blender_gamma", ("color", "gamma"), {}),
    "INVERT": ("blender_invert", ("factor", "color"), {}),
    "RGBTOBW": ("blender_rgb_to_bw", ("color",), {}),
    "BLACKBODY": ("blender_blackbody", ("temperature",), {}),
    "WAVELENGTH": ("blender_wavelength", ("wavelength",), {}),
}
"""Arithmetic: the category, its names of the node's inputs in their order, and the options by the properties that have them."""

RANDOM = "blender_object_random"
"""A number of the object, by which copies differ."""

SURFACE = {
    ("TEX_COORD", "Generated"): "blender_generated_coordinates",
    ("TEX_COORD", "Object"): "blender_object_coordinates",
    ("TEX_COORD", "Normal"): "blender_object_normal",
    ("NEW_GEOMETRY", "Position"): "blender_world_coordinates",
    ("NEW_GEOMETRY", "Normal"): "blender_world_normal",
    ("NEW_GEOMETRY", "True Normal"): "blender_world_normal",
    ("OBJECT_INFO", "Location"): "blender_object_location",
    ("OBJECT_INFO", "Random"): RANDOM,
}
"""What a surface gives, by a node's type and the name of its output."""

EYE = {"FRESNEL": ("blender_fresnel", "IOR"), "LAYER_WEIGHT": ("blender_layer_weight", "Blend")}
"""What depends on the angle at which a surface is seen, by a node's type: the category, and the name of what it takes."""

ATTRIBUTE = "blender_vertex_color"

GRID = "blender_volume_grid"

SOURCES = {"uv", "image", GRID, *SURFACE.values(), *(category for category, _ in (*TEXTURES.values(), *EYE.values()))}
"""Categories of what depends on the place, or on the eye."""

TYPES = {"VALUE": "float", "RGBA": "color3", "VECTOR": "vector3"}

OUTPUTS = {"Red": "red", "Green": "green", "Blue": "blue", "R": "red", "G": "green", "B": "blue", "H": "red", "S": "green", "V": "blue"}


def kind_of(socket):
    """Type of an output; None of what is no value, such as a shader."""
    return TYPES.get(socket.type)


def of_node(evaluator, node, socket):
    """The graph of a node's output; None where the node is not known, or none of what it takes is computed."""
    if kind_of(socket) is None:
        return None
    if evaluator.grids is not None and (grid := grid_of(node, socket)):
        return of_grid(evaluator, grid, kind_of(socket))
    if (node.type, socket.name) in SURFACE:
        return of_surface(evaluator, node, socket)
    if node.type in EYE:
        return of_eye(evaluator, node, socket)
    if node.type == "VERTEX_COLOR" and socket.name == "Color":
        return of_attribute(evaluator, node.layer_name)
    if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and node.attribute_name and socket.name in {"Color", "Vector"}:
        return of_attribute(evaluator, node.attribute_name)
    if node.type == "NEW_GEOMETRY" and socket.name == "Random Per Island":
        return Node("blender_separate_color", "multioutput", {"color": of_attribute(evaluator, islands.NAME)}, "red")
    if node.type == "NEW_GEOMETRY" and socket.name == "Pointiness":
        return of_pointiness()
    if node.type in {"UVMAP", "TEX_COORD"} and (node.type == "UVMAP" or socket.name == "UV"):
        return evaluator.uv_graph(node.uv_map if node.type == "UVMAP" else "")
    if node.type in TEXTURES:
        return of_texture(evaluator, node, socket)
    if node.type == "TEX_IMAGE":
        return of_image(evaluator, node, socket)
    if node.type == "NORMAL":
        return of_normal(evaluator, node, socket)
    made = of_arithmetic(evaluator, node, socket)
    return made if made is not None and any(isinstance(value, Node) for value in made.inputs.values()) else None


def grid_of(node, socket):
    """Name of the grid of a volume that an output shows; none of others."""
    if node.type == "VOLUME_INFO":
        return socket.name.lower()
    return node.attribute_name if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and socket.name != "Alpha" else ""


def of_grid(evaluator, name, kind):
    """What a grid of a volume has."""
    evaluator.grids.add(name)
    return Node(GRID, "multioutput", {"grid": name}, "value" if kind == "float" else "color")


def of_attribute(evaluator, name):
    """A colour attribute."""
    node = Node(ATTRIBUTE, "color3", {"attribute": name})
    node.is_of_place |= evaluator.attributes_vary
    return node


def of_pointiness():
    """Pointiness, from the colours that stand for it."""
    colors = Node(ATTRIBUTE, "color3", {"attribute": pointiness.NAME})
    above, below = (Node("blender_separate_color", "multioutput", {"color": colors}, name) for name in ("red", "green"))
    apart = Node("blender_math", "float", {"a": above, "b": below, "operation": "subtract"})
    half = (pointiness.FLAT,)
    return Node("blender_math", "float", {"a": apart, "b": half, "c": half, "operation": "multiply_add"})


def of_surface(evaluator, node, socket):
    """What the surface gives at a place."""
    source = Node(SURFACE[node.type, socket.name], kind_of(socket))
    if source.category == RANDOM:
        return source
    if node.type in {"NEW_GEOMETRY", "OBJECT_INFO"}:
        # from the axes of shots, where Y is up, to Blender's
        parts = [Node("blender_separate_xyz", "multioutput", {"vector": source}, axis) for axis in "xyz"]
        turned = Node("blender_math", "float", {"a": parts[2], "b": (-1.0,), "operation": "multiply"})
        return Node("blender_combine_xyz", "vector3", {"x": parts[0], "y": turned, "z": parts[1]})
    if node.type == "TEX_COORD" and node.object is not None:
        evaluator.say(f"node `{node.name}`: coordinates of `{node.object.name}` are the object's own")
    return source


def of_eye(evaluator, node, socket):
    """What depends on the angle at which the surface is seen."""
    category, name = EYE[node.type]
    inputs = {name.lower(): taken(evaluator, node, node.inputs[name])}
    toward = eye.toward(evaluator, node)
    if toward is not None:
        inputs["toward"] = operand(toward)
    return Node(category, "multioutput", inputs, socket.name.lower()) if node.type == "LAYER_WEIGHT" else Node(category, "float", inputs)


def of_texture(evaluator, node, socket):
    """A procedural texture."""
    category, options = TEXTURES[node.type]
    inputs = {}
    for entry in node.inputs:
        if entry.type not in TYPES:
            continue
        name = entry.name.lower().replace(" ", "_")
        if name == "orientation":
            name += "_2d" if entry.type == "VALUE" else "_3d"
        if name == "vector" and evaluator.link(entry) is None:
            inputs[name] = Node("blender_generated_coordinates", "vector3")
        else:
            inputs[name] = taken(evaluator, node, entry)
    inputs.update(stated(node, options))
    if node.type == "TEX_WAVE":
        direction = node.bands_direction if node.wave_type == "BANDS" else node.rings_direction
        inputs["shape"] = f"{node.wave_type}_{direction}".lower()
    if node.type == "TEX_GABOR":
        inputs["kind"] = {"2D": "flat", "3D": "solid"}[node.gabor_type]
    output = "value" if socket.name in {"Fac", "Factor", "Value"} else socket.name.lower()
    return Node(category, "multioutput", inputs, output)


def of_image(evaluator, node, socket):
    """A picture at coordinates that are computed; None where it takes those of a UV map, mapped or not."""
    if socket.name != "Color" or node.projection != "FLAT" or evaluator.takes_uv(node.inputs["Vector"]):
        return None
    picture = evaluator.pictures.of(node, is_alone=True) if node.image else None
    pixels = evaluator.pictures.pixels(picture) if picture else None
    at = operand(evaluator.input(node, "Vector"))
    if pixels is None or not isinstance(at, Node):
        return None
    if picture.mosaic is not None:
        at = Node("blender_mapping", "vector3", {"vector": at, "location": (*picture.mosaic.offset, 0.0), "scale": (*picture.mosaic.scale, 1.0)})
    mode = {"EXTEND": "clamp", "MIRROR": "mirror"}.get(node.extension, "periodic")
    return Node("image", "color3", {"file": pixels[:, :, :3], "texcoord": at, "uaddressmode": mode, "vaddressmode": mode})


def of_normal(evaluator, node, socket):
    """A Normal node: how far its input points into its direction."""
    if socket.name != "Dot":
        return None
    at = taken(evaluator, node, node.inputs[0])
    if not isinstance(at, Node):
        return None
    unit = Node("blender_vector_math", "multioutput", {"a": at, "operation": "normalize"}, "out")
    direction = tuple(float(part) for part in node.outputs["Normal"].default_value)
    return Node("blender_vector_math", "multioutput", {"a": unit, "b": direction, "operation": "dot_product"}, "value")


def of_arithmetic(evaluator, node, socket):
    """A node of arithmetic; None where it is not known."""
    if node.type == "MIX":
        return of_mix(evaluator, node)
    if node.type == "MAP_RANGE":
        return of_map_range(evaluator, node)
    if node.type == "VALTORGB":
        return of_ramp(evaluator, node, socket)
    if node.type in {"CURVE_RGB", "CURVE_VEC", "CURVE_FLOAT"}:
        return of_curves(evaluator, node)
    if node.type not in ARITHMETIC:
        return None
    category, names, options = ARITHMETIC[node.type]
    inputs = {name: taken(evaluator, node, entry) for name, entry in zip(names, node.inputs)}
    inputs.update(stated(node, options))
    output = OUTPUTS.get(socket.name, "")
    if node.type == "VECT_MATH":
        output = "value" if socket.name == "Value" else "out"
    if node.type == "SEPXYZ":
        output = socket.name.lower()
    if node.type in {"SEPARATE_COLOR", "SEPRGB"}:
        output = ("red", "green", "blue")[list(node.outputs).index(socket)]
    return Node(category, "multioutput" if output else kind_of(socket), inputs, output)


def of_mix(evaluator, node):
    """A Mix of numbers, vectors or colours."""
    sockets = {
        "FLOAT": ("blender_mix_float", "float", (0, 2, 3)),
        "VECTOR": ("blender_mix_vector", "vector3", (1 if node.factor_mode == "NON_UNIFORM" else 0, 4, 5)),
        "RGBA": ("blender_mix_color", "color3", (0, 6, 7)),
    }
    if node.data_type not in sockets:
        return None
    category, kind, indices = sockets[node.data_type]
    inputs = {name: taken(evaluator, node, node.inputs[index]) for name, index in zip(("factor", "a", "b"), indices)}
    inputs["clamp_factor"] = truth(node.clamp_factor)
    if node.data_type == "RGBA":
        inputs.update(blend=node.blend_type.lower(), clamp_result=truth(node.clamp_result))
    return Node(category, kind, inputs)


def of_map_range(evaluator, node):
    """A Map Range of numbers or vectors."""
    is_vector = node.data_type == "FLOAT_VECTOR"
    names = ("value", "from_min", "from_max", "to_min", "to_max", "steps")
    sockets = list(node.inputs)[6:12] if is_vector else list(node.inputs)[:6]
    inputs = {name: taken(evaluator, node, entry) for name, entry in zip(names, sockets)}
    inputs.update(interpolation=node.interpolation_type.lower(), clamp=truth(node.clamp))
    return Node("blender_map_range_vector", "vector3", inputs) if is_vector else Node("blender_map_range", "float", inputs)


def of_ramp(evaluator, node, socket):
    """A Color Ramp."""
    ramp = node.color_ramp
    stops = [number for stop in ramp.elements for number in (stop.position, *stop.color)]
    inputs = {
        "factor": taken(evaluator, node, node.inputs[0]),
        "mode": ramp.color_mode.lower(),
        "hue": ramp.hue_interpolation.lower(),
        "interpolation": ramp.interpolation.lower(),
        "stops": numbers(stops),
    }
    return Node("blender_color_ramp", "multioutput", inputs, "alpha" if socket.name == "Alpha" else "out")


def of_curves(evaluator, node):
    """Curves of colours, vectors or numbers, sampled as Cycles samples them."""
    mapping = node.mapping
    mapping.initialize()
    curves = list(mapping.curves)
    points = [point.location[0] for curve in curves for point in curve.points]
    low, high = min(points), max(points)
    steps = [low + (high - low) * step / (SAMPLES - 1) for step in range(SAMPLES)]
    inputs = {"from": numbers([low]), "to": numbers([high]), "extrapolate": truth(mapping.extend == "EXTRAPOLATED")}
    if node.type == "CURVE_FLOAT":
        inputs["values"] = numbers([mapping.evaluate(curves[0], at) for at in steps])
        names, category, kind = ("factor", "value"), "blender_float_curve", "float"
    elif node.type == "CURVE_VEC":
        for name, curve in zip("xyz", curves):
            inputs[name] = numbers([mapping.evaluate(curve, at) for at in steps])
        names, category, kind = ("factor", "vector"), "blender_vector_curves", "vector3"
    else:
        for name, curve in zip(("red", "green", "blue"), curves):
            inputs[name] = numbers([mapping.evaluate(curve, mapping.evaluate(curves[3], at)) for at in steps])
        names, category, kind = ("factor", "color"), "blender_rgb_curves", "color3"
    inputs.update({name: taken(evaluator, node, entry) for name, entry in zip(names, node.inputs)})
    return Node(category, kind, inputs)


def taken(evaluator, node, socket):
    """What a node takes from an input: a node, numbers, or the array of a picture."""
    return operand(evaluator.input(node, list(node.inputs).index(socket)))


def operand(value):
    """A value as the input of a node."""
    graph = getattr(value, "graph", None)
    if graph is not None:
        return graph
    return tuple(float(number) for number in value[0, 0]) if value.shape[:2] == (1, 1) else value


def of_value(value):
    """The graph of what varies: of a picture one that shows it."""
    if graph_of(value) is not None:
        return graph_of(value)
    channels = value.shape[2]
    return Node("multiply", "color3" if channels == 3 else "float", {"in1": np.asarray(value), "in2": (1.0,) * channels})


def lerp(share, first, second):
    """Two values mixed: `share` of the second, from 0 to 1."""
    by, one, other = (np.asarray(value) for value in (share, first, second))
    inputs = {"factor": operand(share), "a": operand(first), "b": operand(second)}
    value = one * (1 - by) + other * by
    return computed(value, Node("blender_mix_color", "color3", inputs) if value.shape[2] == 3 else Node("blender_mix_float", "float", inputs))


def bump(heights, scale):
    """The bump map of one or more heights (see Surface) of an object of this scale."""
    of_object = [(graph, strength, distance if is_of_object else distance / scale) for graph, strength, distance, is_of_object in heights]
    if len(of_object) == 1:
        graph, strength, distance = of_object[0]
        return Node("blender_bump", "vector3", {"height": graph, "strength": (strength,), "distance": (distance,)})
    total = (0.0,)
    for graph, strength, distance in of_object:
        total = Node("blender_math", "float", {"a": graph, "b": (strength * distance,), "c": total, "operation": "multiply_add"})
    return Node("blender_bump", "vector3", {"height": total})


def stated(node, options):
    """Options of a node, by the properties that have them."""
    return {name: option(getattr(node, key)) for name, key in options.items() if hasattr(node, key)}


def option(value):
    """An option as text."""
    if isinstance(value, bool):
        return truth(value)
    return value.lower() if isinstance(value, str) else numbers([value])


def truth(value):
    return "true" if value else "false"


def numbers(values):
    """Numbers as text."""
    return ", ".join(f"{float(value):.9g}" for value in values)


def described(node):
    """A text that is the same for equal graphs."""
    document = Document(lambda pixels, _: hashlib.blake2b(np.ascontiguousarray(pixels).tobytes(), digest_size=16).hexdigest())
    document.uv = np.eye(3)
    document.nodes(node, "", {})
    return "\n".join(document.lines)


INPUTS = {
    "base_color": "color3",
    "specular_roughness": "float",
    "base_metalness": "float",
    "transmission_weight": "float",
    "transmission_color": "color3",
    "emission_color": "color3",
    "geometry_opacity": "float",
    "geometry_normal": "vector3",
}
"""Types of the shader's inputs."""


class Document:
    """The MaterialX file of a shot. `pictures(array, name)` gives the file of a picture."""

    def __init__(self, pictures):
        self.pictures, self.lines, self.count = pictures, [], 0

    def add(self, material, inputs, constants, uv, displaced=None, medium=None, has_surface=True):
        """Adds a material: nodes, and constants, of its shader by the names of its inputs.

        `uv`: the 3x3 matrix that has moved the texture coordinates of its meshes. `displaced`: heights that move vertices, a node or a
        number, the length for which 1 stands, and the height that moves nothing. `medium`: what fills its meshes, where that varies.
        """
        self.uv = uv
        self.count += 1
        graph, shader = f"graph_{self.count}", f"shader_{self.count}"
        self.lines.append(f"  <nodegraph name={quoteattr(graph)}>")
        names, of_shader = {}, []
        heights = {"height": displaced[0]} if displaced and isinstance(displaced[0], Node) else {}
        for name, node in (inputs | heights).items():
            self.nodes(node, material, names)
            output = f" output={quoteattr(node.output)}" if node.output else ""
            kind = quoteattr(INPUTS.get(name, "float"))
            self.lines.append(f'    <output name="{name}" type={kind} nodename={quoteattr(names[node])}{output}/>')
            if name in inputs:
                of_shader.append(f'    <input name="{name}" type={kind} nodegraph={quoteattr(graph)} output="{name}"/>')
        volume = [] if medium is None else self._medium(medium, graph, material, names)
        self.lines.append("  </nodegraph>")
        self.lines += volume
        of_volume = f'    <input name="volumeshader" type="volumeshader" nodename="volume_{self.count}"/>'
        if not has_surface:
            self.lines += [f'  <volumematerial name={quoteattr(material)} type="material">', of_volume, "  </volumematerial>"]
            return
        self.lines.append(f"  <open_pbr_surface name={quoteattr(shader)} type=\"surfaceshader\">")
        self.lines += of_shader
        for name, value in constants.items():
            kind = "float" if isinstance(value, (int, float)) else "color3"
            self.lines.append(f"    <input name={quoteattr(name)} type={quoteattr(kind)} value={quoteattr(numbers(np.atleast_1d(value)))}/>")
        self.lines.append("  </open_pbr_surface>")
        if displaced:
            self._displacement(f"displacement_{self.count}", f'nodegraph={quoteattr(graph)} output="height"' if heights else None, displaced)
        self.lines.append(f'  <surfacematerial name={quoteattr(material)} type="material">')
        self.lines.append(f'    <input name="surfaceshader" type="surfaceshader" nodename={quoteattr(shader)}/>')
        if displaced:
            self.lines.append(f'    <input name="displacementshader" type="displacementshader" nodename="displacement_{self.count}"/>')
        self.lines += [of_volume] if volume else []
        self.lines.append("  </surfacematerial>")

    def _medium(self, medium, graph, material, names):
        """Writes what nodes give of a medium into the graph at work. Returns the lines of its shaders, which come behind it."""

        def entry(name, value, kind):
            node = graph_of(value)
            if node is None:
                return f'    <input name="{name}" type="{kind}" value="{numbers(np.asarray(value)[0, 0])}"/>'
            self.nodes(node, material, names)
            output = f" output={quoteattr(node.output)}" if node.output else ""
            self.lines.append(f'    <output name="{name}" type="{kind}" nodename={quoteattr(names[node])}{output}/>')
            return f'    <input name="{name}" type="{kind}" nodegraph={quoteattr(graph)} output="{name}"/>'

        vdf = [entry("scattering", medium.scatter, "vector3"), entry("absorption", medium.absorb, "vector3")]
        edf = entry("color", medium.emit, "color3")
        number = self.count
        return [
            f'  <anisotropic_vdf name="vdf_{number}" type="VDF">',
            *vdf,
            f'    <input name="anisotropy" type="float" value="{numbers([medium.anisotropy])}"/>',
            "  </anisotropic_vdf>",
            f'  <uniform_edf name="edf_{number}" type="EDF">',
            edf,
            "  </uniform_edf>",
            f'  <volume name="volume_{number}" type="volumeshader">',
            f'    <input name="vdf" type="VDF" nodename="vdf_{number}"/>',
            f'    <input name="edf" type="EDF" nodename="edf_{number}"/>',
            "  </volume>",
        ]

    def _displacement(self, name, source, displaced):
        """Writes what moves vertices. `source`: where its heights come from, if they are no number."""
        height, length, middle = displaced
        self.lines += [
            f'  <blender_displacement name="{name}" type="displacementshader">',
            f'    <input name="displacement" type="float" {source or f"value={quoteattr(numbers([height]))}"}/>',
            f'    <input name="scale" type="float" value="{numbers([length])}"/>',
            f'    <input name="midlevel" type="float" value="{numbers([middle])}"/>',
            "  </blender_displacement>",
        ]

    def nodes(self, last, material, names):
        """Writes the nodes on which one depends, each behind what it takes, without recursion: graphs may be deep."""
        way = [last]
        while way:
            node = way[-1]
            missing = [value for value in node.inputs.values() if isinstance(value, Node) and value not in names]
            if node in names or not missing:
                way.pop()
                if node not in names:
                    names[node] = f"n{len(names) + 1}"
                    self._node(node, material, names)
            else:
                way.extend(missing)

    def _uv(self, name):
        """Writes the texture coordinates that meshes had before they were moved."""
        if np.allclose(self.uv, np.eye(3)):
            self.lines.append(f'    <blender_uv name="{name}" type="vector3"/>')
            return
        back = np.linalg.pinv(self.uv)
        self.lines.append(f'    <blender_uv name="{name}_moved" type="vector3"/>')
        for row, axis in zip(back[:2], "xy"):
            self.lines += [
                f'    <blender_vector_math name="{name}_{axis}" type="multioutput">',
                f'      <input name="a" type="vector3" nodename="{name}_moved"/>',
                f'      <input name="b" type="vector3" value="{numbers([row[0], row[1], 0])}"/>',
                '      <input name="operation" type="string" value="dot_product"/>',
                "    </blender_vector_math>",
                f'    <blender_math name="{name}_{axis}_at" type="float">',
                f'      <input name="a" type="float" nodename="{name}_{axis}" output="value"/>',
                f'      <input name="b" type="float" value="{numbers([row[2]])}"/>',
                "    </blender_math>",
            ]
        self.lines += [
            f'    <blender_combine_xyz name="{name}" type="vector3">',
            f'      <input name="x" type="float" nodename="{name}_x_at"/>',
            f'      <input name="y" type="float" nodename="{name}_y_at"/>',
            "    </blender_combine_xyz>",
        ]

    def _node(self, node, material, names):
        if node.category == "uv":
            self._uv(names[node])
            return
        if node.category == ATTRIBUTE:
            # which one it is, the mesh says
            self.lines.append(f'    <{ATTRIBUTE} name="{names[node]}" type="color3"/>')
            return
        inputs = []
        for name, value in node.inputs.items():
            key = f"      <input name={quoteattr(name)}"
            if isinstance(value, Node):
                output = f" output={quoteattr(value.output)}" if value.output else ""
                inputs.append(f"{key} type={quoteattr(value.kind)} nodename={quoteattr(names[value])}{output}/>")
            elif isinstance(value, np.ndarray) and name == "file":
                file = quoteattr(self.pictures(value, material))
                inputs.append(f'{key} type="filename" value={file} colorspace="srgb_texture"/>')
            elif isinstance(value, np.ndarray):
                picture = f"{names[node]}_{name}"
                kind = "color3" if value.shape[2] == 3 else "float"
                self.lines.append(f"    <image name={quoteattr(picture)} type={quoteattr(kind)}>")
                file = quoteattr(self.pictures(value, material))
                self.lines.append(f'      <input name="file" type="filename" value={file} colorspace="srgb_texture"/>')
                self.lines.append("    </image>")
                inputs.append(f"{key} type={quoteattr(kind)} nodename={quoteattr(picture)}/>")
            elif isinstance(value, str):
                inputs.append(f"{key} type=\"string\" value={quoteattr(value)}/>")
            else:
                kind = "float" if len(value) == 1 else "color3"
                inputs.append(f"{key} type={quoteattr(kind)} value={quoteattr(numbers(value))}/>")
        head = f"    <{node.category} name={quoteattr(names[node])} type={quoteattr(node.kind)}"
        self.lines += [f"{head}>", *inputs, f"    </{node.category}>"] if inputs else [f"{head}/>"]

    def text(self):
        """The file; empty without materials."""
        if not self.lines:
            return ""
        head = ['<?xml version="1.0" encoding="utf-8"?>', '<materialx version="1.39" colorspace="lin_rec709">']
        return "\n".join([*head, *self.lines, "</materialx>", ""])
