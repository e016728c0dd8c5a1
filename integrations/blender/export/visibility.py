# SPDX-License-Identifier: GPL-3.0-or-later
"""To which kinds of rays objects show themselves, and what is shown in another way than as itself."""

from .light_groups import LightGroups
from .light_links import LightLinks
from .lights import subject_of
from .rays import KINDS, Seen, in_order


VISIBLE = {kind: f"visible_{kind}" for kind in KINDS}


class Visibility:
    """What a view layer and its objects say of it. What is left out is told once."""

    def __init__(self, scene, layer, warnings):
        self.layer, self.warnings = layer, warnings
        self.links, self.light_groups = LightLinks(scene), LightGroups(layer, warnings)
        self.known = {}

    def begin(self):
        """Begins with another time: all of it may be animated."""
        self.known.clear()

    def of(self, instance, item):
        """To which rays an instance shows itself, as in Cycles: to those that see both the object and what makes its instances."""
        parent = instance.parent if instance.is_instance else item
        key = item.name_full, parent.name_full
        if key not in self.known:
            self.known[key] = self._of(item, parent)
        return self.known[key]

    def _of(self, item, parent):
        both = (item,) if parent is item else (item, parent)
        hidden = {kind for each in both for kind, key in VISIBLE.items() if not getattr(each, key)}
        # layers know what makes instances, which may not be in them; a holdout is seen by the camera
        holdout = parent.original.holdout_get(view_layer=self.layer)
        if not holdout and parent.original.indirect_only_get(view_layer=self.layer):
            hidden.add("camera")
        catcher = item.is_shadow_catcher or parent.is_shadow_catcher
        groups, links, light_group = self.links.groups_of(item, parent), self.links.links(item), self.light_groups.of(item)
        return Seen(frozenset(hidden), holdout, catcher, groups, links, light_group)

    def light(self, instance):
        """Returns true if a light lights anything. Tells what of it is not shown."""
        item = instance.object
        hidden = self._of(item, instance.parent if instance.is_instance else item).hidden
        others = in_order(hidden - {"camera", "shadow"})
        if len(others) == len(KINDS) - 2:
            return False
        said = [f"it is hidden from {' and '.join(others)} rays in Blender, and rays of all kinds see it here"] if others else []
        if "camera" not in hidden and has_size(item.data):
            said.append("the camera does not see it here, as it does in Blender")
        self.warnings.add_for(subject_of(item), said)
        return True

    def links_of_light(self, item):
        """Links of a light. In one that casts no shadows nothing does."""
        links = self.links.links(item)
        return links if item.data.use_shadow else (*(link for link in links if link[0] != "shadow_link"), ("shadow_link", ("", "include")))


def has_size(data):
    """Returns true if a light can be seen by its size."""
    return data.type == "AREA" or (data.type in {"POINT", "SPOT"} and data.shadow_soft_size > 0)
