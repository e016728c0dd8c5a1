# SPDX-License-Identifier: GPL-3.0-or-later
"""What shots have no tracks for, such as materials: it rests as it was when it was seen first, and is told if it does not in Blender."""

import hashlib

import numpy as np

from .pictures import clip_of, path_of, status_of, tile_file

PLAIN = {"BOOLEAN", "INT", "FLOAT", "ENUM", "STRING"}


class AtRest:
    """Values that should stay what they are."""

    def __init__(self, warnings):
        self.warnings, self.first, self.changed = warnings, {}, {}

    def see(self, key, subject, time, values):
        """Notes values of what has this key at a time, each by what it is called ("": the subject itself)."""
        _, _, before = self.first.setdefault(key, (subject, time, values))
        for name in {**before, **values}:
            if not alike(before.get(name), values.get(name)):
                self.changed.setdefault(key, {}).setdefault(name)

    def tell(self, is_rendered_anew=False):
        """Warns of what has changed, once for each subject. `is_rendered_anew`: a shot of its own shows what it has become."""
        for key, names in self.changed.items():
            subject, time, _ = self.first[key]
            of = f": its {' and '.join(names)}" if all(names) else ""
            shown = "frames in which it changes reuse nothing of those before" if is_rendered_anew else f"frame {time:g} is shown"
            self.warnings.add(f"{subject}{of} {'are' if len(names) > 1 else 'is'} animated: {shown}")


def alike(before, now):
    """Returns true if values are equal but for roundings, which matrices of parents bring along."""
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        return all(alike(*pair) for pair in zip(before, now))
    if isinstance(before, float) and isinstance(now, float):
        return bool(np.isclose(before, now, rtol=1e-4, atol=1e-6))
    return before == now


def trees_of(owner):
    """The node tree of a material or world, and those of its groups."""
    tree = owner.node_tree if owner.use_nodes else None
    waiting, found = [tree] if tree else [], []
    while waiting:
        tree = waiting.pop()
        if tree not in found:
            found.append(tree)
            waiting += [node.node_tree for node in tree.nodes if node.type == "GROUP" and node.node_tree]
    return found


def may_change(owner):
    """Returns true if a material or world has animation or drivers."""
    return any(holder.animation_data for holder in (owner, *trees_of(owner)))


def ray_visibility_of(owner):
    """Settings of Cycles that say which rays see a world; None if there are none. They are those of the original unless something animates it:
    Blender 4.2 does not notice that they are set, so that what persistent data keeps has them as they were."""
    return getattr(owner if may_change(owner) else owner.original, "cycles_visibility", None)


def surroundings_of(world, time):
    """What a world depends on beside its own values: where the objects are that it refers to, and what its movies show at a time."""
    nodes = [node for tree in trees_of(world) for node in tree.nodes]
    places = [plain(row) for node in nodes if getattr(node, "object", None) for row in node.object.matrix_world]
    return [*places, *(clip.at(time) for clip in map(clip_of, nodes) if clip is not None)]


def values_of(owner):
    """All that nodes of a material or world are set to, or its own settings without nodes, as one list."""
    found = []
    for tree in trees_of(owner):
        for node in tree.nodes:
            found.append(settings_of(node, OF_EDITORS))
            found += [plain(entry.default_value) for entry in (*node.inputs, *node.outputs) if hasattr(entry, "default_value")]
            if node.type == "VALTORGB":
                found += [[element.position, *element.color] for element in node.color_ramp.elements]
            if getattr(node, "mapping", None):
                found += [plain(point.location) for curve in node.mapping.curves for point in curve.points]
    return found or settings_of(owner)


OF_EDITORS = {"location", "location_absolute", "width", "height", "dimensions", "select", "hide", "color", "use_custom_color", "label", "warning_propagation"}
"""Settings of nodes that say how editors draw them, beside those that begin with `show_`."""


def settings_of(data, but=frozenset()):
    """Values of a struct of Blender's."""
    names = [entry.identifier for entry in data.bl_rna.properties if entry.type in PLAIN and not entry.is_readonly]
    return [plain(getattr(data, name)) for name in names if name not in but and not name.startswith("show_")]


def state_of(owner):
    """All that the nodes of a material or world show depends on, as text: what they are set to, their links and their pictures."""
    of_cycles = ray_visibility_of(owner)
    found = [values_of(owner), settings_of(of_cycles) if of_cycles else []]
    for tree in trees_of(owner):
        ends = [(link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier, link.is_muted) for link in tree.links]
        found.append([[(node.name, node.bl_idname) for node in tree.nodes], sorted(ends)])
        found.append([[state_of_image(node.image), clip_of(node)] for node in tree.nodes if getattr(node, "image", None)])
    return repr(found)


def state_of_image(image):
    """What tells whether an image is the one that it was."""
    paths = [tile_file(path_of(image), tile.number) for tile in image.tiles] if image.source == "TILED" else [path_of(image)]
    saved = [status_of(path) for path in paths]
    painted = ""
    if image.is_dirty:
        pixels = np.empty(len(image.pixels), dtype=np.float32)
        image.pixels.foreach_get(pixels)
        painted = hashlib.blake2b(pixels.data, digest_size=16).hexdigest()
    return [image.name_full, settings_of(image, {"pixels"}), image.colorspace_settings.name, saved, painted, [packed.packed_file.size if packed.packed_file else 0 for packed in image.packed_files]]


def plain(value):
    """A value of Blender's as Python has it."""
    return value if isinstance(value, (bool, int, float, str)) or not hasattr(value, "__iter__") else [plain(part) for part in value]
