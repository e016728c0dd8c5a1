# SPDX-License-Identifier: GPL-3.0-or-later
"""What shots have no tracks for, such as materials: it rests as it was when it was seen first, and is told if it does not in Blender."""

import numpy as np

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

    def tell(self):
        """Warns of what has changed, once for each subject."""
        for key, names in self.changed.items():
            subject, time, _ = self.first[key]
            of = f": its {' and '.join(names)}" if all(names) else ""
            self.warnings.add(f"{subject}{of} {'are' if len(names) > 1 else 'is'} animated: frame {time:g} is shown")


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


def values_of(owner):
    """All that nodes of a material or world are set to, or its own settings without nodes, as one list."""
    found = []
    for tree in trees_of(owner):
        for node in tree.nodes:
            found.append(settings_of(node))
            found += [plain(entry.default_value) for entry in (*node.inputs, *node.outputs) if hasattr(entry, "default_value")]
            if node.type == "VALTORGB":
                found += [[element.position, *element.color] for element in node.color_ramp.elements]
    return found or settings_of(owner)


def settings_of(data):
    """Values of a struct of Blender's."""
    return [plain(getattr(data, entry.identifier)) for entry in data.bl_rna.properties if entry.type in PLAIN and not entry.is_readonly]


def plain(value):
    """A value of Blender's as Python has it."""
    return value if isinstance(value, (bool, int, float, str)) or not hasattr(value, "__iter__") else [plain(part) for part in value]
