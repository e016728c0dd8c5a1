# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of materials and worlds: what shaders say of the light on its way, as the renderer has it."""

from dataclasses import dataclass

import numpy as np

from . import graphs
from .nodes import blackbody as kelvin_color
from .nodes import color, constant, number


@dataclass
class Medium:
    """What becomes of light for each unit of length: colours, arrays of one texel, which may have graphs."""

    scatter: np.ndarray
    absorb: np.ndarray
    emit: np.ndarray
    anisotropy: float = 0.0
    """Mean cosine of the angle by which light is turned."""

    def plus(self, other):
        """Both in one place."""
        weights = float(self.scatter.sum()), float(other.scatter.sum())
        mean = np.average((self.anisotropy, other.anisotropy), weights=weights) if sum(weights) > 0 else 0.0
        return Medium(self.scatter + other.scatter, self.absorb + other.absorb, self.emit + other.emit, float(mean))

    def times(self, factor):
        """So much of it."""
        return Medium(self.scatter * factor, self.absorb * factor, self.emit * factor, self.anisotropy)

    def colors(self):
        """Its coefficients, by the names of keys."""
        return {"scatter": self.scatter, "absorb": self.absorb, "emit": self.emit}

    def varies(self):
        """Returns true if nodes give it from place to place."""
        return any(graphs.graph_of(value) is not None for value in self.colors().values())

    def keys(self, exposure, prefix=""):
        """Keys of a table. `exposure`: a factor on all light."""
        keys = {prefix + name: np.clip(value * (exposure if name == "emit" else 1), 0, MOST)[0, 0].tolist() for name, value in self.colors().items()}
        keys = {name: value for name, value in keys.items() if max(value) > 0}
        if self.anisotropy and float(self.scatter.max()) > 0:
            keys[f"{prefix}anisotropy"] = float(np.clip(self.anisotropy, -1, 1))
        return keys


MOST = 1e9
"""The largest coefficient that the renderer takes."""

BLACK = constant(0.0, 0.0, 0.0)


def nothing():
    """Clear air."""
    return Medium(BLACK, BLACK, BLACK)


def medium_of(evaluator, socket):
    """What a volume input says."""
    with evaluator.source(socket) as (node, _):
        if node is None or node.mute:
            return nothing()
        read = READERS.get(node.type)
        if read is None:
            evaluator.say(f"node `{node.name}` ({node.bl_label}) of its volume is left out")
            return nothing()
        return read(Reader(evaluator, node))


class Reader:
    """A shader of a volume."""

    def __init__(self, evaluator, node):
        self.evaluator, self.node = evaluator, node

    def _value(self, name):
        value = self.evaluator.input(self.node, name)
        if value.shape[:2] != (1, 1):
            self.evaluator.say("pictures of its volume count by their means")
            value = value.mean(axis=(0, 1), keepdims=True)
        return value if graphs.graph_of(value) is not None else np.nan_to_num(value)

    def number(self, name):
        """A number that is not negative."""
        return np.maximum(number(self._value(name)), 0)

    def by_grid(self, value, name, kind):
        """A value times the grid that another input names, of a volume that has such a grid."""
        grid = getattr(self.node.inputs.get(name), "default_value", "")
        if self.evaluator.grids is None or not grid or grid not in self.evaluator.grids_there:
            return value
        node = graphs.of_grid(self.evaluator, grid, kind)
        return value * graphs.computed(constant(*(0.5,) * (3 if kind == "color3" else 1)), node)

    def constant(self, name):
        """A number that is the same everywhere."""
        value = self._value(name)
        if graphs.graph_of(value) is not None:
            self.evaluator.say(f"the {name} of its volume varies from place to place: its mean counts")
        return float(np.asarray(value).mean())

    def color(self, name):
        """A colour whose channels are not negative."""
        return np.maximum(color(self._value(name)), 0)

    def anisotropy(self):
        """Where it scatters light to."""
        phase = getattr(self.node, "phase", "HENYEY_GREENSTEIN")
        if phase != "HENYEY_GREENSTEIN":
            self.evaluator.say("light in its volume is scattered as by Henyey and Greenstein's formula")
            if phase == "RAYLEIGH":
                return 0.0
        return self.constant("Anisotropy")

    def share(self):
        """The factor of a mixture."""
        return number(self._value(0))

    def inner(self, place):
        """What another input says."""
        return medium_of(self.evaluator, self.node.inputs[place])


def absorption(reader):
    return Medium(BLACK, np.maximum(1 - reader.color("Color"), 0) * reader.number("Density"), BLACK)


def scatter(reader):
    return Medium(reader.color("Color") * reader.number("Density"), BLACK, BLACK, reader.anisotropy())


def coefficients(reader):
    return Medium(*(reader.color(f"{name} Coefficients") for name in ("Scatter", "Absorption", "Emission")), reader.anisotropy())


def emission(reader):
    return Medium(BLACK, BLACK, reader.color("Color") * reader.number("Strength"))


def principled(reader):
    """Cycles' svm_node_principled_volume: what is not scattered is absorbed, but for the absorption colour's part."""
    density = reader.by_grid(reader.number("Density"), "Density Attribute", "float")
    tint = reader.by_grid(reader.color("Color"), "Color Attribute", "color3")
    kept = np.sqrt(reader.color("Absorption Color"))
    emitted = reader.color("Emission Color") * reader.number("Emission Strength")
    glow = reader.constant("Blackbody Intensity")
    if glow > 0:
        emitted = emitted + blackbody(reader, min(glow, 1.0))
    return Medium(tint * density, np.maximum(1 - tint, 0) * np.maximum(1 - kept, 0) * density, emitted, reader.anisotropy())


STEFAN = 5.670373e-8 * 1e-6 / np.pi
"""Radiance of a black body by the fourth power of its temperature, in Cycles' units."""


def blackbody(reader, share):
    """What a volume emits by its temperature: Cycles' svm_node_principled_volume."""
    kelvin = np.maximum(reader.by_grid(reader.number("Temperature"), "Temperature Attribute", "float"), 0)
    light = STEFAN * ((1 - share) + share * (kelvin * kelvin * kelvin * kelvin))
    color = constant(*kelvin_color(float(np.asarray(kelvin).mean())))
    graph = graphs.graph_of(kelvin)
    if graph is not None:
        color = graphs.computed(color, graphs.Node("blender_blackbody", "color3", {"temperature": graph}))
    else:
        reader.evaluator.say("the blackbody of its volume is an approximation")
    return np.maximum(color, 0) * reader.color("Blackbody Tint") * light


def added(reader):
    return reader.inner(0).plus(reader.inner(1))


def mixed(reader):
    share = np.clip(reader.share(), 0, 1)
    return reader.inner(1).times(1 - share).plus(reader.inner(2).times(share))


READERS = {
    "VOLUME_ABSORPTION": absorption,
    "VOLUME_SCATTER": scatter,
    "VOLUME_COEFFICIENTS": coefficients,
    "PRINCIPLED_VOLUME": principled,
    "EMISSION": emission,
    "ADD_SHADER": added,
    "MIX_SHADER": mixed,
}
"""Readers by type of node."""
