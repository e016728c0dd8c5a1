# SPDX-License-Identifier: GPL-3.0-or-later
"""What view layers, objects, films and lenses say of what is seen. Needs bpy; the renderer is not asked."""

import os
import unittest

import bpy
import numpy as np
import support
from test_surfaces import principled


class Visibility(support.ExportCase):
    def setUp(self):
        super().setUp()
        self.layer = self.scene.view_layers[0]
        self.camera = support.add_camera(self.scene)
        self.floor = support.add(self.scene, "Floor", support.grid())

    def names(self):
        return [model["name"] for model in self.export()["model"]]

    def within(self, *items):
        """Moves objects into a collection of their own; its place in the view layer."""
        collection = bpy.data.collections.new("Some")
        self.scene.collection.children.link(collection)
        for item in items:
            self.scene.collection.objects.unlink(item)
            collection.objects.link(item)
        return self.layer.layer_collection.children["Some"]

    def told_once(self, name, pattern):
        told = [line for line in self.warnings() if name in line]
        self.assertEqual(len(told), 1, self.warnings())
        self.assertRegex(told[0], pattern)

    def test_what_the_camera_does_not_see_is_left_out_and_told_once(self):
        self.scene.frame_end = 3
        support.add(self.scene, "Ghost", support.grid("Ghost")).visible_camera = False
        self.assertEqual(self.names(), ["Floor"])
        self.told_once("`Ghost`", "hidden from the camera alone")

    def test_instances_of_what_the_camera_does_not_see_are_left_out(self):
        ghost = support.add(self.scene, "Ghost", support.grid("Ghost"), (9, 0, 0))
        ghost.visible_camera = False
        self.within(ghost)
        for name in ("Copy", "Hidden"):
            copy = support.add(self.scene, name, None)
            copy.instance_type, copy.instance_collection = "COLLECTION", bpy.data.collections["Some"]
        self.assertEqual(self.names(), ["Floor"])
        ghost.visible_camera, bpy.data.objects["Hidden"].visible_camera = True, False
        self.assertEqual(sorted(self.names()), ["Floor", "Ghost", "Ghost"])
        self.told_once("`Hidden`", "hidden from the camera alone")

    def test_what_no_ray_sees_is_left_out_without_a_word(self):
        for key in dir(self.floor):
            if key.startswith("visible_") and key not in {"visible_get", "visible_in_viewport_get"}:
                setattr(self.floor, key, False)
        support.add(self.scene, "Other", support.grid("Other"))
        self.assertEqual((self.names(), self.warnings()), (["Other"], []))

    def test_what_some_rays_do_not_see_is_told(self):
        self.floor.visible_shadow = self.floor.visible_diffuse = False
        self.assertEqual(self.names(), ["Floor"])
        self.told_once("`Floor`", "diffuse and shadow rays")

    def test_holdouts_and_shadow_catchers_are_told(self):
        catcher = support.add(self.scene, "Catcher", support.grid("Catcher"))
        catcher.is_shadow_catcher = True
        self.floor.is_holdout = True
        self.assertEqual(self.names(), ["Floor", "Catcher"])
        self.told_once("`Floor`", "holdout")
        self.told_once("`Catcher`", "shadow catcher")

    def test_a_collection_that_is_a_holdout_is_told(self):
        self.within(self.floor).holdout = True
        self.assertEqual(self.names(), ["Floor"])
        self.told_once("`Floor`", "holdout")

    def test_a_collection_for_indirect_rays_alone_is_left_out_and_told(self):
        support.add(self.scene, "Other", support.grid("Other"))
        self.within(self.floor).indirect_only = True
        self.assertEqual(self.names(), ["Other"])
        self.told_once("`Floor`", "hidden from the camera alone")

    def test_what_lights_leave_out_is_told(self):
        data = bpy.data.lights.new("Lamp", "POINT")
        data.use_shadow = False
        lamp = support.add(self.scene, "Lamp", data)
        lamp.visible_glossy = False
        lamp.light_linking.receiver_collection = bpy.data.collections.new("Lit")
        self.assertEqual(len(self.export()["light"]), 1)
        self.told_once("`Lamp`", "glossy rays.*casts shadows.*light linking")

    def test_a_lamp_that_the_camera_sees_in_blender_is_told(self):
        lamp = support.add(self.scene, "Lamp", bpy.data.lights.new("Lamp", "AREA"))
        self.export()
        self.assertEqual(self.warnings(), [])
        lamp.visible_camera = True
        self.export()
        self.told_once("`Lamp`", "camera does not see it")

    def test_a_world_that_the_camera_does_not_see_lights_alone(self):
        self.scene.world = self.world((0, 0, 1, 1))
        self.scene.world.cycles_visibility.camera = False
        shot = self.export()
        self.assertEqual((shot["background"]["color"], shot["environment"]["visible"]), ([0, 0, 0], False))
        self.assertEqual(self.warnings(), [])

    def test_a_world_that_the_camera_alone_sees_lights_nothing(self):
        self.scene.world = self.world((0, 0, 1, 1))
        of_cycles = self.scene.world.cycles_visibility
        of_cycles.diffuse = of_cycles.glossy = of_cycles.transmission = False
        shot = self.export()
        self.assertEqual((shot["background"]["color"], "environment" in shot), ([0, 0, 1], False))
        of_cycles.glossy = True
        self.assertIn("environment", self.export())
        self.told_once("`World`", "diffuse and transmission rays")

    def test_a_picture_that_the_camera_alone_sees_lights_and_is_told(self):
        self.scene.world = self.world()
        tree = self.scene.world.node_tree
        source = tree.nodes.new("ShaderNodeTexEnvironment")
        source.image = bpy.data.images.new("Studio", 8, 4, float_buffer=True)
        tree.links.new(source.outputs[0], tree.nodes["Background"].inputs["Color"])
        of_cycles = self.scene.world.cycles_visibility
        of_cycles.diffuse = of_cycles.glossy = of_cycles.transmission = False
        self.assertTrue(self.export()["environment"]["visible"])
        self.told_once("`World`", "lights nothing in Blender")
        of_cycles.camera = False
        self.assertFalse(self.export()["environment"]["visible"])

    def test_hair_of_particles_is_told(self):
        modifier = self.floor.modifiers.new("Fur", "PARTICLE_SYSTEM")
        modifier.particle_system.settings.type = "HAIR"
        modifier.particle_system.settings.count = 10
        modifier.particle_system.name = "Fur"
        self.scene.frame_end = 2
        self.assertEqual(self.names(), ["Floor"])
        self.told_once("`Floor`", "hair of its particle system `Fur`")
        modifier.show_render = False
        self.export()
        self.assertEqual(self.warnings(), [])

    def test_a_portal_of_cycles_is_no_light(self):
        data = bpy.data.lights.new("Window", "AREA")
        support.add(self.scene, "Window", data)
        data.cycles.is_portal = True
        self.assertNotIn("light", self.export())

    def test_a_view_layer_has_its_material(self):
        for name in ("Red", "Green"):
            self.floor.data.materials.append(principled(name)[0])
        support.add(self.scene, "Bare", support.grid("Bare"))
        self.layer.material_override = principled("Clay", Base_Color=(0.5, 0.25, 0.125, 1))[0]
        shot = self.export()
        self.assertEqual([material["name"] for material in shot["material"]], ["Clay"])
        np.testing.assert_allclose(shot["material"][0]["kd"], [0.5, 0.25, 0.125])
        self.assertEqual({os.path.basename(model["ply"]) for model in shot["model"]}, {"Clay.ply"})

    def world(self, color=(1, 1, 1, 1)):
        """A world of this colour."""
        world = bpy.data.worlds.new("World")
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs["Color"].default_value = color
        return world

    def test_a_view_layer_without_sky_has_no_world(self):
        self.scene.world = self.world()
        self.assertIn("background", self.export())
        self.layer.use_sky = False
        shot = self.export()
        # as in Cycles: no light of it, and a background that is black
        self.assertFalse({"background", "environment"} & set(shot))
        self.assertEqual(shot["output"]["background"], "visible")

    @unittest.skipUnless("world_override" in bpy.types.ViewLayer.bl_rna.properties, "view layers of this Blender have no world of their own")
    def test_a_view_layer_has_its_world(self):
        self.scene.world, self.layer.world_override = self.world(), self.world((1, 0, 0, 1))
        self.assertEqual(self.export()["background"]["color"], [1, 0, 0])

    def test_a_view_layer_without_surfaces_shows_none(self):
        self.layer.use_solid = False
        self.assertEqual(self.names(), ["nothing"])

    def test_the_exposure_of_the_film_is_on_all_light(self):
        self.scene.world = self.world((0.5, 0.5, 0.5, 1))
        self.floor.data.materials.append(principled("Glow", Emission_Color=(1, 1, 1, 1), Emission_Strength=1.0)[0])
        support.add(self.scene, "Sun", bpy.data.lights.new("Sun", "SUN"))
        self.scene.afterimage.clamp = 5

        def found():
            shot = self.export()
            values = [*shot["background"]["color"], shot["light"][0]["power"], *shot["material"][0]["ke"], shot["render"]["clamp"]]
            return np.array(values)

        before = found()
        self.scene.cycles.film_exposure = 2.5
        np.testing.assert_allclose(found(), before * 2.5)

    def test_a_map_has_the_exposure_of_the_film(self):
        self.scene.world = self.world()
        tree = self.scene.world.node_tree
        source = tree.nodes.new("ShaderNodeTexEnvironment")
        source.image = bpy.data.images.new("Studio", 8, 4, float_buffer=True)
        tree.links.new(source.outputs[0], tree.nodes["Background"].inputs["Color"])
        self.scene.cycles.film_exposure = 2.5
        self.assertEqual(self.export()["environment"]["power"], 2.5)

    def test_what_the_clipping_of_a_camera_cuts_off_is_told_once(self):
        self.scene.frame_end = 2
        self.camera.data.clip_start, self.camera.data.clip_end = 1.0, 50.0
        # around the camera, and reaching into what it sees before the clip start; beside that; beyond the end
        support.add(self.scene, "Near", support.grid("Near"), (0, -4.5, 0))
        support.add(self.scene, "Below", support.grid("Below", 20), (0, -5, -1.7))
        support.add(self.scene, "Behind", support.grid("Behind"), (0, -6.5, 0))
        for index in range(4):
            support.add(self.scene, f"Far {index}", support.grid("Far"), (0, 60, 0))
        self.assertEqual(len(self.names()), 8)
        told = [line for line in self.warnings() if "clip" in line]
        self.assertEqual(told, [
            "camera `Camera`: its clip start is left out: it cuts `Near` off in Blender",
            "camera `Camera`: its clip end is left out: it cuts `Far 0`, `Far 1`, `Far 2` and 1 more off in Blender",
        ])

    def test_clipping_that_cuts_nothing_off_is_not_told(self):
        self.scene.frame_end = 2
        support.add(self.scene, "Room", support.grid("Room", 30, 3), (0, 0, -1))
        self.export()
        self.assertEqual(self.warnings(), [])

    def test_the_light_path_is_that_of_the_camera_wherever_it_is_used(self):
        material, node = principled("Trick")
        tree = material.node_tree
        path, math = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMath")
        math.operation, math.inputs[1].default_value = "MULTIPLY", 0.5
        tree.links.new(path.outputs["Is Camera Ray"], math.inputs[0])
        tree.links.new(math.outputs[0], node.inputs["Metallic"])
        self.floor.data.materials.append(material)
        self.assertAlmostEqual(self.export()["material"][0]["pm"], 0.5)
        self.told_once("`Trick`", "Light Path")


if __name__ == "__main__":
    unittest.main()
