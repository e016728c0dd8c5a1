# SPDX-License-Identifier: GPL-3.0-or-later
"""Which view layers show the same things in the same light, so that one render serves all of them, each with passes of its own."""

OF_WHAT_IS_SHOWN = (
    "material_override", "world_override", "use_sky", "use_solid", "use_strand", "use_volumes", "use_motion_blur", "samples",
)
"""Properties of a view layer that decide what its picture shows; not every version of Blender has each."""


def alike(scene, view_layer):
    """The view layers that are rendered along with this one and show what it shows, itself among them, in the order of the scene."""
    rendered = [layer for layer in scene.view_layers if layer.use]
    own = look(view_layer)
    if scene.render.use_single_layer or view_layer.name not in {layer.name for layer in rendered}:
        return [view_layer]
    return [layer for layer in rendered if look(layer) == own]


def look(view_layer):
    """What decides what a view layer shows. Layers of equal looks have equal pictures."""
    cycles = getattr(view_layer, "cycles", None)
    return (
        [named(getattr(view_layer, name, None)) for name in OF_WHAT_IS_SHOWN],
        # with the pass, the alpha of the picture is without the catchers
        getattr(cycles, "use_pass_shadow_catcher", False),
        # of the groups, those that are rendered go by their number
        [group.name for group in getattr(view_layer, "lightgroups", ())],
        of_collection(view_layer.layer_collection),
    )


def of_collection(layer):
    """What a view layer makes of a collection and of those in it."""
    flags = layer.exclude, layer.holdout, layer.indirect_only, layer.hide_viewport
    return layer.collection.name_full, flags, [of_collection(child) for child in layer.children]


def named(value):
    """A value that is equal for equal properties: of what has a name, that."""
    return getattr(value, "name_full", value)
