# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: which objects a light lights, and which cast shadows in its light, by collections as Cycles has them."""

PARTS = (("light_link", "receiver_collection"), ("shadow_link", "blocker_collection"))
"""Keys of shots, and properties of objects."""


class LightLinks:
    """The collections by which lights and emitting objects of a scene are linked.

    A link is a pair of the name of a group and `include` or `exclude`; a group is made of the objects that its collection includes or, where it
    includes none, of those that it excludes.
    """

    def __init__(self, scene):
        self.groups = {}
        """From the name of a collection to its group's name, `include` or `exclude`, and the names of its objects."""
        for item in scene.objects:
            for collection in collections_of(item):
                if collection.name_full not in self.groups:
                    self.groups[collection.name_full] = (f"light link {collection.name_full}", *members(collection))

    def links(self, item):
        """Links of a light, or of what an object emits: pairs of a key of shots and a link."""
        if not self.groups:
            return ()
        linking = getattr(item.original, "light_linking", None)
        found = [(key, getattr(linking, part, None)) for key, part in PARTS]
        groups = [(key, self.groups.get(collection.name_full)) for key, collection in found if collection]
        return tuple((key, group[:2]) for key, group in groups if group and (group[2] or group[1] == "include"))

    def groups_of(self, item, parent):
        """Names of the groups that an instance is in: those of what makes it, or else its object's own."""
        for each in (parent, item):
            found = tuple(name for name, _, objects in self.groups.values() if each.original.name_full in objects)
            if found:
                return found
        return ()


def collections_of(item):
    """Collections by which an object is linked."""
    linking = getattr(item, "light_linking", None)
    found = (getattr(linking, part, None) for _, part in PARTS)
    return [collection for collection in found if collection]


def members(collection):
    """Whether a collection includes or excludes, and the names of the objects that it does so.

    As in Cycles: what is excluded is never included; a collection that includes nothing means all but what it excludes.
    """
    states = {"INCLUDE": set(), "EXCLUDE": set()}
    for child, state in zip(collection.children, collection.collection_children):
        states[state.light_linking.link_state].update(item.name_full for item in child.all_objects)
    for item, state in zip(collection.objects, collection.collection_objects):
        states[state.light_linking.link_state].add(item.name_full)
    if states["INCLUDE"]:
        return "include", states["INCLUDE"] - states["EXCLUDE"]
    return "exclude", states["EXCLUDE"]


def keys_of(links, known):
    """Keys of a [[light]] or [[model]] of these links, where these groups are `known`; None for a light that lights nothing.

    A group of which nothing is exported is not known: to exclude it says nothing, and to include it alone leaves nothing.
    """
    keys = {}
    for key, (group, how) in links:
        if group in known:
            keys[key] = {how: [group]}
        elif how == "include" and key == "shadow_link":
            keys[key] = {"include": []}
        elif how == "include":
            return None
    return keys
