# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds of rays: which of them meet an object, and what Light Path nodes say of each."""

from dataclasses import dataclass

KINDS = ("camera", "diffuse", "glossy", "transmission", "shadow")
"""As shots call them. Those of Blender's objects are `visible_` and this. There is no scatter in volumes here."""

IS_OF = {
    "Is Camera Ray": {"camera"},
    "Is Shadow Ray": {"shadow"},
    "Is Diffuse Ray": {"diffuse"},
    # Cycles counts the light that passes glass among what a layer bends or reflects
    "Is Glossy Ray": {"glossy", "transmission"},
    "Is Reflection Ray": {"diffuse", "glossy"},
    "Is Transmission Ray": {"transmission"},
}
"""From an output of Light Path to the rays for which it is 1; it is 0 for all others."""


@dataclass(frozen=True)
class Seen:
    """To which rays something shows itself."""

    hidden: frozenset = frozenset()
    """Kinds of rays that do not meet it."""
    holdout: bool = False
    """True if it is a hole to rays of the camera."""
    catcher: bool = False
    """True if rays of the camera see the shadows on it and nothing else of it."""
    groups: tuple = ()
    """Names of groups that it is in, by which lights are linked to it."""
    links: tuple = ()
    """Links of the light that it emits: see light_links.py."""
    light_group: str | None = None
    """Light group of what it emits."""

    def is_nowhere(self):
        """Returns true if no ray meets it."""
        return len(self.hidden) == len(KINDS)

    def and_of(self, other):
        """What is left for rays where both count."""
        return Seen(
            self.hidden | other.hidden,
            self.holdout or other.holdout,
            self.catcher or other.catcher,
            self.groups or other.groups,
            self.links or other.links,
            self.light_group or other.light_group,
        )

    def keys(self):
        """Keys of a [[model]]."""
        keys = {}
        if self.hidden:
            keys["hidden_from"] = in_order(self.hidden)
        if (self.holdout or self.catcher) and "camera" not in self.hidden:
            keys["holdout" if self.holdout else "shadow_catcher"] = True
        if self.groups:
            keys["groups"] = list(self.groups)
        if self.light_group:
            keys["light_group"] = self.light_group
        return keys


def in_order(kinds):
    """Kinds of rays in the order in which they are told."""
    return [kind for kind in KINDS if kind in kinds]
