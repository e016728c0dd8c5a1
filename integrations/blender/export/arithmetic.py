# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes compute of numbers and colours, as Cycles does: of arrays (height, width, channels) that are alike in size."""

import math

import numpy as np


def quotient(a, b, otherwise=0.0):
    """a / b, and something else where b is 0."""
    return np.where(b != 0, a / np.where(b == 0, 1, b), otherwise)


def hsv_of(rgb):
    """Hue, saturation and value of colours."""
    value, low = rgb.max(axis=2), rgb.min(axis=2)
    span = value - low
    by = np.where(span == 0, 1, span)
    r, g, b = (rgb[:, :, index] for index in range(3))
    hue = np.where(r == value, (g - b) / by, np.where(g == value, 2 + (b - r) / by, 4 + (r - g) / by)) / 6
    hue = np.where(span == 0, 0, np.where(hue < 0, hue + 1, hue))
    return np.stack([hue, quotient(span, value), value], axis=2)


def rgb_of(hsv):
    """Colours of hue, saturation and value."""
    hue, saturation, value = (hsv[:, :, index : index + 1] for index in range(3))
    parts = np.clip(np.abs(hue * 6 - np.array([3, 2, 4])) * np.array([1, -1, -1]) + np.array([-1, 2, 2]), 0, 1)
    return ((parts - 1) * saturation + 1) * value


def recolored(a, b, parts):
    """The colour of a with some parts (0 hue, 1 saturation, 2 value) of b; a where b has no hue to give, or a none that could change."""
    one, other = hsv_of(a), hsv_of(b)
    made = one.copy()
    for part in parts:
        made[:, :, part] = other[:, :, part]
    if 0 in parts:
        return np.where(other[:, :, 1:2] != 0, rgb_of(made), a)
    return np.where(one[:, :, 1:2] != 0, rgb_of(made), a) if 1 in parts else rgb_of(made)


def burn(t, a, b):
    """Colour burn: darker by what b lacks."""
    left = 1 - t + t * b
    return np.where(left <= 0, 0, np.clip(1 - quotient(1 - a, left), 0, 1))


def dodge(t, a, b):
    """Colour dodge: brighter by what b has."""
    left = 1 - t * b
    return np.where(a == 0, 0, np.where(left <= 0, 1, np.minimum(quotient(a, left), 1)))


def mixing(function):
    """A blend that is mixed by its factor."""
    return lambda t, a, b: a * (1 - t) + function(a, b) * t


BLENDS = {
    "MIX": mixing(lambda a, b: b),
    "ADD": mixing(lambda a, b: a + b),
    "MULTIPLY": mixing(lambda a, b: a * b),
    "SUBTRACT": mixing(lambda a, b: a - b),
    "SCREEN": mixing(lambda a, b: 1 - (1 - a) * (1 - b)),
    "DIVIDE": mixing(lambda a, b: quotient(a, b, a)),
    "DIFFERENCE": mixing(lambda a, b: np.abs(a - b)),
    "EXCLUSION": lambda t, a, b: np.maximum(a * (1 - t) + (a + b - 2 * a * b) * t, 0),
    "DARKEN": mixing(np.minimum),
    "LIGHTEN": mixing(np.maximum),
    "OVERLAY": mixing(lambda a, b: np.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b))),
    "SOFT_LIGHT": mixing(lambda a, b: (1 - a) * b * a + a * (1 - (1 - b) * (1 - a))),
    "LINEAR_LIGHT": lambda t, a, b: a + t * (2 * b - 1),
    "BURN": burn,
    "DODGE": dodge,
    "HUE": mixing(lambda a, b: recolored(a, b, (0,))),
    "SATURATION": lambda t, a, b: recolored(a, with_part(a, b, 1, t), (1,)),
    "VALUE": lambda t, a, b: recolored(a, with_part(a, b, 2, t), (2,)),
    "COLOR": mixing(lambda a, b: recolored(a, b, (0, 1))),
}
"""From a blend type to what it makes of a factor and two colours."""


def with_part(a, b, part, t):
    """A colour whose part (1 saturation, 2 value) is between those of a and b."""
    one, other = hsv_of(a), hsv_of(b)
    one[:, :, part : part + 1] = one[:, :, part : part + 1] * (1 - t) + other[:, :, part : part + 1] * t
    if part == 1:
        # any colour of that saturation, where a is black
        one[:, :, 2] = 1
    return rgb_of(one)


def power(a, b):
    """a to the b; 0 where that is no real number."""
    is_real = (a >= 0) | (b == np.floor(b))
    with np.errstate(all="ignore"):
        found = np.where(is_real, np.power(np.where(is_real, a, 1), b), 0)
    return np.where(np.isfinite(found), found, 0)


def logarithm(a, b):
    """Logarithm of a to the base b; 0 where there is none."""
    has = (a > 0) & (b > 0) & (b != 1)
    return np.where(has, np.log(np.where(has, a, 1)) / np.log(np.where(has, b, 2)), 0)


def wrapped(a, high, low):
    """a, moved between two limits by whole numbers of their distance."""
    span = high - low
    return np.where(span != 0, a - span * np.floor(quotient(a - low, span)), low)


def pingpong(a, b):
    """a to and fro between 0 and b."""
    share = quotient(a - b, b * 2)
    return np.where(b != 0, np.abs((share - np.floor(share)) * b * 2 - b), 0)


def smoothly_smaller(a, b, width):
    """The smaller one of two numbers, rounded off where they are nearer than a width."""
    near = quotient(np.maximum(width - np.abs(a - b), 0), width)
    return np.where(width != 0, np.minimum(a, b) - near**3 * width / 6, np.minimum(a, b))


def compared(a, b, by):
    """1 where two numbers are alike."""
    return ((a == b) | (np.abs(a - b) <= np.maximum(by, 1e-5))) * 1.0


MATHS = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: quotient(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: power(a, b),
    "LOGARITHM": lambda a, b, c: logarithm(a, b),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "INVERSE_SQRT": lambda a, b, c: np.where(a > 0, 1 / np.sqrt(np.where(a > 0, a, 1)), 0),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b) * 1.0,
    "GREATER_THAN": lambda a, b, c: (a > b) * 1.0,
    "SIGN": lambda a, b, c: np.sign(a),
    "COMPARE": lambda a, b, c: compared(a, b, c),
    "SMOOTH_MIN": lambda a, b, c: smoothly_smaller(a, b, c),
    "SMOOTH_MAX": lambda a, b, c: -smoothly_smaller(-a, -b, c),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "TRUNC": lambda a, b, c: np.trunc(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: np.where(b != 0, np.fmod(a, np.where(b == 0, 1, b)), 0),
    "FLOORED_MODULO": lambda a, b, c: np.where(b != 0, a - np.floor(quotient(a, b)) * b, 0),
    "SNAP": lambda a, b, c: np.floor(quotient(a, b)) * b,
    "WRAP": wrapped,
    "PINGPONG": lambda a, b, c: pingpong(a, b),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
    "TANGENT": lambda a, b, c: np.tan(a),
    "ARCSINE": lambda a, b, c: np.arcsin(np.clip(a, -1, 1)),
    "ARCCOSINE": lambda a, b, c: np.arccos(np.clip(a, -1, 1)),
    "ARCTANGENT": lambda a, b, c: np.arctan(a),
    "ARCTAN2": lambda a, b, c: np.arctan2(a, b),
    "SINH": lambda a, b, c: np.sinh(a),
    "COSH": lambda a, b, c: np.cosh(a),
    "TANH": lambda a, b, c: np.tanh(a),
    "RADIANS": lambda a, b, c: a * (math.pi / 180),
    "DEGREES": lambda a, b, c: a * (180 / math.pi),
}
"""From an operation of Math to what it makes of three numbers."""


def dot(a, b):
    """The dot products of vectors, as numbers."""
    return (a * b).sum(axis=2, keepdims=True)


def unit(a):
    """Vectors of length 1; of nothing nothing."""
    return quotient(a, np.sqrt(dot(a, a)))


def refracted(a, normal, index):
    """Directions behind a surface of some index of refraction; nothing where all is reflected."""
    cos = dot(normal, a)
    left = 1 - index * index * (1 - cos * cos)
    return np.where(left < 0, 0, index * a - (index * cos + np.sqrt(np.maximum(left, 0))) * normal)


VECTOR_MATHS = {
    **{
        name: lambda a, b, c, scale, of=MATHS[name]: of(a, b, c)
        for name in ("ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "MINIMUM", "MAXIMUM", "SNAP", "MODULO", "WRAP", "SINE", "COSINE", "TANGENT")
    },
    **{
        name: lambda a, b, c, scale, of=MATHS[like]: of(a, b, c)
        for name, like in {"ABSOLUTE": "ABSOLUTE", "FLOOR": "FLOOR", "CEIL": "CEIL", "FRACTION": "FRACT", "POWER": "POWER", "SIGN": "SIGN", "ROUND": "ROUND"}.items()
    },
    "CROSS_PRODUCT": lambda a, b, c, scale: np.cross(a, b, axis=2),
    "PROJECT": lambda a, b, c, scale: quotient(dot(a, b), dot(b, b)) * b,
    "REFLECT": lambda a, b, c, scale: a - 2 * dot(unit(b), a) * unit(b),
    "REFRACT": lambda a, b, c, scale: refracted(a, unit(b), scale),
    "FACEFORWARD": lambda a, b, c, scale: np.where(dot(c, b) < 0, a, -a),
    "DOT_PRODUCT": lambda a, b, c, scale: dot(a, b),
    "DISTANCE": lambda a, b, c, scale: np.sqrt(dot(a - b, a - b)),
    "LENGTH": lambda a, b, c, scale: np.sqrt(dot(a, a)),
    "SCALE": lambda a, b, c, scale: a * scale,
    "NORMALIZE": lambda a, b, c, scale: unit(a),
}
"""From an operation of Vector Math to what it makes of three vectors and a number: a vector, or a number."""


def shifted(color, hue, saturation, value):
    """A colour whose hue is turned (0.5: not at all), and its saturation and value multiplied."""
    hsv = hsv_of(color)
    turned = hsv[:, :, 0:1] + hue + 0.5
    return rgb_of(np.concatenate([turned - np.floor(turned), np.clip(hsv[:, :, 1:2] * saturation, 0, 1), hsv[:, :, 2:3] * value], axis=2))
