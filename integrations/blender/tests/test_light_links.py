# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: what is exported of it."""

import bpy
import support
from test_surfaces import principled


def linked(collection, *items, exclude=()):
    """A collection of objects, some of which are excluded."""
    made = bpy.data.collections.new(collection)
    for item in (*items, *exclude):
        made.objects.link(item)
    for item, state in zip(made.objects, made.collection_objects):
        state.light_linking.link_state = "EXCLUDE" if item in exclude else "INCLUDE"
    return made


class LightLinks(support.ExportCase):
    def setUp(self):
        super().setUp()
        support.add_camera(self.scene, (0, -8, 2))
        self.floor, self.ball, self.cube = (support.add(self.scene, name, support.grid(name)) for name in ("Floor", "Ball", "Cube"))
        self.lamp = support.add(self.scene, "Lamp", bpy.data.lights.new("Lamp", "POINT"), (0, 0, 3))

    def found(self):
        """The light, and the groups of each model."""
        shot = self.export()
        self.assertEqual(self.warnings(), [])
        return shot["light"][0], {model["name"]: model.get("groups", []) for model in shot["model"]}

    def test_without_links_shots_say_nothing(self):
        light, groups = self.found()
        self.assertNotIn("light_link", light)
        self.assertNotIn("shadow_link", light)
        self.assertEqual(groups, {"Floor": [], "Ball": [], "Cube": []})

    def test_receivers_and_blockers_are_groups(self):
        self.lamp.light_linking.receiver_collection = linked("Lit", self.floor, self.ball)
        self.lamp.light_linking.blocker_collection = linked("Dark", exclude=[self.ball])
        light, groups = self.found()
        self.assertEqual(light["light_link"], {"include": ["light link Lit"]})
        self.assertEqual(light["shadow_link"], {"exclude": ["light link Dark"]})
        self.assertEqual(groups, {"Floor": ["light link Lit"], "Ball": ["light link Lit", "light link Dark"], "Cube": []})

    def test_what_is_excluded_is_not_included(self):
        receivers = linked("Lit", self.floor, exclude=[self.cube])
        child = linked("Child", self.cube, self.ball)
        receivers.children.link(child)
        self.lamp.light_linking.receiver_collection = receivers
        light, groups = self.found()
        self.assertEqual(light["light_link"], {"include": ["light link Lit"]})
        self.assertEqual(groups, {"Floor": ["light link Lit"], "Ball": ["light link Lit"], "Cube": []})
        receivers.collection_children[0].light_linking.link_state = "EXCLUDE"
        self.assertEqual(self.found()[1], {"Floor": ["light link Lit"], "Ball": [], "Cube": []})

    def test_an_empty_collection_means_all(self):
        self.lamp.light_linking.receiver_collection = linked("Lit")
        self.lamp.light_linking.blocker_collection = linked("Dark")
        light, groups = self.found()
        self.assertEqual((light.get("light_link"), light.get("shadow_link"), groups["Floor"]), (None, None, []))

    def test_what_is_not_exported_is_in_no_link(self):
        self.lamp.light_linking.blocker_collection = linked("Dark", self.cube)
        self.cube.hide_render = True
        self.assertEqual(self.found()[0]["shadow_link"], {"include": []})
        self.lamp.light_linking.receiver_collection = linked("Lit", self.cube)
        # it lights nothing
        self.assertNotIn("light", self.export())

    def test_a_lamp_without_shadows_has_a_link_to_nothing(self):
        self.lamp.data.use_shadow = False
        light, _ = self.found()
        self.assertEqual((light.get("light_link"), light["shadow_link"]), (None, {"include": []}))

    def test_links_of_what_emits_are_the_model_s(self):
        glow, _ = principled("Glow", Emission_Color=(1, 1, 1, 1), Emission_Strength=2.0)
        self.ball.data.materials.append(glow)
        self.ball.light_linking.receiver_collection = linked("Lit", self.floor)
        shot = self.export()
        models = {model["name"]: model for model in shot["model"]}
        self.assertEqual(models["Ball"]["light_link"], {"include": ["light link Lit"]})
        self.assertEqual(models["Floor"]["groups"], ["light link Lit"])
        self.assertNotIn("light_link", models["Floor"])
