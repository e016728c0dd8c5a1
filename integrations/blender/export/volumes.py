# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of materials and worlds: what shaders say of the light on its way, as the renderer has it."""

from dataclasses import dataclass

import numpy as np

from . import graphs


@dataclass
class Medium:
    """What becomes of light for each unit of length."""

    scatter: np.ndarray
    absorb: np.ndarray
    emit: np.ndarray
    anisotropy: float = 0.0
    """Mean cosine of the angle by which light is turned."""

    def plus(self, other):
        """Both in one place."""
        weights = self.scatter.sum(), other.scatter.sum()
        mean = np.average((self.anisotropy, other.anisotropy), weights=weights) if sum(weights) > 0 else 0.0
        return Medium(self.scatter + other.scatter, self.absorb + other.absorb, self.emit + other.emit, float(mean))

    def times(self, factor):
        """So much of it."""
        return Medium(self.scatter * factor, self.absorb * factor, self.emit * factor, self.anisotropy)

    def keys(self, exposure, prefix=""):
        """Keys of a table. `exposure`: a factor on all light."""
        keys = {"scatter": self.scatter, "absorb": self.absorb, "emit": self.emit * exposure}
        keys = {prefix + name: np.clip(value, 0, MOST).tolist() for name, value in keys.items() if float(value.max()) > 0}
        if self.anisotropy and float(self.scatter.max()) > 0:
            keys[f"{prefix}anisotropy"] = float(np.clip(self.anisotropy, -1, 1))
        return keys


MOST = 1e9
"""The largest coefficient that the renderer takes."""

BLACK = np.zeros(3)


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

    def _mean(self, name):
        value = self.evaluator.input(self.node, name)
        if value.shape[:2] != (1, 1) or graphs.graph_of(value) is not None:
            self.evaluator.say("its volume varies from place to place: its mean counts")
        return value.mean(axis=(0, 1))

    def number(self, name):
        """A number that is not negative."""
        return max(0.0, float(np.nan_to_num(self._mean(name)).mean()))

    def color(self, name):
        """A colour whose channels are not negative."""
        return np.maximum(np.broadcast_to(np.nan_to_num(self._mean(name)), 3), 0)

    def anisotropy(self):
        """Where it scatters light to."""
        phase = getattr(self.node, "phase", "HENYEY_GREENSTEIN")
        if phase != "HENYEY_GREENSTEIN":
            self.evaluator.say("light in its volume is scattered as by Henyey and Greenstein's formula")
            if phase == "RAYLEIGH":
                return 0.0
        return float(np.nan_to_num(self._mean("Anisotropy")).mean())

    def inner(self, number):
        """What another input says."""
        return medium_of(self.evaluator, self.node.inputs[number])


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
    density, color = reader.number("Density"), reader.color("Color")
    kept = np.sqrt(reader.color("Absorption Color"))
    emitted = reader.color("Emission Color") * reader.number("Emission Strength")
    if reader.number("Blackbody Intensity") > 0:
        reader.evaluator.say("the blackbody of its volume is left out")
    return Medium(color * density, np.maximum(1 - color, 0) * np.maximum(1 - kept, 0) * density, emitted, reader.anisotropy())


def added(reader):
    return reader.inner(0).plus(reader.inner(1))


def mixed(reader):
    share = float(np.clip(reader._mean(0).mean(), 0, 1))
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
