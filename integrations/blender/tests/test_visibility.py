# SPDX-License-Identifier: GPL-3.0-or-later
"""What view layers, objects, films and lenses say of what is seen. Needs bpy; the renderer is not asked."""

import os
import types
import unittest

import bpy
import numpy as np
import support
from test_surfaces import principled, read_ply


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

    def model(self, name):
        """The exported model of this name, which must be the only one."""
        found = [model for model in self.export()["model"] if model["name"] == name]
        self.assertEqual(len(found), 1)
        return found[0]

    def hidden(self):
        """From names of models to what they are hidden from, in order."""
        found = {}
        for model in self.export()["model"]:
            found.setdefault(model["name"], []).append(model.get("hidden_from"))
        return {name: sorted(each, key=str) for name, each in found.items()}

    def test_rays_that_do_not_see_an_object_do_not_meet_its_model(self):
        for kind in ("camera", "diffuse", "glossy", "transmission", "shadow"):
            setattr(self.floor, f"visible_{kind}", False)
            self.assertEqual(self.hidden(), {"Floor": [[kind]]})
            setattr(self.floor, f"visible_{kind}", True)
        self.floor.visible_shadow = self.floor.visible_diffuse = False
        self.assertEqual(self.hidden(), {"Floor": [["diffuse", "shadow"]]})
        self.assertEqual(self.warnings(), [])

    def test_what_has_surfaces_or_instances_has_a_panel_of_rays(self):
        panel = bpy.types.AFTERIMAGE_PT_ray_visibility
        lamp = support.add(self.scene, "Lamp", bpy.data.lights.new("Lamp", "POINT"))
        copy = support.add(self.scene, "Copy", None)
        copy.instance_type = "COLLECTION"
        context = lambda item, engine="AFTERIMAGE": types.SimpleNamespace(object=item, engine=engine)
        self.assertEqual([panel.poll(context(item)) for item in (self.floor, copy, lamp, None)], [True, True, False, False])
        self.assertFalse(panel.poll(context(self.floor, "CYCLES")))
        drawn = []
        layout = types.SimpleNamespace(prop=lambda item, name, text: drawn.append((item.name, name)))
        support.extension().panels.AFTERIMAGE_PT_ray_visibility.draw(types.SimpleNamespace(layout=layout), context(self.floor))
        self.assertEqual(drawn, [("Floor", f"visible_{kind}") for kind in ("camera", "diffuse", "glossy", "transmission", "shadow")])

    def test_there_are_no_rays_that_volumes_scatter(self):
        self.floor.visible_volume_scatter = False
        self.assertEqual((self.hidden(), self.warnings()), ({"Floor": [None]}, []))

    def test_an_instance_shows_itself_to_rays_that_see_it_and_what_makes_it(self):
        ghost = support.add(self.scene, "Ghost", support.grid("Ghost"), (9, 0, 0))
        ghost.visible_camera = False
        self.within(ghost)
        inner = support.add(self.scene, "Inner", None)
        outer = bpy.data.collections.new("Outer")
        outer.objects.link(inner)
        for name in ("Copy", "Shadowless"):
            copy = support.add(self.scene, name, None)
            copy.instance_type, copy.instance_collection = "COLLECTION", outer
        self.scene.collection.objects.unlink(inner)
        inner.instance_type, inner.instance_collection = "COLLECTION", bpy.data.collections["Some"]
        bpy.data.objects["Shadowless"].visible_shadow = False
        # of what lies between in a row of instances nothing counts
        inner.visible_glossy = False
        self.assertEqual(self.hidden(), {"Floor": [None], "Ghost": [["camera", "shadow"], ["camera"], ["camera"]]})
        self.assertEqual(self.warnings(), [])

    def test_particles_show_themselves_to_rays_that_see_them_and_their_emitter(self):
        self.within(grain := support.add(self.scene, "Grain", support.grid("Grain", 0.1), (9, 0, 0)))
        grain.visible_glossy = False
        modifier = self.floor.modifiers.new("Rain", "PARTICLE_SYSTEM")
        settings = modifier.particle_system.settings
        settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 5, 0, 0, 100
        settings.render_type, settings.instance_object = "OBJECT", grain
        self.floor.visible_camera = False
        self.scene.frame_set(1)
        found = self.hidden()
        self.assertEqual((found["Floor"], found["Grain"]), ([["camera"]], [["camera", "glossy"]] * 5 + [["glossy"]]))

    def test_copies_of_one_mesh_that_differ_in_what_sees_them_are_not_one_array(self):
        for number in range(200):
            copy = support.add(self.scene, f"Copy {number}", self.floor.data, (number, 0, 0))
            copy.visible_camera = number % 2 == 0
        models = {str(model.get("hidden_from")): model["places"] for model in self.export()["model"]}
        self.assertEqual(sorted(models), ["None", "['camera']"])
        self.assertEqual(len({places["file"] for places in models.values()} | {places["names"] for places in models.values()}), 4)
        places = {key: np.load(os.path.join(self.folder, each["file"]))[:, 0, 3] for key, each in models.items()}
        np.testing.assert_allclose(np.sort(places["['camera']"]), np.arange(1, 200, 2))
        self.assertEqual(len(places["None"]), 101)

    def test_an_object_that_becomes_visible_is_another_model_from_then_on(self):
        self.scene.frame_end = 3
        for frame, seen in ((1, False), (3, True)):
            self.floor.visible_camera = seen
            self.floor.keyframe_insert("visible_camera", frame=frame)
        models = self.export()["model"]
        found = [(model.get("hidden_from"), [(key["frame"], key["visible"]) for key in model["key"]]) for model in models]
        self.assertEqual(found, [(["camera"], [(1, True), (3, False)]), (None, [(3, True)])])

    def test_what_no_ray_sees_is_left_out_without_a_word(self):
        for key in dir(self.floor):
            if key.startswith("visible_") and key not in {"visible_get", "visible_in_viewport_get"}:
                setattr(self.floor, key, False)
        support.add(self.scene, "Other", support.grid("Other"))
        self.assertEqual((self.names(), self.warnings()), (["Other"], []))

    def test_a_holdout_is_a_hole_to_the_camera(self):
        self.assertNotIn("holdout", self.model("Floor"))
        self.floor.is_holdout = True
        floor = self.model("Floor")
        self.assertEqual((floor["holdout"], "hidden_from" in floor, self.warnings()), (True, False, []))
        self.floor.visible_camera = False
        self.assertNotIn("holdout", self.model("Floor"))

    def test_a_holdout_of_a_veil_is_told(self):
        material, node = principled("Veil", Alpha=0.5)
        self.floor.data.materials.append(material)
        self.floor.is_holdout = True
        self.assertTrue(self.model("Floor")["holdout"])
        self.told_once("`Floor`", "holdout is a whole one")
        node.inputs["Alpha"].default_value = 1
        self.export()
        self.assertEqual(self.warnings(), [])

    def test_a_collection_may_be_a_holdout(self):
        collection = self.within(self.floor)
        collection.holdout = True
        self.assertTrue(self.model("Floor")["holdout"])
        # as in Cycles: the camera sees a hole where it does not see what else is for indirect rays alone
        collection.indirect_only = True
        floor = self.model("Floor")
        self.assertEqual((floor["holdout"], "hidden_from" in floor, self.warnings()), (True, False, []))

    def test_instances_are_holdouts_where_what_makes_them_is_one(self):
        ghost = support.add(self.scene, "Ghost", support.grid("Ghost"), (9, 0, 0))
        self.within(ghost)
        copy = support.add(self.scene, "Copy", None)
        copy.instance_type, copy.instance_collection = "COLLECTION", bpy.data.collections["Some"]
        holes = lambda: [(model["matrix"][0][3], "holdout" in model) for model in self.export()["model"] if model["name"] == "Ghost"]
        copy.location.x = -5
        ghost.is_holdout = True
        self.assertEqual(sorted(holes()), [(4, False), (9, True)])
        ghost.is_holdout, copy.is_holdout = False, True
        self.assertEqual(sorted(holes()), [(4, True), (9, False)])

    def test_a_shadow_catcher_shows_its_shadows_to_the_camera(self):
        self.assertNotIn("shadow_catcher", self.model("Floor"))
        self.floor.is_shadow_catcher = True
        self.assertTrue(self.model("Floor")["shadow_catcher"])
        # a hole shows no shadows, and what the camera does not see shows nothing
        self.floor.is_holdout = True
        floor = self.model("Floor")
        self.assertEqual((floor["holdout"], "shadow_catcher" in floor), (True, False))
        self.floor.is_holdout, self.floor.visible_camera = False, False
        self.assertNotIn("shadow_catcher", self.model("Floor"))
        self.assertEqual(self.warnings(), [])

    def test_a_shadow_catcher_that_reflects_nothing_shows_nothing(self):
        self.floor.is_shadow_catcher = True
        material = bpy.data.materials.new("Dark")
        material.use_nodes = True
        tree = material.node_tree
        self.floor.data.materials.append(material)
        shaders = {kind: tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfTransparent", "Emission", "BsdfDiffuse")}
        for kind, shows in (("BsdfTransparent", False), ("Emission", False), ("BsdfDiffuse", True)):
            tree.links.new(shaders[kind].outputs[0], tree.nodes["Material Output"].inputs["Surface"])
            floor = self.model("Floor")
            self.assertEqual((floor.get("shadow_catcher", False), floor.get("hidden_from")), (shows, None if shows else ["camera"]), kind)

    def test_catchers_beside_each_other_are_told(self):
        other = support.add(self.scene, "Wall", support.grid("Wall"), (0, 3, 0), (1.5, 0, 0))
        self.floor.is_shadow_catcher = other.is_shadow_catcher = True
        self.model("Floor")
        self.assertEqual(self.warnings(), ["shadow catchers `Floor`, `Wall` cast shadows on each other, as they do not in Blender"])
        other.is_holdout = True
        self.model("Floor")
        self.assertEqual(self.warnings(), [])

    def test_a_collection_for_indirect_rays_alone_is_hidden_from_the_camera(self):
        support.add(self.scene, "Other", support.grid("Other"))
        self.within(self.floor).indirect_only = True
        self.assertEqual((self.hidden(), self.warnings()), ({"Floor": [["camera"]], "Other": [None]}, []))

    def test_clipping_cuts_nothing_off_that_the_camera_does_not_see(self):
        self.camera.data.clip_end = 50
        support.add(self.scene, "Dome", support.grid("Dome"), (0, 60, 0)).visible_camera = False
        self.export()
        self.assertEqual(self.warnings(), [])

    def test_what_lights_leave_out_is_told(self):
        lamp = support.add(self.scene, "Lamp", bpy.data.lights.new("Lamp", "POINT"))
        lamp.visible_glossy = False
        self.assertEqual(len(self.export()["light"]), 1)
        self.told_once("`Lamp`", "glossy rays")

    def test_a_lamp_that_the_camera_sees_in_blender_is_told(self):
        lamp = support.add(self.scene, "Lamp", bpy.data.lights.new("Lamp", "AREA"))
        self.export()
        self.assertEqual(self.warnings(), [])
        lamp.visible_camera = True
        self.export()
        self.told_once("`Lamp`", "camera does not see it")
        self.within(lamp).indirect_only = True
        self.export()
        self.assertEqual(self.warnings(), [])

    def test_a_lamp_that_no_surface_sees_is_no_light(self):
        lamp = support.add(self.scene, "Lamp", bpy.data.lights.new("Lamp", "POINT"))
        lamp.visible_diffuse = lamp.visible_glossy = lamp.visible_transmission = False
        self.assertNotIn("light", self.export())

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

    def test_hair_of_particles_is_shown_where_renders_show_it(self):
        modifier = self.floor.modifiers.new("Fur", "PARTICLE_SYSTEM")
        modifier.particle_system.settings.type = "HAIR"
        modifier.particle_system.settings.count = 10
        modifier.particle_system.name = "Fur"
        self.scene.frame_end = 2
        self.assertEqual(self.names(), ["Floor", "Floor"])
        curves = [model["curves"] for model in self.export()["model"] if "curves" in model]
        self.assertEqual([curve["basis"] for curve in curves], ["catmull-rom"])
        modifier.show_render = False
        self.assertEqual(self.names(), ["Floor"])
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

    def clip(self):
        """Clipping distances of the camera's keys."""
        shot = self.export()
        self.assertEqual(self.warnings(), [])
        return [(key.get("near"), key.get("far")) for key in shot["camera"]["key"]]

    def test_a_camera_has_the_clipping_distances_that_cut_anything_off(self):
        self.scene.frame_end = 2
        self.camera.data.clip_start, self.camera.data.clip_end = 1.0, 50.0
        # beside what the camera sees before the clip start, and behind it
        support.add(self.scene, "Below", support.grid("Below", 20), (0, -5, -1.7))
        support.add(self.scene, "Behind", support.grid("Behind"), (0, -6.5, 0))
        self.assertEqual(set(self.clip()), {(None, None)})
        far = support.add(self.scene, "Far", support.grid("Far"), (0, 60, 0))
        self.assertEqual(set(self.clip()), {(None, 50)})
        # around the camera, and reaching into what it sees
        support.add(self.scene, "Near", support.grid("Near"), (0, -4.5, 0))
        self.assertEqual(set(self.clip()), {(1, 50)})
        bpy.data.objects.remove(far)
        self.assertEqual(set(self.clip()), {(1, None)})

    def test_clipping_distances_are_keyed_where_they_are_animated(self):
        self.scene.frame_end = 2
        support.add(self.scene, "Far", support.grid("Far"), (0, 60, 0))
        for frame, end in ((1, 50), (2, 40)):
            self.camera.data.clip_end = end
            self.camera.data.keyframe_insert("clip_end", frame=frame)
        self.assertEqual(self.clip(), [(None, 50), (None, 40)])

    def test_a_room_around_the_camera_is_not_cut_off(self):
        support.add(self.scene, "Room", support.grid("Room", 30, 3), (0, 0, -1))
        self.assertEqual(set(self.clip()), {(None, None)})


class LightPaths(support.ExportCase):
    """Materials that are not the same to all rays."""

    def setUp(self):
        super().setUp()
        support.add_camera(self.scene)
        self.item = support.add(self.scene, "Square", support.grid())

    def node(self, kind, **values):
        """A node of the material at hand. `values`: its inputs, by names with _ for blanks."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in values.items():
            node.inputs[name.replace("_", " ")].default_value = value
        return node

    def mixed(self, factor, one, other):
        """A mix of two shader nodes, whose surface is the object's. `factor`: an output of Light Path by its name, or a socket."""
        mix, output = self.node("MixShader"), self.tree.nodes["Material Output"]
        factor = self.path.outputs[factor] if isinstance(factor, str) else factor
        for source, socket in zip((factor, one.outputs[0], other.outputs[0]), mix.inputs):
            self.tree.links.new(source, socket)
        self.tree.links.new(mix.outputs[0], output.inputs["Surface"])

    def material(self, name="Trick"):
        """A material of the object's, whose nodes are those at hand from now on."""
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        self.item.data.materials.append(material)
        self.tree = material.node_tree
        self.path = self.node("LightPath")

    def found(self):
        """What the one model is hidden from, and the one material."""
        shot = self.export()
        self.assertEqual((len(shot["model"]), len(shot["material"])), (1, 1))
        return shot["model"][0].get("hidden_from"), shot["material"][0]

    def test_what_is_clear_to_some_rays_does_not_meet_them(self):
        others = {
            "Is Camera Ray": (["camera"], ["diffuse", "glossy", "transmission", "shadow"]),
            "Is Shadow Ray": (["shadow"], ["camera", "diffuse", "glossy", "transmission"]),
            "Is Diffuse Ray": (["diffuse"], ["camera", "glossy", "transmission", "shadow"]),
            "Is Glossy Ray": (["glossy", "transmission"], ["camera", "diffuse", "shadow"]),
            "Is Reflection Ray": (["diffuse", "glossy"], ["camera", "transmission", "shadow"]),
            "Is Transmission Ray": (["transmission"], ["camera", "diffuse", "glossy", "shadow"]),
        }
        self.material()
        red, clear = self.node("BsdfDiffuse", Color=(1, 0, 0, 1)), self.node("BsdfTransparent")
        for output, (first, second) in others.items():
            for shaders, kinds in (((red, clear), first), ((clear, red), second)):
                self.mixed(output, *shaders)
                hidden, values = self.found()
                self.assertEqual((hidden, values["kd"], "d" in values), (kinds, [1, 0, 0], False), output)
                self.assertEqual(self.warnings(), [])

    def test_a_light_that_is_clear_to_the_camera_still_shines(self):
        self.material()
        self.mixed("Is Camera Ray", self.node("Emission", Strength=3.0), self.node("BsdfTransparent"))
        hidden, values = self.found()
        self.assertEqual((hidden, values["ke"], self.warnings()), (["camera"], [3, 3, 3], []))

    def test_what_lights_matt_surfaces_is_what_it_is_without_a_ray(self):
        # as in Cycles, which does not ask their rays
        self.material()
        light, clear = self.node("Emission", Strength=3.0), self.node("BsdfTransparent")
        self.mixed("Is Diffuse Ray", light, clear)
        self.assertEqual(self.found()[0], None)
        self.mixed("Is Diffuse Ray", clear, light)
        self.assertEqual((self.found()[0], self.found()[1]["d"]), (None, 0))

    def test_glass_that_casts_no_shadow_and_lets_light_in(self):
        self.material()
        either = self.node("Math")
        either.operation = "MAXIMUM"
        for output, socket in zip(("Is Shadow Ray", "Is Diffuse Ray"), either.inputs):
            self.tree.links.new(self.path.outputs[output], socket)
        self.mixed(either.outputs[0], self.node("BsdfGlass", IOR=1.25), self.node("BsdfTransparent"))
        hidden, values = self.found()
        self.assertEqual((hidden, values["illum"], values["ni"], self.warnings()), (["diffuse", "shadow"], 7, 1.25, []))

    def test_the_colour_of_what_is_clear_to_shadow_rays_is_told(self):
        self.material()
        self.mixed("Is Shadow Ray", self.node("BsdfGlass"), self.node("BsdfTransparent", Color=(0.5, 0, 0, 1)))
        self.assertEqual(self.found()[0], ["shadow"])
        self.assertEqual(self.warnings(), ["material `Trick`: the colour of its transparent shader is left out"])

    def test_alpha_and_groups_tell_rays_apart_as_well(self):
        self.material()
        group = bpy.data.node_groups.new("Seen", "ShaderNodeTree")
        group.interface.new_socket("Alpha", in_out="OUTPUT", socket_type="NodeSocketFloat")
        within, end, turned = group.nodes.new("ShaderNodeLightPath"), group.nodes.new("NodeGroupOutput"), group.nodes.new("ShaderNodeMath")
        turned.operation, turned.inputs[0].default_value = "SUBTRACT", 1.0
        group.links.new(within.outputs["Is Shadow Ray"], turned.inputs[1])
        group.links.new(turned.outputs[0], end.inputs[0])
        node = self.node("Group")
        node.node_tree = group
        self.tree.links.new(node.outputs[0], self.tree.nodes["Principled BSDF"].inputs["Alpha"])
        hidden, values = self.found()
        self.assertEqual((hidden, "d" in values, self.warnings()), (["shadow"], False, []))

    def test_two_shaders_that_are_seen_are_what_the_camera_sees(self):
        self.material()
        self.mixed("Is Camera Ray", self.node("BsdfDiffuse", Color=(1, 0, 0, 1)), self.node("BsdfDiffuse", Color=(0, 1, 0, 1)))
        hidden, values = self.found()
        self.assertEqual((hidden, values["kd"]), (None, [0, 1, 0]))
        self.assertEqual(self.warnings(), ["material `Trick`: rays of all kinds see what the camera sees (Light Path)"])

    def test_the_light_path_is_that_of_the_camera_wherever_it_is_used(self):
        self.material()
        half = self.node("Math")
        half.operation, half.inputs[1].default_value = "MULTIPLY", 0.5
        self.tree.links.new(self.path.outputs["Is Camera Ray"], half.inputs[0])
        self.tree.links.new(half.outputs[0], self.tree.nodes["Principled BSDF"].inputs["Metallic"])
        self.assertAlmostEqual(self.found()[1]["pm"], 0.5)
        self.assertEqual(self.warnings(), ["material `Trick`: rays of all kinds see what the camera sees (Light Path)"])

    def test_what_a_light_path_does_not_say_here_is_told(self):
        self.material()
        self.tree.links.new(self.path.outputs["Ray Length"], self.tree.nodes["Principled BSDF"].inputs["Metallic"])
        self.assertEqual(self.found()[1]["pm"], 0)
        self.assertEqual(self.warnings(), ["material `Trick`: Ray Length of Light Path is 0"])

    def test_what_is_clear_to_all_rays_stays_clear(self):
        self.material()
        self.mixed("Is Camera Ray", self.node("BsdfTransparent"), self.node("BsdfTransparent"))
        hidden, values = self.found()
        self.assertEqual((hidden, values["d"]), (None, 0))

    def test_an_object_and_its_material_are_hidden_together(self):
        self.material()
        self.mixed("Is Camera Ray", self.node("Emission"), self.node("BsdfTransparent"))
        self.item.visible_shadow = False
        self.assertEqual(self.found()[0], ["camera", "shadow"])
        self.item.visible_diffuse = self.item.visible_glossy = self.item.visible_transmission = False
        self.assertEqual([model["name"] for model in self.export()["model"]], ["nothing"])

    def parted(self):
        """Gives the object two materials: one that is clear to the camera, and one that is not. Its left half has the first."""
        self.item.data = support.grid("Parted", count=2)
        self.material()
        self.mixed("Is Camera Ray", self.node("Emission"), self.node("BsdfTransparent"))
        self.material("Plain")
        for index, polygon in enumerate(self.item.data.polygons):
            polygon.material_index = index % 2

    def test_faces_that_not_the_same_rays_meet_are_models_of_their_own(self):
        self.parted()
        models = self.export()["model"]
        self.assertEqual([(model["name"], model.get("hidden_from")) for model in models], [("Square", ["camera"]), ("Square", None)])
        for model, name, side in zip(models, ("Trick", "Plain"), (-1, 1)):
            header, vertices, faces = read_ply(os.path.join(self.folder, model["ply"]))
            self.assertIn(f"comment material {name}", header)
            self.assertEqual(set(np.sign(vertices["x"][faces["corners"]].mean(axis=1))), {side})

    def test_faces_of_what_deforms_are_models_of_their_own_as_well(self):
        self.scene.frame_end = 2
        self.parted()
        self.item.modifiers.new("Wave", "WAVE").speed = 1
        models = self.export()["model"]
        self.assertEqual([model.get("hidden_from") for model in models], [["camera"], None])
        self.assertEqual(len({model["shapes"]["cache"] for model in models}), 1)
        for model, name in zip(models, ("Trick", "Plain")):
            with open(os.path.join(self.folder, model["obj"]), encoding="ascii") as file:
                self.assertEqual([line.split()[1] for line in file if line.startswith("usemtl")], [name])

    def test_a_holdout_shader_is_a_hole_that_is_black_to_all_others(self):
        self.material()
        self.tree.links.new(self.node("Holdout").outputs[0], self.tree.nodes["Material Output"].inputs["Surface"])
        shot = self.export()
        self.assertTrue(shot["model"][0]["holdout"])
        self.assertEqual((shot["material"][0]["kd"], self.warnings()), ([0, 0, 0], []))

    def test_a_holdout_for_the_camera_alone_is_itself_to_all_others(self):
        self.material()
        self.mixed("Is Camera Ray", self.node("BsdfDiffuse", Color=(1, 0, 0, 1)), self.node("Holdout"))
        shot = self.export()
        self.assertEqual((shot["model"][0]["holdout"], shot["model"][0].get("hidden_from")), (True, None))
        self.assertEqual((shot["material"][0]["kd"], self.warnings()), ([1, 0, 0], []))

    def test_a_holdout_that_is_clear_in_part_or_mixed_is_told(self):
        self.material()
        share = self.node("Value")
        share.outputs[0].default_value = 0.5
        self.mixed(share.outputs[0], self.node("BsdfTransparent"), self.node("Holdout"))
        self.assertTrue(self.export()["model"][0]["holdout"])
        self.assertEqual(self.warnings(), ["material `Trick`: its holdout is a whole one also where it is clear in part"])
        self.mixed(share.outputs[0], self.node("BsdfDiffuse"), self.node("Holdout"))
        self.assertNotIn("holdout", self.export()["model"][0])
        self.assertEqual(self.warnings(), ["material `Trick`: its holdout is black beside other shaders"])


if __name__ == "__main__":
    unittest.main()
