# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour, a picture all around, a sky, or whatever else its nodes make, as Cycles bakes it."""

import math

import numpy as np

from . import toml, world_bake
from .at_rest import ray_visibility_of, state_of, surroundings_of, trees_of
from .nodes import Evaluator, constant
from .pictures import Pictures
from .surfaces import light_of
from .volumes import medium_of


class World:
    """Reads the world of one time. `exposure` is a factor on all of its light."""

    def __init__(self, images, visible, exposure, time=1.0, goes_on=lambda: True, sun_rays=4):
        self.images, self.visible, self.exposure, self.sun_rays = images, visible, exposure, sun_rays
        self.time, self.goes_on = time, goes_on
        self.evaluator = Evaluator(Pictures(images))
        self.is_seen, self.lights = True, True
        """What its settings of ray visibility say: whether the camera sees it, and whether it lights anything."""

    def tables(self, world, warnings):
        """[background], [environment] and the suns of a scene's world."""
        if world is None:
            return []
        try:
            self._visibility(world)
            if world.use_nodes and world.node_tree:
                out = self._of_tree(world)
            else:
                out = self._uniform(constant(*world.color) * self.exposure, None if self.is_seen else BLACK)
        except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
            self.evaluator.say(f"cannot be read ({type(error).__name__}: {error}), and is black")
            out = []
        warnings.add_for(f"world `{world.name}`", self.evaluator.said)
        return out

    def _visibility(self, world):
        """Reads which rays see the world."""
        of_cycles = ray_visibility_of(world)
        self.is_seen = getattr(of_cycles, "camera", True)
        hidden = [kind for kind in ("diffuse", "glossy", "transmission") if not getattr(of_cycles, kind, True)]
        self.lights = len(hidden) < 3
        if hidden and self.lights:
            self.evaluator.say(f"it is hidden from {' and '.join(hidden)} rays in Blender, and rays of all kinds see it here")

    def _of_tree(self, world):
        outputs = [node for node in world.node_tree.nodes if node.type == "OUTPUT_WORLD" and node.target in {"ALL", "CYCLES"}]
        outputs.sort(key=lambda node: not node.is_active_output)
        if not outputs:
            return []
        if outputs[0].inputs["Volume"].is_linked:
            keys = medium_of(self.evaluator, outputs[0].inputs["Volume"]).keys(self.exposure)
            fog = [toml.table("[fog]", keys)] if keys else []
        else:
            fog = []
        found = self._plain(outputs[0].inputs["Surface"])
        return (self._baked(world) if found is None else found) + fog

    def _exactly(self, read):
        """What `read` returns, if nothing was replaced for it; None otherwise."""
        before = len(self.evaluator.said)
        value = read()
        if len(self.evaluator.said) == before:
            return value
        del self.evaluator.said[before:]
        return None

    def _plain(self, surface):
        """The tables of a world that needs no bake: a colour, a picture or a sky, and for the camera maybe another colour. None for others."""
        evaluator = self.evaluator
        with evaluator.source(surface) as (node, _):
            if node and node.type == "MIX_SHADER" and not node.mute:
                with evaluator.source(node.inputs[0]) as (factor, output):
                    is_of_camera = factor and factor.type == "LIGHT_PATH" and output.name == "Is Camera Ray"
                if is_of_camera:
                    # the common set-up: what the camera sees differs from what lights
                    seen = self._even(node.inputs[2]) if self.is_seen else BLACK
                    return None if seen is None else self._of_shader(node.inputs[1], seen)
        return self._of_shader(surface, None if self.is_seen else BLACK)

    def _even(self, socket):
        """The colour of a shader input that is the same all around; None of others."""
        light = self._exactly(lambda: light_of(self.evaluator, socket))
        return light * self.exposure if light is not None and light.shape[:2] == (1, 1) else None

    def _of_shader(self, socket, seen):
        """The tables of what is linked to a shader input, or None. `seen`: the colour that the camera sees instead, or None."""
        light, evaluator = self._even(socket), self.evaluator
        if light is not None:
            return self._uniform(light, seen)
        with evaluator.source(socket) as (node, _):
            if node.type not in {"BACKGROUND", "EMISSION"} or node.mute:
                return None
            strength = self._exactly(lambda: evaluator.input(node, "Strength"))
            if strength is None or strength.shape[:2] != (1, 1):
                return None
            factor = max(0.0, float(strength.mean()) * self.exposure)
            with evaluator.source(node.inputs["Color"]) as (source, _):
                if source.mute:
                    return None
                if source.type == "TEX_ENVIRONMENT":
                    return self._picture(source, factor, seen)
                if source.type == "TEX_SKY" and not any(entry.is_linked for entry in source.inputs):
                    return self._map("sky", world_bake.of_sky(source, self.goes_on), factor, seen)
        return None

    def _uniform(self, light, seen):
        """A world of one colour, nothing where it is black. `seen`: another colour that the camera sees, or None."""
        if seen is None or np.allclose(seen, light, rtol=1e-3, atol=1e-5):
            return [background(light), *(["[environment]\n"] if self.lights else [])] if float(light.max()) > 0 else []
        if not self.lights or float(light.max()) <= 0:
            return [background(seen)]
        name = self.images.write_light("world", np.broadcast_to(light.reshape(-1)[:3], (2, 4, 3)))
        return [background(seen), toml.table("[environment]", {"map": name, "visible": False})]

    def _environment(self, name, strength, seen, rotation=-90.0):
        """A picture all around. `seen`: a colour that the camera sees instead, or None."""
        if not self.lights:
            self.evaluator.say("it lights nothing in Blender: here a picture is not seen without")
        keys = {"map": name, "rotation": rotation, "power": strength, "visible": self.visible and seen is None}
        return [*([] if seen is None else [background(seen)]), toml.table("[environment]", keys)]

    def _picture(self, node, strength, seen):
        """An equirectangular picture, which may be turned about Z. None if there is more to it."""
        missing = constant(1.0, 0.0, 1.0) * strength
        if node.image is None:
            self.evaluator.say("its environment texture has no image")
            return self._uniform(missing, seen)
        turn = self._exactly(lambda: turn_of(self.evaluator, node.inputs["Vector"]))
        if turn is None or node.projection != "EQUIRECTANGULAR" or node.image.source == "TILED":
            return None
        picture = self.evaluator.pictures.of(node)
        pixels = self.images.pixels(picture)
        if pixels is None:
            return self._uniform(missing, seen)
        is_plain = picture.path.lower().endswith(".hdr") and self.images.is_file(picture)
        name = self.images.copy(picture) if is_plain else self.images.write_light(node.image.name, pixels)
        return self._environment(name, strength, seen, -90.0 - turn)

    def _map(self, name, baked, strength, seen):
        """A picture that Cycles has made, and its suns as lights."""
        out = self._environment(self.images.write_light(name, baked.light), strength, seen)
        for sun in baked.suns:
            top = float(sun.light.max())
            if top > 0:
                self.evaluator.say("the sun of its sky is a light: the camera does not see its disk")
                x, y, z = sun.toward.tolist()
                light = {"type": "directional", "name": "Sun of the sky", "direction": [-x, -z, y], "angle": math.degrees(sun.angle)}
                # a white surface shows the radiance that the renderer calls a power
                out.append(toml.table("[[light]]", {**light, "color": (sun.light / top).tolist(), "power": top * strength, "samples": self.sun_rays}))
        return out

    def _baked(self, world):
        """A world that Cycles has to bake."""
        self._tell_what_bakes_lack(world)
        baked = world_bake.of_world(world, repr([state_of(world), surroundings_of(world, self.time)]), self.time, self.goes_on)
        light, seen = even(baked.light), None if baked.seen is None else even(baked.seen)
        seen = seen if self.is_seen else BLACK
        if light is not None and baked.suns == [] and (baked.seen is None or seen is not None):
            return self._uniform(light * self.exposure, seen if seen is None else seen * self.exposure)
        if seen is not None:
            return self._map(world.name, baked, self.exposure, seen * self.exposure)
        if baked.seen is not None and not np.allclose(baked.seen, baked.light, rtol=1e-2, atol=1e-4):
            self.evaluator.say("what the camera sees of it is no plain colour: it sees what lights")
        return self._map(world.name, baked, self.exposure, None)

    def _tell_what_bakes_lack(self, world):
        """Tells what differs where Cycles bakes a world by itself."""
        for tree in trees_of(world):
            for node in tree.nodes:
                if getattr(node, "image", None) and node.image.is_dirty:
                    self.evaluator.say(f"image `{node.image.name}` is shown as it was saved last: save or pack it")
                if node.type == "TEX_COORD" and any(node.outputs[name].is_linked for name in ("Camera", "Window")):
                    self.evaluator.say("coordinates of the camera are those of one that looks along X")


BLACK = constant(0.0, 0.0, 0.0)


def background(light):
    """What the camera sees where there is nothing else."""
    return toml.table("[background]", {"color": np.clip(light.reshape(-1)[:3], 0, 60000).tolist()})


def even(pixels):
    """The colour of a picture that is one colour all over; None of others."""
    low, high = pixels.min(axis=(0, 1)), pixels.max(axis=(0, 1))
    return constant(*pixels.mean(axis=(0, 1))) if (high - low).max() <= 1e-4 * max(float(high.max()), 1e-6) else None


def turn_of(evaluator, socket):
    """By how many degrees about Z a vector input turns the directions of a world. None if it does anything else."""
    with evaluator.source(socket) as (node, output):
        if node is None:
            return 0.0
        if node.type == "TEX_COORD":
            return 0.0 if output.name == "Generated" else None
        if node.type != "MAPPING" or node.mute or evaluator.link(node.inputs["Vector"]) is None or turn_of(evaluator, node.inputs["Vector"]) != 0:
            return None
        values = {name: evaluator.input(node, name) for name in ("Location", "Rotation", "Scale") if node.inputs.get(name)}
        if any(value.shape[:2] != (1, 1) for value in values.values()):
            return None
        place, angles, scale = (values.get(name, constant(*rest))[0, 0] for name, rest in (("Location", [0] * 3), ("Rotation", [0] * 3), ("Scale", [1] * 3)))
        is_moved = node.vector_type in {"POINT", "TEXTURE"} and np.abs(place).max() > 1e-4
        if is_moved or max(abs(float(angles[0])), abs(float(angles[1]))) > 1e-4 or not np.allclose(scale, 1, atol=1e-4):
            return None
        return math.degrees(float(angles[2])) * (-1 if node.vector_type == "TEXTURE" else 1)
