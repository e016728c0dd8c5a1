# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups: which lights, emitting objects and worlds are in which group of a view layer."""

MOST = 7
"""Most groups of lights that a shot has."""


class LightGroups:
    """The light groups of a view layer, and the names that shots have for them: any letters may be in Blender's."""

    def __init__(self, view_layer, warnings=None):
        names = [group.name for group in getattr(view_layer, "lightgroups", ())]
        if len(names) > MOST and warnings is not None:
            left_out = ", ".join(f"`{name}`" for name in names[MOST:])
            warnings.add(f"light groups {left_out} have no passes: {MOST} groups are rendered at most")
        self.names = {name: f"group-{number}" for number, name in enumerate(names[:MOST], 1)}

    def of(self, owner):
        """Name, in the shot, of the group of an object or of a world; None where it is in none."""
        return self.names.get(getattr(owner, "lightgroup", ""))
