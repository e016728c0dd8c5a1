# SPDX-License-Identifier: GPL-3.0-or-later
"""What is shown to some kinds of rays alone, or in another way than as itself. Here rays of all kinds see the same."""

from .lights import subject_of

RAYS = {
    "visible_diffuse": "diffuse",
    "visible_glossy": "glossy",
    "visible_transmission": "transmission",
    "visible_volume_scatter": "volume scatter",
    "visible_shadow": "shadow",
}


class Visibility:
    """What a view layer and its objects say of it. Each is told once."""

    def __init__(self, layer, warnings):
        self.layer, self.warnings = layer, warnings
        self.indirect = {}

    def of(self, item):
        """Returns true if an object is to be seen."""
        hidden = [name for key, name in RAYS.items() if not getattr(item, key)]
        if not item.visible_camera or self._is_indirect(item):
            # what no ray sees is hidden in Blender as well
            if len(hidden) < len(RAYS):
                self.warnings.add(f"object `{item.name}` is hidden from the camera alone, and is left out: rays of all kinds see the same here")
            return False
        if hidden:
            self.warnings.add(f"object `{item.name}` is hidden from {' and '.join(hidden)} rays in Blender: rays of all kinds see it here")
        if item.is_shadow_catcher:
            self.warnings.add(f"object `{item.name}` is a shadow catcher in Blender: it is shown as itself")
        return True

    def light(self, item):
        """Tells what of a light is not shown."""
        hidden = [RAYS[key] for key in ("visible_diffuse", "visible_glossy", "visible_transmission") if not getattr(item, key)]
        said = [f"it is hidden from {' and '.join(hidden)} rays in Blender, and rays of all kinds see it here"] if hidden else []
        if item.visible_camera and has_size(item.data):
            said.append("the camera does not see it here, as it does in Blender")
        if not item.data.use_shadow:
            said.append("it casts shadows here")
        linking = getattr(item, "light_linking", None)
        if linking and (linking.receiver_collection or linking.blocker_collection):
            said.append("its light linking is left out: it shines on everything")
        self.warnings.add_for(subject_of(item), said)

    def hair(self, item):
        """Tells of hair that particle systems draw, which is no mesh."""
        for modifier in item.modifiers:
            system = modifier.particle_system if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render else None
            if system and system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                self.warnings.add(f"object `{item.name}`: the hair of its particle system `{system.name}` is left out. Convert it to a mesh")

    def _is_indirect(self, item):
        """Returns true if the collections of an object show it to indirect rays alone. Holdouts are told."""
        name = item.name_full
        if name not in self.indirect:
            original = item.original
            if original.holdout_get(view_layer=self.layer):
                self.warnings.add(f"object `{item.name}` is a holdout in Blender: it is shown as itself")
            self.indirect[name] = original.indirect_only_get(view_layer=self.layer)
        return self.indirect[name]


def has_size(data):
    """Returns true if a light can be seen by its size."""
    return data.type == "AREA" or (data.type in {"POINT", "SPOT"} and data.shadow_soft_size > 0)
