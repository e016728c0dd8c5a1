# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers: how much light they reflect, head-on, towards their edges, and from all around, by their index of refraction and roughness.

Rough ones as Walter et al. have them, "Microfacet Models for Refraction through Rough Surfaces", 2007 (GGX).
"""

import math
from functools import lru_cache

import numpy as np

COSINES = np.sqrt((np.arange(32) + 0.5) / 32)
"""Cosines of angles that have the same share each of the light from all around: their mean is that of all directions."""

GREATEST_INDEX = 50.0
"""An index of refraction that reflects nine tenths from all around."""

UNLIKE = 0.07
"""Difference from the nearest layer, head-on or on the average of all directions, from which on shares are none of a layer."""


def reflected(index, cosine):
    """Share of the light that a surface of some index of refraction reflects at this cosine, or these."""
    cosine = np.asarray(cosine, dtype=float)
    squared = index * index - 1 + cosine * cosine
    root = np.sqrt(np.maximum(squared, 0))
    one = (root - cosine) / (root + cosine)
    other = (cosine * (root + cosine) - 1) / (cosine * (root - cosine) + 1)
    return np.where(squared < 0, 1.0, 0.5 * one * one * (1 + other * other))


@lru_cache(maxsize=64)
def facets(hundredths):
    """Facets of a surface whose roughness is so many hundredths: cosines at which they are met by light from all around, and how much of
    what each reflects leaves the surface at once.

    They are drawn on a grid, by how much of each is seen (Heitz, "Sampling the GGX Distribution of Visible Normals", 2018).
    """
    alpha = max((hundredths / 100) ** 2, 1e-4)
    view = COSINES[:, None, None]
    aside = np.sqrt(1 - view * view)
    length = np.hypot(alpha * aside, view)
    x, z = alpha * aside / length, view / length
    radius = np.sqrt((np.arange(12) + 0.5) / 12)[:, None]
    angle = 2 * np.pi * (np.arange(16) + 0.5) / 16
    across, up = radius * np.cos(angle), radius * np.sin(angle)
    up = (1 - z) / 2 * np.sqrt(np.maximum(1 - across * across, 0)) + (1 + z) / 2 * up
    out = np.sqrt(np.maximum(1 - across * across - up * up, 0))
    facet = np.stack([alpha * (out * x - up * z), np.broadcast_to(alpha * across, up.shape), np.maximum(out * z + up * x, 0)])
    facet /= np.linalg.norm(facet, axis=0)
    met = np.clip(aside * facet[0] + view * facet[2], 1e-4, 1)
    leaves = 2 * met * facet[2] - view

    def hidden(cosine):
        return (np.sqrt(1 + alpha * alpha * (1 / (cosine * cosine) - 1)) - 1) / 2

    seen = (1 + hidden(view)) / (1 + hidden(view) + hidden(np.maximum(leaves, 1e-6)))
    return met, np.where(leaves > 0, seen, 0.0)


def hundredths_of(roughness):
    """A roughness to which the facets of all that are nearly as rough belong."""
    return round(100 * min(max(0.0, float(roughness)), 1.0))


def at_once(roughness):
    """Share of the light from all around that leaves a white mirror of some roughness after one reflection. The rest meets it again."""
    return float(facets(hundredths_of(roughness))[1].mean())


def share_of_metal(base, roughness):
    """Share of the light from all around that metal of a colour reflects in all."""
    once = at_once(roughness)
    return base * once / (1 - base * (1 - once))


def metal_of_share(share, roughness):
    """Colour of metal that reflects this share of the light from all around."""
    once = at_once(roughness)
    return share / (once + share * (1 - once))


def share_of_layer(index, roughness):
    """Share of the light from all around that a layer reflects."""
    met, seen = facets(hundredths_of(roughness))
    first, mean, once = float((reflected(index, met) * seen).mean()), float(reflected(index, COSINES).mean()), float(seen.mean())
    return first + mean * (1 - once) * share_of_metal(mean, roughness)


def index_of_share(share, roughness):
    """The index of refraction, 1 or more, of a layer of some roughness that reflects this share of the light from all around."""
    low, high = 1.0, GREATEST_INDEX
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (middle, high) if share_of_layer(middle, roughness) < share else (low, middle)
    return (low + high) / 2


def is_of_layer(shares):
    """Returns true if a smooth layer reflects nearly these shares at COSINES."""
    apart = np.abs(shares - reflected(index_of_share(float(shares.mean()), 0), COSINES))
    return max(apart.mean(), apart[-1]) < UNLIKE


PATH_OF_RADIUS = 1 / (4 * math.pi)
"""Mean free path of what is no skin, for each unit of the radius that is stated: Cycles takes so much of it, so that walks look as older models
did, whose radius was the farthest that light went."""


def path_of_skin(colors, index):
    """Mean free path of skin, by channel, for each unit of the radius that is stated: the way that light goes on the whole, by the colour that skin
    of this index of refraction has (Jensen et al., "A Practical Model for Subsurface Light Transport", 2001, equation 15)."""
    inside = (0.71 - 1.44 / index) / index + 0.668 + 0.0636 * index
    reflected = 4 / 3 * (1 + inside) / (1 - inside)
    low, high = np.zeros_like(colors, dtype=float), np.ones_like(colors, dtype=float)
    for _ in range(24):
        middle = (low + high) / 2
        way = np.sqrt(3 * (1 - middle))
        is_less = middle / 2 * (1 + np.exp(-reflected * way)) * np.exp(-way) < colors
        low, high = np.where(is_less, middle, low), np.where(is_less, high, middle)
    # white skin lets light go as far as next to white skin does
    return np.sqrt(3 * (1 - np.minimum(low, 0.999999)))
