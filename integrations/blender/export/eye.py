# SPDX-License-Identifier: GPL-3.0-or-later
"""The eye: what nodes give that depends on the angle at which a surface is seen."""

import numpy as np

from .layers import COSINES

ASLANT = 0.5**0.5
"""Cosine of the angle at which what depends on the eye is looked up where one constant has to stand for it."""

NORMALS = {("BUMP", "Normal"), ("NORMAL_MAP", "Normal"), ("NEW_GEOMETRY", "Normal"), ("NEW_GEOMETRY", "True Normal")}
"""What gives the normal of a surface, by a node's type and the name of its output."""


def index_of_weight(blend):
    """The index of refraction that the Fresnel output of a Layer Weight has for its blend."""
    return 1 / max(1 - blend, 1e-5)


def facing(blend, cosine):
    """The Facing output of a Layer Weight."""
    blend = min(max(blend, 0.0), 1 - 1e-5)
    return 1 - cosine ** (2 * blend if blend < 0.5 else 0.5 / (1 - blend))


def toward(evaluator, node):
    """How far the normal of a node of the eye is turned towards the eye, from 0 to 1; None if it is not turned so.

    Groups for rough dielectrics mix the normal with the direction to the eye (Incoming of Geometry), mostly by their roughness, so
    that edges reflect less. The cosine, which is that of the mix, goes as far towards 1.
    """
    with evaluator.source(node.inputs["Normal"]) as (mix, _):
        inputs = mixed_vectors(mix)
        if inputs is None:
            return None
        factor, one, other = inputs
        if not (gives(evaluator, mix.inputs[one], NORMALS) and gives(evaluator, mix.inputs[other], {("NEW_GEOMETRY", "Incoming")})):
            return None
        return np.clip(evaluator.input(mix, factor), 0, 1)


def mixed_vectors(node):
    """Numbers of the factor and of both inputs of a node that mixes vectors or colours, component by component; None of any other node."""
    if node is None or node.mute:
        return None
    if node.type == "MIX_RGB" and node.blend_type == "MIX" and not node.use_clamp:
        return 0, 1, 2
    if node.type != "MIX":
        return None
    if node.data_type == "RGBA" and node.blend_type == "MIX" and not node.clamp_result:
        return 0, 6, 7
    return (0, 4, 5) if node.data_type == "VECTOR" and node.factor_mode == "UNIFORM" else None


def gives(evaluator, socket, outputs):
    """Returns true if an input is linked to one of these outputs, by a node's type and the name of its output."""
    with evaluator.source(socket) as (source, output):
        return source is not None and (source.type, output.name) in outputs


def asks(evaluator, socket, met):
    """Returns true if what an input is linked to asks for the angle. `met`: the nodes that were looked at, to which others are added."""
    with evaluator.source(socket) as (node, _):
        place = node and (tuple(parent.as_pointer() for parent in evaluator.parents), node.as_pointer())
        if node is None or place in met:
            return False
        met.add(place)
        return node.type in {"FRESNEL", "LAYER_WEIGHT"} or any(asks(evaluator, entry, met) for entry in node.inputs if entry.is_linked)


def by_angle(evaluator, node, name):
    """What an input of a node is at the angles of layers.COSINES, as an array; None if it depends on anything but the angle, or not on that."""
    if not asks(evaluator, node.inputs[name], set()):
        return None
    found = []
    for cosine in COSINES:
        seen = evaluator.seen_at(float(cosine))
        value = seen.input(node, name)
        # what depends on the place has a constant, which is told, or is a picture or an attribute
        if seen.said or seen.asked or value.shape[:2] != (1, 1):
            return None
        found.append(min(max(float(value.mean()), 0.0), 1.0))
    return np.array(found) if np.ptp(found) > 1e-6 else None
