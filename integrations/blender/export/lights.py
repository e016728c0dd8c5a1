# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: Blender's watts to the renderer's units.

A matt white surface that faces a directional light of power 1 has a radiance of 1 there, and of 1 / pi here: so all units differ by
pi. Point and spot lights of W watts have an intensity of W / (4 pi), areas of W / pi along their axis.
"""

import math

import numpy as np

from .camera import TO_Y_UP
from .light_links import keys_of

SHADOW_RAYS = (1, 4, 16)
LEAST_SPREAD, WIDEST_SPREAD = math.radians(1), math.radians(179.9)  # of area lights


def light_of(instance, data, settings, warnings):
    """The values of a [[light]]: those that stay, and those of a key. None where it gives no light."""
    if getattr(getattr(data, "cycles", None), "is_portal", False):
        return None  # it only tells Cycles where the world shines in
    matrix = np.array(instance.matrix_world)
    name = instance.object.name
    if not np.isfinite(matrix).all():
        warnings.add(f"light `{name}` is left out: its place is not a finite number")
        return None
    if not math.isfinite(data.energy):
        warnings.add(f"light `{name}` is left out: its power is not a finite number")
        return None
    matrix = TO_Y_UP @ matrix
    place = matrix[:3, 3]
    axes = matrix[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    if lengths[2] == 0 or (data.type == "AREA" and lengths.min() == 0):
        return None
    ahead = -axes[:, 2] / lengths[2]
    color, strength = color_of(data, warnings)
    kind = {"POINT": point, "SUN": sun, "SPOT": spot, "AREA": area}[data.type]
    said = []
    fixed, power, factor = kind(data, lengths, settings.shadow_rays, said.append)
    warnings.add_for(subject_of(instance.object), said)
    key = {"color": [float(part) for part in color], "power": max(0.0, strength * factor * power * settings.exposure)}
    if data.type == "SUN":
        key["direction"] = ahead.tolist()
    else:
        key["position"] = place.tolist()
        if data.type != "POINT":
            key["target"] = (place + ahead).tolist()
        if data.type == "AREA":
            key["up"] = (axes[:, 1] / lengths[1]).tolist()
    key.update({name: fixed.pop(name) for name in SIZES if name in fixed})
    return {"name": name, **fixed}, key


SIZES = ("radius", "size", "spread", "cone", "soft", "angle")
"""Keys of lights that may change, beside their places, colours and powers."""
LEAST_RADIUS = 1e-6
"""Of a sphere at times at which Blender has a point."""


def has_size(fixed):
    """Returns true if a light is more than a point, so that what it is at other times, too, has samples."""
    return "samples" in fixed


def subject_of(item):
    """What messages call a light."""
    return f"{item.data.type.lower()} light `{item.name}`"


def color_of(data, warnings):
    """Linear colour, and its factor: colour, temperature, exposure, and the emission of a light's nodes."""
    color = np.array(data.color, dtype=float)
    if getattr(data, "use_temperature", False):
        color = color * np.array(data.temperature_color)
    strength = 2.0 ** getattr(data, "exposure", 0.0)
    if data.use_nodes and data.node_tree:
        outputs = [node for node in data.node_tree.nodes if node.type == "OUTPUT_LIGHT" and node.is_active_output]
        links = outputs[0].inputs["Surface"].links if outputs else ()
        node = links[0].from_node if links else None
        if node and node.type == "EMISSION":
            if node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked:
                warnings.add(f"light `{data.name}`: textures and falloffs of its nodes are left out")
            if not node.inputs["Color"].is_linked:
                color = color * np.array(node.inputs["Color"].default_value)[:3]
            if not node.inputs["Strength"].is_linked:
                strength *= node.inputs["Strength"].default_value
    # the renderer takes no negative light
    return np.clip(color, 0, None), strength


def point(data, _lengths, rays, _say):
    """A point, or a sphere where it has a radius."""
    radius = data.shadow_soft_size
    fixed = {"type": "sphere", "radius": radius, "samples": rays} if radius > 0 else {"type": "point"}
    if radius > 0 and getattr(data, "use_soft_falloff", True):
        # Cycles has a disc that faces what is lit
        fixed["faces"] = True
    return fixed, data.energy, 1 / (4 * math.pi**2)


def sun(data, _lengths, rays, _say):
    """A directional light, with an angle where it has one."""
    angle = math.degrees(data.angle)
    fixed = {"type": "directional"}
    if angle > 0:
        # half of the sky and more is refused
        fixed.update(angle=min(angle, 179.9), samples=rays)
    return fixed, data.energy, 1 / math.pi


def spot(data, _lengths, rays, say):
    """A spot, with a radius where it has one. Its softness begins at the same angle as Blender's, which counts by cosines."""
    half = data.spot_size / 2
    if half >= math.radians(89.9):
        say("its cone is wider than 179.8 degrees, and is made so wide")
        half = math.radians(89.9)
    inner = math.acos(min(1.0, math.cos(half) + (1 - math.cos(half)) * data.spot_blend))
    # without blend the arc of the cosine may come out beyond the rim by a rounding
    fixed = {"type": "spot", "cone": math.degrees(2 * half), "soft": max(0.0, 1 - inner / half)}
    if data.shadow_soft_size > 0:
        fixed.update(radius=data.shadow_soft_size, samples=rays)
    return fixed, data.energy, 1 / (4 * math.pi**2)


def area(data, lengths, rays, say):
    """A rectangle or a disk, with the spread where it has one."""
    across = data.size * lengths[0]
    up = (data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size) * lengths[1]
    kind = "disk" if data.shape in {"DISK", "ELLIPSE"} else "rectangle"
    fixed = {"type": kind, "size": [max(1e-6, across), max(1e-6, up)], "samples": rays}
    if data.spread >= WIDEST_SPREAD:
        return fixed, data.energy, 1 / math.pi**2
    spread = max(data.spread, LEAST_SPREAD)
    if data.spread < LEAST_SPREAD:
        say(f"its spread is below a degree, and is made {math.degrees(spread):.0f}")
    return {**fixed, "spread": math.degrees(spread)}, data.energy, spread_gain(spread) / math.pi**2


def spread_gain(spread):
    """How much brighter along its axis an area light of some spread is than one of 180 degrees, as Cycles keeps its watts.

    Both renderers dim directions by 1 - tan(x) / tan(h), where h is half of the spread: of the integral of the cosine over the half space,
    pi, that leaves pi (tan(h) - h) / tan(h).
    """
    half = spread / 2
    return math.tan(half) / (math.tan(half) - half)


def tables(tracks, groups):
    """[[light]] and its keys. `tracks`: pairs of what stays, and a dictionary from times to values (None: not there). `groups`: names of the
    groups of models by which lights are linked."""
    from . import toml

    out, named = [], set()
    for fixed, keys in tracks:
        links = keys_of(fixed.get("links", ()), groups)
        if links is None:
            continue
        fixed = {**{key: value for key, value in fixed.items() if key != "links"}, **links}
        # instances of one light have one name, and those of a group must have several
        name, count = fixed["name"], 1
        while "group" in fixed and fixed["name"] in named:
            count += 1
            fixed["name"] = f"{name} {count}"
        named.add(fixed["name"])
        there = [values for values in keys.values() if values]
        if not there:
            continue
        if fixed["type"] == "sphere":
            for values in there:
                values.setdefault("radius", LEAST_RADIUS)
        first = there[0]
        # a light that is not there has no power
        values = {time: values or {**first, "power": 0.0} for time, values in keys.items()}
        moves = any(other != first for other in values.values())
        out.append(toml.table("[[light]]", {**fixed, **(first if not moves else {})}))
        if moves:
            out += [toml.table("[[light.key]]", {"frame": time, **value}) for time, value in values.items()]
    return out
