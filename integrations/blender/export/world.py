# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour, a picture all around, or a sky."""

import math

import numpy as np

from . import sky_bake, toml
from .nodes import Evaluator, constant


def tables(world, images, visible, exposure, warnings, goes_on=lambda: True):
    """[background] and [environment] of a scene's world, which is brighter by the factor `exposure`."""
    if world is None:
        return []
    evaluator = Evaluator(images)
    light = constant(*world.color) if not world.use_nodes or not world.node_tree else None
    try:
        out = [uniform(light * exposure)] if light is not None else of_tree(world, evaluator, images, visible, exposure, goes_on)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        evaluator.say(f"cannot be read ({type(error).__name__}: {error}), and is black")
        out = []
    warnings.add_for(f"world `{world.name}`", evaluator.said)
    return out


def uniform(light):
    """A world of one colour; nothing where it is black."""
    return background(light) + "[environment]\n" if float(light.max()) > 0 else ""


def background(light):
    """What the camera sees where there is nothing else."""
    return toml.table("[background]", {"color": np.clip(light.reshape(-1)[:3], 0, 60000).tolist()})


def unlike(light, seen, images):
    """A world of one colour, and another one that the camera sees."""
    name = images.write_light("world", np.broadcast_to(light.reshape(-1)[:3], (2, 4, 3)))
    return background(seen) + toml.table("[environment]", {"map": name, "visible": False})


def of_tree(world, evaluator, images, visible, exposure, goes_on):
    """The tables of a world's node tree."""
    outputs = [node for node in world.node_tree.nodes if node.type == "OUTPUT_WORLD"]
    outputs.sort(key=lambda node: not node.is_active_output)
    if not outputs:
        return []
    if outputs[0].inputs["Volume"].is_linked:
        evaluator.say("its volume is left out")
    surface, seen = outputs[0].inputs["Surface"], None
    with evaluator.source(surface) as (node, _):
        if node and node.type == "MIX_SHADER":
            with evaluator.source(node.inputs[0]) as (factor, output):
                is_of_camera = factor and factor.type == "LIGHT_PATH" and output.name == "Is Camera Ray"
            surface = node.inputs[1]
            if is_of_camera:
                # the common set-up: what the camera sees differs from what lights
                seen = even_light(evaluator, node.inputs[2], exposure)
                if seen is None:
                    evaluator.say("what the camera sees of it is no plain colour: it sees what lights")
            else:
                evaluator.say("of its mixed backgrounds the first one is shown")
                surface = surface if surface.is_linked else node.inputs[2]
        return of_shader(evaluator, surface, seen, images, visible, exposure, goes_on)


def of_shader(evaluator, socket, seen, images, visible, exposure, goes_on):
    """The tables of what is linked to a shader input. `seen`: the colour that the camera sees instead, or None."""
    light = even_light(evaluator, socket, exposure)
    if light is not None:
        return [uniform(light) if seen is None else unlike(light, seen, images)]
    with evaluator.source(socket) as (node, _):
        if node.type not in KINDS:
            evaluator.say(f"its shader ({node.bl_label}) is left out")
            return []
        strength = float(evaluator.input(node, "Strength").mean()) * exposure
        visible = visible and seen is None
        with evaluator.source(node.inputs["Color"]) as (source, _):
            if source.type == "TEX_ENVIRONMENT":
                out = [environment_map(source, strength, evaluator, images, visible)]
            else:
                out = sky(source, strength, evaluator, images, visible, goes_on)
    return out if seen is None else [background(seen), *out]


KINDS = {"BACKGROUND", "EMISSION"}


def even_light(evaluator, socket, exposure):
    """The colour of a shader input that is the same all around, black without a shader; None where it has a picture, or is another shader."""
    with evaluator.source(socket) as (node, _):
        if node is None:
            return constant(0.0, 0.0, 0.0)
        if node.type not in KINDS:
            return None
        with evaluator.source(node.inputs["Color"]) as (source, _):
            if source and source.type in {"TEX_ENVIRONMENT", "TEX_SKY"}:
                return None
        light = evaluator.input(node, "Color")
        if light.shape[:2] != (1, 1):
            evaluator.say("its picture is not an environment texture: its mean is shown")
        return light.mean(axis=(0, 1)) * float(evaluator.input(node, "Strength").mean()) * exposure


def environment_map(node, strength, evaluator, images, visible):
    """An equirectangular picture, with the rotation of a Mapping node about Z."""
    if node.image is None:
        evaluator.say("its environment texture has no image")
        return uniform(constant(1.0, 0.0, 1.0) * strength)
    if node.projection != "EQUIRECTANGULAR":
        evaluator.say("its mirror ball is shown as an equirectangular map")
    turn = 0.0
    with evaluator.source(node.inputs["Vector"]) as (mapping, _):
        if mapping and mapping.type == "MAPPING":
            angles = evaluator.input(mapping, "Rotation").mean(axis=(0, 1))
            turn = math.degrees(float(angles[2])) * (-1 if mapping.vector_type == "TEXTURE" else 1)
            if max(abs(float(angles[0])), abs(float(angles[1]))) > 1e-4:
                evaluator.say("its map is turned about Z alone")
            scale = evaluator.input(mapping, "Scale").mean(axis=(0, 1)) if mapping.inputs.get("Scale") else np.ones(3)
            if not np.allclose(scale, 1, atol=1e-4):
                evaluator.say("the scale of its mapping is left out")
    pixels = images.pixels(node.image)
    if pixels is None:
        return uniform(constant(1.0, 0.0, 1.0) * strength)
    path = images.path_of(node.image)
    plain = path.lower().endswith(".hdr") and node.image.source == "FILE" and not node.image.packed_file and not node.image.is_dirty
    name = images.copy(node.image) if plain else images.write_light(node.image.name, pixels)
    return toml.table("[environment]", {"map": name, "rotation": -90.0 - turn, "power": max(0.0, strength), "visible": visible})


def sky(node, strength, evaluator, images, visible, goes_on):
    """A sky texture: a picture of it that Cycles makes, and its sun as a light."""
    pixels, sun = sky_bake.bake(node, goes_on)
    name = images.write_light("sky", pixels)
    out = [toml.table("[environment]", {"map": name, "rotation": -90.0, "power": max(0.0, strength), "visible": visible})]
    top = float(sun.max())
    if top > 0:
        x, y, z = sky_bake.direction_of(sky_bake.properties_of(node))
        evaluator.say("the sun of its sky is a light: the camera does not see its disk")
        light = {"type": "directional", "name": "Sun of the sky", "direction": [float(-x), float(-z), float(y)], "angle": math.degrees(node.sun_size)}
        # a white surface shows the radiance that the renderer calls a power
        out.append(toml.table("[[light]]", {**light, "color": (sun / top).tolist(), "power": top * max(0.0, strength), "samples": 4}))
    return out
