# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass: where a surface is some, and of which colours the light is that goes through it and that the rest of it scatters.

The renderer keeps one colour of a place. Where a picture or a graph gives that of what goes through glass, what is matt has it as well:
`kd` is a factor of it.
"""

from dataclasses import dataclass

import numpy as np

from . import graphs
from .nodes import alike, constant
from .surfaces import is_zero

LEAST = 1e-3
"""Share of a surface below which it has no glass; of pictures the largest one counts, of which a hundredth is noise."""

LEAST_OF_PICTURES = 0.01

EVEN = 1 / 512
"""Difference of texels below which a picture is one constant."""

LEAST_FACTOR = 1e-3
"""Least factor of a colour that varies: by one of 0 the renderer would not know what it is a factor of."""

LEAST_TOLD = 0.01
"""Share of light that is told where it goes another way."""


@dataclass
class Glass:
    """The glass of a surface, as values of nodes.py."""

    share: np.ndarray
    """Share of the surface that is glass."""
    tint: np.ndarray
    """Colour of the light that goes through it."""
    base: np.ndarray
    """Colour of what is matt of it; where the tint varies, a factor of that."""
    absorption: np.ndarray
    """See Surface."""

    @property
    def is_of_graphs(self):
        """True if it is for the file of graphs to say how much of it there is, and of which colour. Beside a picture of its share `tf` would be a
        part of that share."""
        is_dark = varies(self.share) and not varies(self.tint) and float(self.tint.max()) < 0.999
        return is_dark or any(graphs.graph_of(value) is not None for value in (self.share, self.tint, self.base))

    def reflected(self, surface):
        """Colours of the light that a surface of this glass reflects: in part, by Fresnel's formula, and totally."""
        shine = np.clip(surface.shine.mean(axis=(0, 1)), 0, 1)
        if varies(self.share) or self.is_of_graphs:
            # the renderer takes the share of each place
            return shine, shine
        share = float(self.share.mean())
        # what is matt of it reflects as far as it has a layer; that of glass is whole
        layers = min(float(np.clip(surface.specular, 0, None).mean()), 1.0) if share < 1 else 1.0
        return shine * max(layers, share), shine * share


def varies(value):
    """Returns true if a value is not the same all over: a picture or a graph gives it."""
    return value.shape[:2] != (1, 1) or graphs.graph_of(value) is not None


def mean_of(value):
    """The mean of a value, as one."""
    return np.asarray(value).mean(axis=(0, 1), keepdims=True)


def evened(value):
    """A value that is a constant where it is the same all over. What varies stays the same array, so that its file can be copied."""
    is_even = graphs.graph_of(value) is None and float(np.ptp(value, axis=(0, 1)).max()) <= EVEN
    return mean_of(value) if is_even else value


def mixed(share, first, second):
    """Two colours by the share of the second."""
    share, first, second = alike(share, first, second)
    if any(graphs.graph_of(value) is not None for value in (share, first, second)):
        return graphs.lerp(share, first, second)
    return first * (1 - share) + second * share


def glass_of(surface, evaluator):
    """The glass of a surface; None where it is shown as opaque. What differs from Blender is told."""
    share = evened(np.clip(surface.transmission, 0, 1))
    is_computed, mean = graphs.graph_of(share) is not None, float(share.mean())
    if not is_computed and float(share.max()) < (LEAST_OF_PICTURES if varies(share) else LEAST):
        return None
    if is_veil_of_metal(surface, share):
        to_veil_of_metal(surface, share, evaluator)
        return None
    rest = 1 - np.asarray(share)
    beside = {"metal": surface.metallic, "subsurface scattering": np.multiply(*alike(np.asarray(surface.subsurface), rest))}
    most, name = max((float(np.clip(value, 0, 1).mean()), name) for name, value in beside.items())
    if most > mean and not is_computed:
        evaluator.say(f"its transmission is left out beside its {name}, of which there is more")
        return None
    tint, base, absorption = evened(surface.tint), evened(surface.base), surface.absorption.mean(axis=(0, 1))
    if varies(tint) and absorption.max() > 0:
        evaluator.say("the colour of what goes through it counts by its mean beside what its volume absorbs")
        tint = mean_of(tint)
    if not varies(share) and mean > 1 - LEAST:
        share, base = constant(1.0), constant(0.0, 0.0, 0.0)
    elif not varies(share):
        tint, base = of_even_share(mean, tint, base, evaluator)
    elif varies(tint) or evaluator.attributes_vary:
        tint, base = of_both(share, tint, base, evaluator)
    glass = Glass(share, tint, base, absorption)
    if glass.is_of_graphs and absorption.max() > 0 and float(tint.min()) < 0.999:
        # the file has one colour for both
        evaluator.say("what its volume absorbs is left out beside its colour")
        glass.absorption = np.zeros(3)
    tell(surface, glass, evaluator)
    return glass


def is_veil_of_metal(surface, share):
    """Returns true if a surface is glass and metal in shares that are the same all over, with at least as much metal: it is metal through which something
    is seen, and not glass in which something shines."""
    metal = evened(np.clip(surface.metallic, 0, 1))
    is_even = not varies(share) and not varies(metal) and surface.alpha.shape[:2] == (1, 1)
    return is_even and float(metal.mean()) > float(share.mean()) - LEAST


def to_veil_of_metal(surface, share, evaluator):
    """Makes what is glass of it a veil: the renderer has no metal of glass, but metal that is there in part."""
    evaluator.say("its glass does not bend light, beside its metal")
    solid = max(1 - float(share.mean()), LEAST)
    surface.metallic = constant(min(float(surface.metallic.mean()) / solid, 1.0))
    surface.alpha, surface.veil = surface.alpha * solid, np.clip(mean_of(surface.tint), 0, 1)
    surface.transmission = constant(0.0)


def of_even_share(share, tint, base, evaluator):
    """Colours of a surface of which the same share is glass all over: of two that vary that of the larger part is kept."""
    if not varies(tint):
        return tint, base
    if share <= 0.5:
        evaluator.say("the colour of what goes through it counts by its mean")
        return mean_of(tint), base
    evaluator.say("what is matt of it has the pattern of what goes through")
    return tint, np.clip(mean_of(base) / np.maximum(mean_of(tint), 1e-6), LEAST_FACTOR, 1)


def of_both(share, tint, base, evaluator):
    """Colours of a surface that is glass here and matt there, each by its own: that of what goes through where it is glass, and that of what is matt
    everywhere else."""
    both = mixed(share, base, np.clip(tint, 0, 1))
    by, one, other = alike(*(np.asarray(value) for value in (share, base, tint)))
    if graphs.graph_of(both) is not None or float((by * (1 - by) * np.abs(one - other)).mean()) > LEAST_TOLD:
        evaluator.say("where it is glass in part, what goes through it and what is matt are of one colour")
    return both, constant(1.0, 1.0, 1.0)


def tell(surface, glass, evaluator):
    """Tells what glass of the renderer has another way, or not at all."""
    matt = 1 - np.asarray(glass.share)
    if float(np.clip(surface.metallic, 0, 1).mean()) > LEAST_TOLD or graphs.graph_of(surface.metallic) is not None:
        evaluator.say("what is metal beside its glass is matt")
    specular, of_matt = alike(np.asarray(surface.specular), matt)
    if (varies(glass.share) or glass.is_of_graphs) and float((of_matt * np.abs(1 - specular)).mean()) > LEAST_TOLD:
        evaluator.say("what is matt of it reflects as its glass does")
    if varies(glass.share) and (varies(glass.tint) or float(glass.tint.max()) >= 0.5):
        evaluator.say("without Caustics all of it casts a shadow, or nothing where half of it and more is glass")
    if varies(evened(surface.shine)):
        evaluator.say("the colour that it reflects counts by its mean")
    parts = {"coat": surface.coat, "sheen": surface.fuzz, "subsurface scattering": surface.subsurface, "translucency": surface.translucency}
    is_matt = varies(glass.share) or float(matt.max()) > LEAST
    left_out = [name for name, weight in parts.items() if not is_zero(weight) and (is_matt or name in {"coat", "sheen"})]
    if left_out:
        evaluator.say(f"its {' and its '.join(left_out)} {'are' if len(left_out) > 1 else 'is'} left out: the renderer has none of glass")
