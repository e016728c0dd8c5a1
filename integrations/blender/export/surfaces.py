# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders to one surface: what a material's node tree reflects, lets through and emits, as parameters."""

from dataclasses import dataclass, field, fields, replace

import numpy as np

from . import eye, graphs, layers
from .nodes import SAME_TO_ALL, alike, color, constant, number
from .rays import KINDS, Seen
from .volumes import medium_of


@dataclass
class Surface:
    """Parameters of a Principled BSDF, as values of nodes.py."""

    base: np.ndarray = field(default_factory=lambda: constant(0.8, 0.8, 0.8))
    metallic: np.ndarray = field(default_factory=lambda: constant(0.0))
    roughness: np.ndarray = field(default_factory=lambda: constant(0.5))
    ior: np.ndarray = field(default_factory=lambda: constant(1.5))
    specular: np.ndarray = field(default_factory=lambda: constant(1.0))
    """Factor of what is no metal reflects at right angles; 0: matt."""
    anisotropy: np.ndarray = field(default_factory=lambda: constant(0.0))
    """How much narrower the lobe of its reflection is across the tangent than along it."""
    entry: tuple | None = None
    """Of the interface by which light goes below the surface: its index of refraction, its roughness, and the share that goes in by the cosine law."""
    tangent: tuple = (0.0, "z")
    """Turn of the tangent in degrees, and the axis of the object around which it leads; None for that of the UV map."""
    edge: np.ndarray = field(default_factory=lambda: constant(1.0))
    """How white metal is at grazing angles."""
    matt_roughness: np.ndarray = field(default_factory=lambda: constant(0.0))
    """How rough what scatters light is."""
    fuzz: np.ndarray = field(default_factory=lambda: constant(0.0))
    fuzz_tint: np.ndarray = field(default_factory=lambda: constant(1.0, 1.0, 1.0))
    fuzz_roughness: np.ndarray = field(default_factory=lambda: constant(0.5))
    alpha: np.ndarray = field(default_factory=lambda: constant(1.0))
    transmission: np.ndarray = field(default_factory=lambda: constant(0.0))
    """Share of the surface that is glass: of that of Principled BSDF what is no metal."""
    tint: np.ndarray = field(default_factory=lambda: constant(1.0, 1.0, 1.0))
    """Colour of the light that transmission lets through one side of the surface."""
    coat: np.ndarray = field(default_factory=lambda: constant(0.0))
    coat_roughness: np.ndarray = field(default_factory=lambda: constant(0.03))
    coat_ior: np.ndarray = field(default_factory=lambda: constant(1.5))
    coat_tint: np.ndarray = field(default_factory=lambda: constant(1.0, 1.0, 1.0))
    """Colour of light that has passed the coat, in and out again."""
    emission: np.ndarray = field(default_factory=lambda: constant(0.0, 0.0, 0.0))
    """Radiance, alpha included."""
    subsurface: np.ndarray = field(default_factory=lambda: constant(0.0))
    """Share of its diffuse light that goes below it."""
    radius: np.ndarray = field(default_factory=lambda: constant(0.05, 0.01, 0.005))
    """Mean free path below it, by channel."""
    translucency: np.ndarray = field(default_factory=lambda: constant(0.0))
    """Share of its diffuse light that leaves on the other side."""
    absorption: np.ndarray = field(default_factory=lambda: constant(0.0, 0.0, 0.0))
    """What glass absorbs of light on its way, for each unit of length."""
    shine: np.ndarray = field(default_factory=lambda: constant(1.0, 1.0, 1.0))
    """Colour of what glass reflects."""
    veil: np.ndarray = field(default_factory=lambda: constant(1.0, 1.0, 1.0))
    """Colour of the light that passes where alpha lets it."""
    normal: np.ndarray | None = None
    """Directions from 0 to 1 as normal maps have them."""
    bump: tuple | None = None
    """Heights, and the slope's factor (strength times distance)."""
    heights: tuple = ()
    """Heights that are on top of these: of each the graph, its strength, the distance for which a height of 1 stands, and whether that is
    one in the object or in the world."""
    displaced: tuple = ()
    """What moves its vertices: heights, the length for which a height of 1 stands in the object, and the height that moves nothing."""
    hair: tuple | None = None
    """Of fibres in place of all that reflects: roughness along them and around them, coat, index of refraction, and the tilt of their scales in
    degrees. The base is the colour that they have in the end."""
    is_there: bool = True
    """False where a material has no surface: what lies in it is a volume alone."""
    medium: tuple = ()
    """What fills closed meshes of it: scatter, absorb, emit and anisotropy; nothing of clear ones."""
    has_surface: bool = True
    """False where it is a medium alone."""
    seen: Seen = Seen()
    """To which rays it shows itself."""


BLENDED = (
    *("base", "metallic", "roughness", "ior", "specular", "transmission", "tint", "shine", "coat", "coat_roughness", "coat_ior", "coat_tint"),
    *("anisotropy", "edge", "matt_roughness", "fuzz", "fuzz_tint", "fuzz_roughness", "subsurface", "radius", "translucency", "absorption"),
)

WEIGHED = {"edge": "metallic", "fuzz_tint": "fuzz", "fuzz_roughness": "fuzz", "coat_roughness": "coat", "coat_ior": "coat", "coat_tint": "coat"}
"""Parameters of parts of a surface, by the share that the part has: where there is none of it, they mean nothing."""


def surface_of(evaluator, material):
    """The surface of a material's active output. Without nodes: its viewport colour."""
    tree = material.node_tree if material.use_nodes else None
    if tree is None:
        return Surface(
            base=constant(*list(material.diffuse_color)[:3]), metallic=constant(material.metallic), roughness=constant(material.roughness)
        )
    outputs = [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL" and node.target in {"ALL", "CYCLES"}]
    outputs.sort(key=lambda node: not node.is_active_output)
    if not outputs:
        return Surface(base=constant(0.0, 0.0, 0.0), specular=constant(0.0))
    volume, displacement = (evaluator.link(outputs[0].inputs[name]) for name in ("Volume", "Displacement"))
    with evaluator.source(outputs[0].inputs["Surface"]) as (surface, _):
        pass
    if surface is None and volume:
        medium = medium_of(evaluator, outputs[0].inputs["Volume"])
        return Surface(base=constant(0.0, 0.0, 0.0), specular=constant(0.0), medium=packed(medium), has_surface=False)
    shown = behind(evaluator, outputs[0], "Surface")
    if volume:
        fill(evaluator, outputs[0].inputs["Volume"], shown)
    if displacement:
        raise_surface(evaluator, outputs[0].inputs["Displacement"], material, shown)
    return shown


def fill(evaluator, socket, surface):
    """Has glass absorb light as its volume does, and closed meshes of other surfaces be filled."""
    with evaluator.source(socket) as (source, _):
        if source is not None and source.type == "VOLUME_ABSORPTION" and not is_zero(surface.transmission):
            density = evaluator.input(source, "Density").mean()
            surface.absorption = constant(*np.clip((1 - color(evaluator.input(source, "Color"))).mean(axis=(0, 1)) * density, 0, None))
            return
    surface.medium = packed(medium_of(evaluator, socket))


def packed(medium):
    """A medium as parts of a surface are."""
    return (*medium.colors().values(), constant(medium.anisotropy))


FINER = "what of its displacement is finer than its mesh is not shown"
"""Told of displacement that moves vertices and bends normals."""


def raise_surface(evaluator, socket, material, surface):
    """Has the displacement of a surface move its vertices, or bend its normals as a bump map, as its material says."""
    with evaluator.source(socket) as (source, _):
        if source is None or source.type != "DISPLACEMENT" or source.space != "OBJECT":
            evaluator.say("its displacement is left out")
            return
        height = evaluator.input(source, "Height")
        scale = float(evaluator.input(source, "Scale").mean())
        middle = float(evaluator.input(source, "Midlevel").mean())
    is_even = height.shape[:2] == (1, 1) and graphs.graph_of(height) is None
    if material.displacement_method != "BUMP":
        surface.displaced = (height, scale, middle)
    if is_even or material.displacement_method == "DISPLACEMENT":
        return
    if material.displacement_method == "BOTH":
        # normals of what has moved lean by its heights already, and Cycles bends those of before
        evaluator.say(FINER)
        return
    if graphs.graph_of(height) is not None:
        surface.heights += ((graphs.graph_of(height), 1.0, scale, True),)
    elif surface.bump is not None or surface.normal is not None:
        evaluator.say("its displacement is left out beside a bump map")
    else:
        surface.bump = (height, scale)


def surface_to_all(evaluator_of, material):
    """The surface of a material to all rays that see it, and its evaluator. `evaluator_of(ray)`: a new one for a kind of rays, or for all."""

    def read(ray):
        evaluator = evaluator_of(ray)
        return surface_of(evaluator, material), evaluator

    surface, evaluator = read(None)
    if not evaluator.tells_rays_apart:
        return surface, evaluator
    found = {kind: read(kind) for kind in KINDS}
    # Cycles asks what lights matt surfaces without a ray, and not what their rays meet
    light = read("light")
    if any(float(surface.emission.max()) > 0 for surface, _ in (light, found["diffuse"])):
        found["diffuse"] = light
    there = [kind for kind in KINDS if not is_nothing(found[kind][0])]
    # where the camera alone sees a hole, it is one of what all others see
    holdout = "camera" in there and found["camera"][0].seen.holdout
    shown = [kind for kind in there if not (holdout and kind == "camera")] or ["camera"]
    surface, evaluator = found[shown[0]]
    if not all(are_alike(found[kind][0], surface) for kind in shown[1:]):
        evaluator.say(SAME_TO_ALL.format("the camera sees" if shown[0] == "camera" else f"{shown[0]} rays see"))
    if any(is_colored(found[kind][0]) for kind in KINDS if kind not in there) and there:
        evaluator.say("the colour of its transparent shader is left out")
    # nothing to anyone is shown as Blender has it: as what is clear
    surface.seen = Seen(frozenset(KINDS) - set(there) if there else frozenset(), holdout or surface.seen.holdout)
    return surface, evaluator


def is_nothing(surface):
    """Returns true if light passes a surface as if it were not there."""
    return not surface.is_there or (is_zero(surface.alpha) and is_zero(surface.emission))


def is_zero(value):
    """Returns true if a value is 0 everywhere."""
    return float(value.max()) <= 0 and graphs.graph_of(value) is None


def is_whole(surface):
    """Returns true if all of a surface is there."""
    return float(surface.alpha.min()) > 0.999 and graphs.graph_of(surface.alpha) is None


def is_colored(surface):
    """Returns true if what passes a surface where it is not there has its colour."""
    return float(surface.veil.min()) < 0.99 and float(surface.alpha.min()) < 0.999


def are_alike(one, other):
    """Returns true if two surfaces are the same to whoever sees them."""
    return all(is_same(getattr(one, each.name), getattr(other, each.name)) for each in fields(Surface) if each.name != "seen")


def is_same(one, other):
    """Returns true if values of two surfaces are the same."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return all(map(is_same, one, other))
    pair = [value if isinstance(value, graphs.Node) else graphs.graph_of(value) for value in (one, other)]
    if any(graph is not None for graph in pair):
        return all(graph is not None for graph in pair) and graphs.described(pair[0]) == graphs.described(pair[1])
    return np.array_equal(one, other)


def behind(evaluator, node, name):
    """The surface of a shader input of a node, by its name or number."""
    with evaluator.source(node.inputs[name]) as (source, output):
        if source is None:
            return Surface(base=constant(0.0, 0.0, 0.0), specular=constant(0.0))
        if output.type != "SHADER":
            # as Cycles reads it
            return Surface(base=constant(0.0, 0.0, 0.0), specular=constant(0.0), emission=color(evaluator.output(source, output)))
        method = SHADERS.get(source.type)
        if method is None:
            evaluator.say(f"shader `{source.name}` ({source.bl_label}) is shown as matt grey")
            return Surface(specular=constant(0.0))
        return method(evaluator, source)


def read_normal(evaluator, node, surface):
    """Sets the surface's normal map or bump map of the node's Normal input."""
    socket = node.inputs.get("Normal")
    if socket is not None:
        with evaluator.source(socket) as (source, _):
            if source is not None:
                set_normal(evaluator, source, surface)
    return surface


STRAIGHT = np.array([0.5, 0.5, 1.0], dtype=np.float32)
"""What a normal map has where it bends nothing."""


def set_normal(evaluator, source, surface):
    """Sets what a node says of normals."""
    if source.type == "BUMP":
        height = evaluator.input(source, "Height")
        strength, distance = (float(evaluator.input(source, name).mean()) for name in ("Strength", "Distance"))
        if graphs.graph_of(height) is not None:
            surface.heights += ((graphs.graph_of(height), min(max(strength, 0.0), 1.0), -distance if source.invert else distance, False),)
            read_normal(evaluator, source, surface)
        elif height.shape[:2] != (1, 1):
            slope = strength * distance
            surface.bump = (height, -slope if source.invert else slope)
            if evaluator.link(source.inputs["Normal"]):
                evaluator.say("of a bump map on top of a normal map the bump map alone is shown")
        else:
            read_normal(evaluator, source, surface)
    elif source.type == "NORMAL_MAP":
        if source.space != "TANGENT":
            evaluator.say(f"normal map `{source.name}`: only those in tangent space are shown")
            return
        normal = color(evaluator.input(source, "Color"))
        strength = float(evaluator.input(source, "Strength").mean())
        if abs(strength - 1) > 1e-4:
            direction = (normal * 2 - 1) * strength + np.array([0, 0, 1]) * (1 - strength)
            length = np.maximum(np.linalg.norm(direction, axis=2, keepdims=True), 1e-6)
            normal = (direction / length * 0.5 + 0.5).astype(np.float32)
        if np.abs(normal - STRAIGHT).max() > 0.01:
            # of a missing picture all over the same, and askew, as in Cycles: meshes need coordinates all the same
            evaluator.uv = evaluator.uv or (source.uv_map, np.eye(3))
            surface.normal = normal
    else:
        evaluator.say(f"normals by node `{source.name}` ({source.bl_label}) are left out")


def principled(evaluator, node):
    """A Principled BSDF."""
    surface = Surface(
        base=color(evaluator.input(node, "Base Color")),
        metallic=evaluator.input(node, "Metallic"),
        roughness=evaluator.input(node, "Roughness"),
        ior=evaluator.input(node, "IOR"),
        specular=evaluator.input(node, "Specular IOR Level") * 2,
        alpha=evaluator.input(node, "Alpha"),
        transmission=evaluator.input(node, "Transmission Weight"),
        coat=evaluator.input(node, "Coat Weight"),
        coat_roughness=evaluator.input(node, "Coat Roughness"),
        coat_ior=evaluator.input(node, "Coat IOR"),
        coat_tint=color(evaluator.input(node, "Coat Tint")),
        subsurface=evaluator.input(node, "Subsurface Weight"),
        radius=color(evaluator.input(node, "Subsurface Radius")) * evaluator.input(node, "Subsurface Scale"),
    )
    if not is_zero(surface.transmission) and not is_zero(surface.metallic):
        share, metallic = alike(surface.transmission, np.clip(surface.metallic, 0, 1))
        surface.transmission = share * (1 - metallic)
    scatter(evaluator, node, node.subsurface_method, "Subsurface IOR", surface)
    # light that goes in and out again has the base colour, as in Cycles
    surface.tint = np.sqrt(np.clip(surface.base, 0, 1))
    light, strength, alpha = alike(color(evaluator.input(node, "Emission Color")), evaluator.input(node, "Emission Strength"), surface.alpha)
    surface.emission = light * strength * alpha
    if node.inputs.get("Diffuse Roughness"):
        surface.matt_roughness = evaluator.input(node, "Diffuse Roughness")
    if node.inputs.get("Sheen Weight"):
        surface.fuzz = evaluator.input(node, "Sheen Weight")
        surface.fuzz_tint = np.clip(color(evaluator.input(node, "Sheen Tint")), 0, 1)
        surface.fuzz_roughness = evaluator.input(node, "Sheen Roughness")
    if node.inputs.get("Anisotropic"):
        brush(evaluator, node, "Anisotropic", "Anisotropic Rotation", surface)
    if node.inputs.get("Thin Film Thickness") and float(evaluator.input(node, "Thin Film Thickness").max()) > 1e-3:
        evaluator.say("its thin film is left out")
    if node.inputs.get("Specular Tint"):
        tint_reflection(evaluator, color(evaluator.input(node, "Specular Tint")), surface)
    return read_normal(evaluator, node, surface)


MOST_ANISOTROPIC = 0.9
"""What an anisotropy of 1 is: the square of the aspect of both widths is as much less than 1."""


def brush(evaluator, node, amount, rotation, surface):
    """Has a surface spread light along its tangent, by inputs of a node. Widths are those of Cycles: the square of the roughness over the aspect,
    and times it; those of the renderer have the square of the roughness as the mean of their squares."""
    amount = float(evaluator.input(node, amount).mean())
    if abs(amount) < 1e-3:
        return
    turn = 360 * float(evaluator.input(node, rotation).mean())
    if amount < 0:
        # wide across the tangent
        amount, turn = -amount, turn + 90
    share = 1 - MOST_ANISOTROPIC * min(amount, 1.0)
    surface.anisotropy = constant(1 - share)
    surface.roughness = np.clip(surface.roughness * ((1 + share * share) / (2 * share)) ** 0.25, 0, 1)
    surface.tangent = (turn % 360, tangent_of(evaluator, node))


def tangent_of(evaluator, node):
    """The axis around which the tangent of a node leads; None if it is that of the UV map."""
    socket = node.inputs.get("Tangent")
    with evaluator.source(socket) as (source, _):
        if source is None:
            return "z"
        if source.type == "TANGENT":
            if source.direction_type == "RADIAL":
                return source.axis.lower()
            evaluator.uv = evaluator.uv or (source.uv_map, np.eye(3))
            return None
        evaluator.say(f"its tangent by node `{source.name}` ({source.bl_label}) is that of its UV map")
        return None


AT_TINT = (6 / 7) ** 5
"""Share of white in Schlick's formula at a cosine of 1/7, where a tint of metal counts (F82)."""


def tint_reflection(evaluator, tint, surface):
    """Dims what a surface reflects by its specular tint: what is no metal at right angles, metal towards its edges."""
    tint = np.clip(tint.mean(axis=(0, 1)), 0, 1)
    if float(np.ptp(tint)) > 0.05:
        evaluator.say("the colour of its specular tint is left out")
    tint = float(tint.mean())
    if tint > 0.99:
        return
    surface.specular = surface.specular * tint
    head_on = min(float(np.clip(surface.base, 0, 1).mean()), 0.999)
    tinted = tint * (head_on + (1 - head_on) * AT_TINT)
    surface.edge = constant(min(max((tinted - head_on) / ((1 - head_on) * AT_TINT), 0.0), 1.0))


def diffuse(evaluator, node):
    """A Diffuse BSDF."""
    surface = Surface(base=color(evaluator.input(node, "Color")), specular=constant(0.0), roughness=constant(1.0))
    if node.inputs.get("Roughness"):
        surface.matt_roughness = evaluator.input(node, "Roughness")
    return read_normal(evaluator, node, surface)


def translucent(evaluator, node):
    """A Translucent BSDF: all of its light leaves on the other side."""
    return replace(diffuse(evaluator, node), translucency=constant(1.0))


def sheen(evaluator, node):
    """A Sheen BSDF, formerly Velvet: fuzz above nothing."""
    if getattr(node, "distribution", "MICROFIBER") != "MICROFIBER":
        evaluator.say(f"shader `{node.name}` ({node.bl_label}) is shown as Microfiber")
    roughness = evaluator.input(node, "Roughness") if node.inputs.get("Roughness") else evaluator.input(node, "Sigma")
    surface = Surface(base=constant(0.0, 0.0, 0.0), specular=constant(0.0), fuzz=constant(1.0), fuzz_roughness=roughness)
    surface.fuzz_tint = np.clip(color(evaluator.input(node, "Color")), 0, 1)
    return read_normal(evaluator, node, surface)


def subsurface(evaluator, node):
    """A Subsurface Scattering shader."""
    surface = Surface(
        base=color(evaluator.input(node, "Color")),
        specular=constant(0.0),
        subsurface=constant(1.0),
        radius=color(evaluator.input(node, "Radius")) * evaluator.input(node, "Scale"),
    )
    scatter(evaluator, node, node.falloff, "IOR", surface)
    return read_normal(evaluator, node, surface)


def scatter(evaluator, node, method, index, surface):
    """Turns the radius of a surface into the mean free path that its method means by it, and sets how light goes in, as Cycles has both
    (`subsurface_entry_bounce`). `index`: name of the input that has the index of refraction of skin."""
    if method == "RANDOM_WALK_SKIN":
        colors = np.clip(surface.base.mean(axis=(0, 1)), 0, 1)
        bending = max(1.0, float(evaluator.input(node, index).mean()))
        surface.radius = surface.radius * layers.path_of_skin(colors, bending)
        surface.entry = (bending, 1.0, 0.5)
        return
    surface.radius = surface.radius * layers.PATH_OF_RADIUS
    if method == "RANDOM_WALK" and node.type != "BSDF_PRINCIPLED":
        # that of Principled BSDF bends light as its layer does
        bending, roughness = (float(evaluator.input(node, name).mean()) for name in ("IOR", "Roughness"))
        surface.entry = (max(1.0, bending), min(max(roughness, 0.0), 1.0), 0.0)
    elif method == "BURLEY" and not is_zero(surface.subsurface):
        evaluator.say("its subsurface scattering is a random walk, and not that of Christensen and Burley")


def as_diffuse(evaluator, node):
    """Scatters of other kinds, as matt."""
    evaluator.say(f"shader `{node.name}` ({node.bl_label}) is shown as matt")
    return read_normal(evaluator, node, Surface(base=color(evaluator.input(node, "Color")), specular=constant(0.0)))


ONCE = {"GGX": 1.0, "BECKMANN": 0.75}
"""Distributions of facets that reflect light once and lose the rest: as much as those of GGX whose roughness is so many times theirs."""

LEAST_LOSS = 0.02
"""Share that facets lose below which a colour stays as it is, so that its picture can be copied."""


def glossy(evaluator, node):
    """A Glossy BSDF: bare metal. That of the renderer loses nothing."""
    base, roughness = color(evaluator.input(node, "Color")), evaluator.input(node, "Roughness")
    kept = layers.at_once(roughness.mean() * ONCE[node.distribution]) if node.distribution in ONCE else 1.0
    if 1 - kept > LEAST_LOSS:
        base = layers.metal_of_share(np.clip(base, 0, 1) * kept, roughness.mean())
    surface = Surface(base=base, metallic=constant(1.0), roughness=roughness, edge=constant(0.0))
    if node.inputs.get("Anisotropy"):
        brush(evaluator, node, "Anisotropy", "Rotation", surface)
    return read_normal(evaluator, node, surface)


def glass(evaluator, node):
    """A Glass or Refraction BSDF."""
    surface = Surface(
        base=color(evaluator.input(node, "Color")),
        roughness=evaluator.input(node, "Roughness"),
        ior=evaluator.input(node, "IOR"),
        transmission=constant(1.0),
    )
    # what is reflected has the colour as well; a Refraction BSDF reflects nothing
    surface.tint, surface.shine = surface.base, np.clip(surface.base, 0, 1) * (node.type == "BSDF_GLASS")
    return read_normal(evaluator, node, surface)


def transparent(evaluator, node):
    """A Transparent BSDF: nothing of the surface is there, and light passes in its colour."""
    return Surface(alpha=constant(0.0), veil=np.clip(color(evaluator.input(node, "Color")), 0, 1))


def metallic(evaluator, node):
    """A Metallic BSDF: bare metal, of a colour or of the constants of a metal (by Fresnel's equations at right angles)."""
    if node.fresnel_type == "F82":
        base = color(evaluator.input(node, "Base Color"))
    else:
        index, extinction = (color(evaluator.input(node, name)) for name in ("IOR", "Extinction"))
        base = ((index - 1) ** 2 + extinction**2) / ((index + 1) ** 2 + extinction**2)
    surface = Surface(base=base, metallic=constant(1.0), roughness=evaluator.input(node, "Roughness"))
    if node.inputs.get("Anisotropy"):
        brush(evaluator, node, "Anisotropy", "Rotation", surface)
    return read_normal(evaluator, node, surface)


def emission(evaluator, node):
    """An Emission shader."""
    light, strength = alike(color(evaluator.input(node, "Color")), evaluator.input(node, "Strength"))
    return Surface(base=constant(0.0, 0.0, 0.0), specular=constant(0.0), emission=light * strength)


def holdout(evaluator, node):
    """A Holdout: a hole to the camera, and black to all others."""
    return Surface(base=constant(0.0, 0.0, 0.0), specular=constant(0.0), seen=Seen(holdout=True))


def strength_of(surface):
    """How much a surface reflects head-on, as one number."""
    head_on = ((surface.ior - 1) / (surface.ior + 1)) ** 2 * surface.specular
    metallic, head_on, base, coat = (float(part.mean()) for part in (surface.metallic, head_on, surface.base, surface.coat))
    return metallic * base + (1 - metallic) * head_on + 0.04 * coat


def share_of_second(first, second, otherwise):
    """The share that the second one of two weights has of both, where there is any."""
    first, second, otherwise = alike(first, second, otherwise)
    both = first + second
    share = second / np.maximum(both, 1e-6)
    return graphs.carried(share, np.where(np.asarray(both) > 1e-6, np.asarray(share), np.asarray(otherwise)))


def share_of_number(first, second, otherwise):
    """share_of_second of two numbers."""
    both = float(first) + float(second)
    return float(second) / both if both > 1e-6 else otherwise


def share_of_shine(first, second, otherwise):
    """The share that the second one of two surfaces, each with its weight, has of how rough reflections are: what reflects nothing has none."""
    (one, weight), (other, other_weight) = first, second
    strengths = strength_of(one), strength_of(other)
    if graphs.graph_of(otherwise) is not None and min(strengths) <= 0:
        return otherwise if max(strengths) <= 0 else constant(0.0 if strengths[1] <= 0 else 1.0)
    return share_of_second(*alike(weight * strengths[0], other_weight * strengths[1]), otherwise)


def has_part(part, weight):
    """Returns true if there is anything of a part of a surface with this weight."""
    return not (is_zero(part) or is_zero(weight) or is_zero(np.multiply(*alike(part, weight))))


def share_of_part(first, second, otherwise):
    """The share that the second one of two surfaces has of a part of both. Of each: how much of it is that part, and its weight."""
    if not has_part(*second):
        return constant(0.0) if has_part(*first) else otherwise
    if not has_part(*first):
        return constant(1.0)
    return share_of_second(*(np.multiply(*alike(*of)) for of in (first, second)), otherwise)


OF_GLASS = ("tint", "ior")
"""Parameters that are those of the glass of a surface, where a part of it is glass."""


def blend(first, second, share):
    """Mixes two surfaces: `share` of the second."""
    alpha_a, alpha_b, share = alike(first.alpha, second.alpha, number(share))
    share = np.clip(share, 0, 1)
    weight_a, weight_b = alpha_a * (1 - share), alpha_b * share
    has_glass = has_part(first.transmission, weight_a) or has_part(second.transmission, weight_b)
    if is_whole(first) and is_whole(second):
        alpha, of_second = first.alpha, share
    elif (has_glass or graphs.graph_of(share) is not None) and is_zero(first.alpha):
        alpha, of_second, weight_a = weight_b, constant(1.0), first.alpha
    elif (has_glass or graphs.graph_of(share) is not None) and is_zero(second.alpha):
        alpha, of_second, weight_b = weight_a, constant(0.0), second.alpha
    else:
        alpha, of_second = weight_a + weight_b, share_of_second(weight_a, weight_b, share)

    def mixed(name, by):
        one, other, by = alike(getattr(first, name), getattr(second, name), by)
        # an unchanged picture stays the same array, so that its file can be copied
        if graphs.graph_of(by) is None:
            if (by <= 0).all():
                return getattr(first, name)
            if (by >= 1).all():
                return getattr(second, name)
        elif is_same(one, other):
            return one
        if any(graphs.graph_of(part) is not None for part in (one, other, by)):
            return graphs.lerp(by, one, other)
        return one * (1 - by) + other * by

    by_part = {"roughness", "shine", "translucency", "base", *OF_GLASS, *WEIGHED}
    values = {name: mixed(name, of_second) for name in BLENDED if name not in by_part}
    of_glass = of_base = of_second
    if has_glass:
        # glass has no base, and nothing else a tint
        of_glass = share_of_part((first.transmission, weight_a), (second.transmission, weight_b), of_second)
        of_base = share_of_part((1 - first.transmission, weight_a), (1 - second.transmission, weight_b), of_second)
    values.update({name: mixed(name, of_glass) for name in OF_GLASS}, base=mixed("base", of_base))
    for name, weight in WEIGHED.items():
        weights = alike(getattr(first, weight), getattr(second, weight), weight_a, weight_b)
        by = constant(share_of_number(weights[0].mean() * weights[2].mean(), weights[1].mean() * weights[3].mean(), float(of_second.mean())))
        values[name] = mixed(name, by)
    scattered = [float((number(part.base).mean() * weight).mean()) for part, weight in ((first, weight_a), (second, weight_b))]
    values["translucency"] = mixed("translucency", constant(share_of_number(*scattered, float(of_second.mean()))))
    of_shine = share_of_shine((first, weight_a), (second, weight_b), of_second)
    values.update(roughness=mixed("roughness", of_shine), shine=mixed("shine", of_shine))
    # what is clear has no part in it
    parts = [surface for surface, weight in ((first, weight_a), (second, weight_b)) if not is_zero(weight)]
    larger = second if float(of_second.mean()) > 0.5 else first
    smaller = first if larger is second else second
    return Surface(
        **values,
        alpha=alpha,
        veil=mixed("veil", share_of_second((1 - alpha_a) * (1 - share), (1 - alpha_b) * share, share)),
        emission=mixed("emission", share),
        normal=larger.normal if larger.normal is not None else smaller.normal,
        bump=larger.bump or smaller.bump,
        heights=larger.heights or smaller.heights,
        tangent=(larger if not is_zero(larger.anisotropy) else smaller).tangent,
        entry=larger.entry or smaller.entry,
        hair=larger.hair,
        seen=Seen(holdout=bool(parts) and all(surface.seen.holdout for surface in parts)),
    )


def joined(evaluator, first, second, share):
    """A blend of two surfaces, one of which may be a holdout."""
    surface = blend(first, second, share)
    if any(part.seen.holdout and (share != end).any() for part, end in ((first, 1), (second, 0))) and not surface.seen.holdout:
        evaluator.say("its holdout is black beside other shaders")
    return surface


def has_normals(surface):
    """Returns true if something bends the normals of a surface."""
    return surface.normal is not None or surface.bump is not None or bool(surface.heights)


def normals_of(surface):
    """What bends the normals of a surface."""
    return {"normal": surface.normal, "bump": surface.bump, "heights": surface.heights}


def is_mirror(surface):
    """Returns true if a surface reflects and does nothing else."""
    return float(surface.metallic.min()) > 0.99 and graphs.graph_of(surface.metallic) is None and is_whole(surface) and is_zero(surface.emission)


def is_fuzz(surface):
    """Returns true if a surface is fuzz and nothing else."""
    return is_zero(surface.base) and is_zero(surface.specular) and is_zero(surface.emission) and not is_zero(surface.fuzz) and is_whole(surface)


def is_opaque(surface):
    """Returns true if no light goes into a surface and through."""
    return is_zero(surface.transmission) and not is_nothing(surface)


def has_no_layer(surface):
    """Returns true if a surface scatters light, without anything on top of it."""
    return all(is_zero(part) for part in (surface.specular, surface.metallic, surface.transmission, surface.coat)) and not is_nothing(surface)


def mix(evaluator, node):
    """A Mix Shader."""
    first, second = behind(evaluator, node, 1), behind(evaluator, node, 2)
    share = evaluator.input(node, 0)
    both = None
    if share.shape[:2] == (1, 1):
        of_second = eye.by_angle(evaluator, node, 0)
        if of_second is not None:
            both = mirroring(first, second, of_second) or mirroring(second, first, 1 - of_second)
            both = both or layered(evaluator, first, second, of_second) or layered(evaluator, second, first, 1 - of_second)
        elif graphs.graph_of(share) is None:
            of_second = float(np.clip(share, 0, 1).mean())
            both = glazed(evaluator, first, second, 1 - of_second, of_second) or glazed(evaluator, second, first, of_second, 1 - of_second)
    return both or joined(evaluator, first, second, share)


def layered(evaluator, below, mirror, of_mirror):
    """What is below a mirror, which is there to such shares at the angles of layers.COSINES: it shines more towards its edges. That is a layer
    on what is matt, and a clear coat on what shines itself, such as the metal of cars. None of anything else."""
    if not (is_mirror(mirror) and is_whole(below) and is_opaque(below) and is_zero(below.coat) and layers.is_of_layer(of_mirror)):
        return None
    shine, share = shine_of(evaluator, mirror), float(of_mirror.mean())
    normal = {} if has_normals(below) else normals_of(mirror)
    if has_no_layer(below):
        return replace(below, **layer_of(share * shine, mirror), **normal)
    if has_normals(below) and not all(is_same(one, other) for one, other in zip(normals_of(below).values(), normals_of(mirror).values())):
        evaluator.say("its coat has the normals of what is below")
    index = layers.index_of_share(share, mirror.roughness.mean())
    coat = {"coat": constant(shine), "coat_roughness": mirror.roughness, "coat_ior": constant(index), "coat_tint": constant(1.0, 1.0, 1.0)}
    return replace(below, **coat, **normal)


def mirroring(below, mirror, of_mirror):
    """Glass below a mirror, which is there to such shares at the angles of layers.COSINES: glass, which reflects by its index of refraction, in
    the mirror's colour. None of anything else, and of what is a mirror for the most part."""
    is_glass = float(below.transmission.min()) > 0.99 and graphs.graph_of(below.transmission) is None
    if not (is_glass and is_whole(below) and is_mirror(mirror) and float(of_mirror.mean()) <= 0.5):
        return None
    return replace(below, shine=np.clip(mirror.base, 0, 1))


def layer_of(share, mirror):
    """Parameters of a layer as rough as a mirror that reflects this share of the light from all around."""
    return {"specular": constant(1.0), "ior": constant(layers.index_of_share(share, mirror.roughness.mean())), "roughness": mirror.roughness}


def shine_of(evaluator, mirror):
    """How much a mirror on top of something else reflects, as one number."""
    shine = layers.share_of_metal(mirror.base.mean(axis=(0, 1)), mirror.roughness.mean())
    if graphs.graph_of(mirror.base) is not None or mirror.base.shape[:2] != (1, 1):
        evaluator.say("what varies in its reflection counts by its mean")
    if float(np.ptp(shine)) > 0.05:
        evaluator.say("the colour of its reflection is left out")
    return float(number(constant(*shine)).mean())


EDGES = 1 / 21
"""What a layer reflects from all around that reflects next to nothing head-on (by Schlick's approximation of Fresnel's equations)."""


def glazed(evaluator, matt, mirror, of_matt, of_mirror):
    """What is matt and a mirror in parts, of which there are so much: a surface that scatters one colour and reflects another one. None if
    they are something else, or of one colour, which is a metal in part."""
    if not (is_mirror(mirror) and has_no_layer(matt) and is_whole(matt) and mirror.base.shape[:2] == (1, 1)):
        return None
    shine = mirror.base * of_mirror
    if of_matt <= 0 or shine.max() <= 0 or are_of_one_color(matt, mirror):
        return None
    emission = matt.emission * of_matt
    normal = {} if has_normals(matt) else normals_of(mirror)
    shine_mean = float(layers.share_of_metal(mirror.base, mirror.roughness.mean()).mean()) * of_mirror
    is_grey = graphs.graph_of(shine) is None and float(np.ptp(shine)) <= 0.1 * float(shine.max())
    if is_grey and EDGES < shine_mean < 0.85:
        # a layer reflects more towards the edges of things: as much from all around
        base = np.clip(matt.base * of_matt / (1 - shine_mean), 0, 1)
        return replace(matt, base=base, emission=emission, **layer_of(shine_mean, mirror), **normal)
    base = matt.base * of_matt + shine
    if graphs.graph_of(shine) is not None:
        part = number(shine) / np.maximum(number(base), 1e-6)
    else:
        part = constant(float(number(shine).mean()) / max(float(number(base).mean()), 1e-6))
    evaluator.say("what it scatters and what it reflects are of one colour")
    return replace(matt, base=np.clip(base, 0, 1), metallic=part, roughness=mirror.roughness, emission=emission, **normal)


def are_of_one_color(one, other):
    """Returns true if two surfaces are nearly of one colour."""
    if any(graphs.graph_of(each.base) is not None for each in (one, other)):
        return is_same(one.base, other.base)
    return np.allclose(one.base, other.base, atol=0.02)


def add(evaluator, node):
    """An Add Shader. What only emits is added; of others the mean is shown."""
    first, second = behind(evaluator, node, 0), behind(evaluator, node, 1)
    for one, rest in ((first, second), (second, first)):
        if is_fuzz(one) and is_zero(rest.fuzz) and not rest.seen.holdout:
            return replace(rest, fuzz=one.fuzz, fuzz_tint=one.fuzz_tint, fuzz_roughness=one.fuzz_roughness)
    if all(has_no_layer(part) and is_whole(part) and is_zero(part.fuzz) for part in (first, second)):
        both = joined(evaluator, first, second, constant(0.5))
        one, other = alike(first.base, second.base)
        return replace(both, base=one + other, emission=both.emission * 2)
    for light, rest in ((first, second), (second, first)):
        if is_zero(light.base) and is_zero(light.specular) and is_zero(light.fuzz) and not (light.seen.holdout or rest.seen.holdout):
            one, other = alike(light.emission, rest.emission)
            rest.emission = one + other
            return rest
    both = glazed(evaluator, first, second, 1, 1) or glazed(evaluator, second, first, 1, 1)
    if both:
        return both
    evaluator.say("of two added shaders the mean is shown")
    return joined(evaluator, first, second, constant(0.5))


def light_of(evaluator, socket):
    """The light of a shader input of a world; None if it is no background, no mix of some and no colour."""
    with evaluator.source(socket) as (node, output):
        if node is None:
            return constant(0.0, 0.0, 0.0)
        if output.type != "SHADER":
            return color(evaluator.output(node, output))
        if node.mute:
            return None
        if node.type in {"BACKGROUND", "EMISSION"}:
            light, strength = alike(color(evaluator.input(node, "Color")), evaluator.input(node, "Strength"))
            return light * strength
        if node.type not in {"MIX_SHADER", "ADD_SHADER"}:
            return None
        parts = [light_of(evaluator, entry) for entry in list(node.inputs)[-2:]]
        if any(part is None for part in parts):
            return None
        if node.type == "ADD_SHADER":
            return np.add(*alike(*parts))
        share, one, other = alike(np.clip(evaluator.input(node, 0), 0, 1), *parts)
        return one * (1 - share) + other * share


BLACK_MELANIN, RED_MELANIN = np.array([0.506, 0.841, 1.653]), np.array([0.343, 0.733, 1.924])
"""Absorption of either kind of melanin, of a concentration of 1 (d'Eon and others, 2011), as Cycles has it."""


def principled_hair(evaluator, node):
    """A Principled Hair BSDF. The model of Chiang and others stands for that of Huang as well."""
    mean = lambda name, otherwise=0.0: float(evaluator.input(node, name).mean()) if node.inputs.get(name) else otherwise
    roughness, radial = (float(np.clip(mean(name, 0.3), 0, 1)) for name in ("Roughness", "Radial Roughness"))
    if getattr(node, "model", "CHIANG") != "CHIANG":
        evaluator.say("its hair is shown by the model of Chiang in place of that of Huang")
        radial = roughness
    for name in ("Random Color", "Random Roughness"):
        if node.inputs.get(name) and mean(name) > 1e-3:
            evaluator.say(f"its {name.lower()} is left out: all hairs have their mean")
    factor = of_radial(radial)
    if node.parametrization == "COLOR":
        base = np.clip(color(evaluator.input(node, "Color")), 0, 1)
    elif node.parametrization == "MELANIN":
        melanin, redness = (float(np.clip(mean(name), 0, 1)) for name in ("Melanin", "Melanin Redness"))
        amount = -np.log(max(1 - melanin, 1e-4))
        tint = np.clip(color(evaluator.input(node, "Tint")).mean(axis=(0, 1)), 1e-5, 1)
        absorbed = amount * ((1 - redness) * BLACK_MELANIN + redness * RED_MELANIN) + (np.log(tint) / factor) ** 2
        base = constant(*np.exp(-np.sqrt(absorbed) * factor))
    else:
        absorbed = np.clip(color(evaluator.input(node, "Absorption Coefficient")).mean(axis=(0, 1)), 0, None)
        base = constant(*np.exp(-np.sqrt(absorbed) * factor))
    hair = (roughness, radial, float(np.clip(mean("Coat"), 0, 1)), float(np.clip(mean("IOR", 1.55), 1.01, 4)), np.degrees(mean("Offset")))
    return Surface(base=base, metallic=constant(1.0), hair=hair)


def of_radial(roughness):
    """Factor of the logarithm of the colour that hair has in the end, from the root of its absorption (Chiang and others, equation 9)."""
    return np.polyval([0.245, 5.574, -10.73, 2.532, -0.215, 5.969], roughness)


def hair_lobe(evaluator, node):
    """A Hair BSDF: one lobe of a fibre, for which a whole fibre stands."""
    evaluator.say("its Hair BSDF is shown as a Principled Hair BSDF of its colour")
    along, around = (float(np.clip(evaluator.input(node, name).mean(), 0, 1)) for name in ("RoughnessU", "RoughnessV"))
    offset = np.degrees(float(evaluator.input(node, "Offset").mean()))
    return Surface(base=np.clip(color(evaluator.input(node, "Color")), 0, 1), metallic=constant(1.0), hair=(along, around, 0.0, 1.55, offset))


SHADERS = {
    "BSDF_HAIR_PRINCIPLED": principled_hair,
    "BSDF_HAIR": hair_lobe,
    "BSDF_PRINCIPLED": principled,
    "BSDF_DIFFUSE": diffuse,
    "BSDF_TRANSLUCENT": translucent,
    "SUBSURFACE_SCATTERING": subsurface,
    "BSDF_SHEEN": sheen,
    "BSDF_VELVET": sheen,
    "BSDF_TOON": as_diffuse,
    "BSDF_GLOSSY": glossy,
    "BSDF_ANISOTROPIC": glossy,
    "BSDF_METALLIC": metallic,
    "BSDF_GLASS": glass,
    "BSDF_REFRACTION": glass,
    "BSDF_TRANSPARENT": transparent,
    "EMISSION": emission,
    "HOLDOUT": holdout,
    "MIX_SHADER": mix,
    "ADD_SHADER": add,
}
