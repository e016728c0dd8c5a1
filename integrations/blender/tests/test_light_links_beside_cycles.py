# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking beside Cycles. Needs bpy with Cycles and the renderer's Python module."""

import bpy
import numpy as np
import support
from test_light_links import linked
from test_surfaces import principled
from test_visibility_beside_cycles import Stage

SPOTS = {
    "left": (-1.5, -0.5, 0.9),
    "right": (1.5, -0.5, 0.9),
    "front": (0.0, -2.4, 0),
    "left foot": (-2.7, -0.6, 0),
    "right foot": (2.7, -0.6, 0),
    "mirror": (0.4, -0.5, 1.9),
}
"""Points of two boxes, of the floor before them and beside each, and of a mirror above."""


class LinksBesideCycles(Stage):
    """Two boxes on a floor, with a mirror, under lights that are linked."""

    def setUp(self):
        super().setUp()
        scene, self.places = self.scene, dict(SPOTS)
        scene.afterimage.samples, scene.afterimage.paths, scene.afterimage.reflections, scene.afterimage.shadow_rays = 3, 64, 16, "16"
        self.camera = support.add_camera(scene, (0, -9, 2.2), (1.45, 0, 0), lens=38)
        self.even_world((0.05, 0.05, 0.08))
        matt = principled("Matt", Base_Color=(0.8, 0.8, 0.8, 1), Specular_IOR_level=0.0, Roughness=1.0)[0]
        silver = principled("Silver", Base_Color=(1, 1, 1, 1), Metallic=1.0, Roughness=0.0)[0]
        self.floor = self.square("Floor", 20, matt, (0, 0, 0), (0, 0, 0))
        self.mirror = self.square("Mirror", 1.6, silver, (0.4, -0.5, 1.9), (np.pi / 2 + 0.35, 0, 0.1))
        self.boxes = []
        for place in (-1.5, 1.5):
            bpy.ops.mesh.primitive_cube_add(size=1.6, location=(place, 0, 0.8), rotation=(0, 0, 0.2))
            bpy.context.object.data.materials.append(matt)
            self.boxes.append(bpy.context.object)

    def lamp(self, kind, place, turn=(0, 0, 0), **values):
        return support.add(self.scene, "Lamp", self.light(kind, **values), place, turn)

    def panel(self):
        return self.lamp("AREA", (0, -3.5, 4.5), (0.7, 0, 0), energy=400, size=1.0)

    def glow(self):
        material, _ = principled("Glow", Base_Color=(0, 0, 0, 1), Specular_IOR_level=0.0, Emission_Color=(1, 0.8, 0.6, 1), Emission_Strength=12.0)
        return self.square("Glow", 1.2, material, (0, -4.5, 4.2), (0.8, 0, 0))

    def test_a_panel_lights_its_receivers(self):
        self.panel().light_linking.receiver_collection = linked("Lit", self.boxes[0], self.floor)
        found = self.alike(256)
        self.assertGreater(found["left"][0], 2 * found["right"][0])

    def test_a_sun_lights_all_but_what_is_excluded(self):
        sun = self.lamp("SUN", (0, 0, 9), (0.8, 0.3, 0), energy=3, angle=0.1)
        sun.light_linking.receiver_collection = linked("Lit", exclude=[self.boxes[1], self.floor])
        found = self.alike(256)
        self.assertGreater(found["left"][0], 3 * found["right"][0])

    def test_blockers_alone_cast_shadows(self):
        sun = self.lamp("SUN", (0, 0, 9), (0.3, -0.9, 0), energy=3, angle=0.05)
        whole = self.alike(256)
        sun.light_linking.blocker_collection = linked("Dark", self.boxes[0])
        found = self.alike(256)
        self.assertGreater(abs(found["right foot"][0] - whole["right foot"][0]) + abs(found["left foot"][0] - whole["left foot"][0]), 0.2)

    def test_a_lamp_without_shadows_shines_through_all(self):
        sun = self.lamp("SUN", (0, 0, 9), (0.3, -0.9, 0), energy=3, angle=0.05)
        sun.data.use_shadow = False
        self.alike(256)

    def test_a_mesh_that_emits_lights_its_receivers(self):
        self.glow().light_linking.receiver_collection = linked("Lit", self.boxes[1], self.floor)
        found = self.alike(512)
        self.assertGreater(found["right"][0], 1.5 * found["left"][0])

    def test_blockers_of_a_mesh_that_emits(self):
        self.glow().light_linking.blocker_collection = linked("Dark", exclude=[self.boxes[1]])
        self.alike(512)

    def test_mirrors_see_the_lights_that_light_them(self):
        panel = self.lamp("AREA", (0.4, -6.0, 3.0), (1.2, 0, 0), energy=200, size=3.0)
        panel.light_linking.receiver_collection = linked("Lit", exclude=[self.mirror])
        self.alike(256)
