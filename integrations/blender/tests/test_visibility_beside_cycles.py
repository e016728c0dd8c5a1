# SPDX-License-Identifier: GPL-3.0-or-later
"""What only some kinds of rays see, beside Cycles. Needs bpy with Cycles and the renderer's Python module."""

import unittest

import beside_cycles
import bpy
import numpy as np
import support
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector
from test_surfaces import principled

PLACES = {
    "itself": (-1.2, 0, 1.1),
    "floor": (0.2, -0.4, 0),
    "shadow": (-1.2, -1.6, 0),
    "mirror": (1.6, -2.5, 1.0),
    "pane": (-0.16, -5.5, 1.35),
}
"""Points of a stage: of a green subject; of the floor beside it, which it lights; of its shadow; of a mirror and a pane of glass, in which it is seen."""
HALVES = {"left": (-1.6, -0.08, 1.1), "right": (-0.98, 0.04, 1.1)}
"""Points of both halves of the subject."""


class Stage(beside_cycles.BesideCycles):
    """Objects before a camera, and the colours of both pictures at points of them."""

    def setUp(self):
        super().setUp()
        self.places = dict(PLACES)

    def stage(self):
        """The subject, and all ways in which it is seen. Returns its object."""
        scene = self.scene
        scene.afterimage.samples, scene.afterimage.paths, scene.afterimage.reflections = 3, 64, 16
        self.camera = support.add_camera(scene, (0, -8, 1.5), (1.45, 0, 0), lens=45)
        scene.world = bpy.data.worlds.new("World")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.1, 0.2, 1)
        matt = principled("Matt", Base_Color=(0.8, 0.8, 0.8, 1), Specular_IOR_level=0.0, Roughness=1.0)[0]
        silver = principled("Silver", Base_Color=(1, 1, 1, 1), Metallic=1.0, Roughness=0.0)[0]
        glass = principled("Glass", Base_Color=(1, 1, 1, 1), Transmission_Weight=1.0, Roughness=0.0, IOR=1.0001)[0]
        self.square("Floor", 20, matt, (0, 0, 0), (0, 0, 0))
        self.square("Mirror", 1.2, silver, (1.6, -2.5, 1.0), (np.pi / 2, 0, -1.29))
        self.square("Pane", 0.16, glass, (-0.16, -5.5, 1.35), (np.pi / 2, 0, 0)).modifiers.new("Thick", "SOLIDIFY").thickness = 0.01
        support.add(scene, "Sun", self.light("SUN", energy=2, angle=0.0), (0, 0, 9), (-1.0, 0, 0))
        green, _ = principled("Green", Base_Color=(0, 0.5, 0, 1), Specular_IOR_level=0.0, Emission_Color=(0, 1, 0, 1), Emission_Strength=1.5)
        return self.square("Subject", 2.0, green, (-1.2, 0, 1.1), (np.pi / 2, 0, 0.2))

    def square(self, name, size, material, place, turn):
        mesh = support.grid(name, size)
        mesh.materials.append(material)
        return support.add(self.scene, name, mesh, place, turn)

    def colors(self, picture):
        """Mean colours of a few pixels around each place."""
        found, (height, width) = {}, picture.shape[:2]
        for name, place in self.places.items():
            across, up, _ = world_to_camera_view(self.scene, self.camera, Vector(place))
            row, column = round((1 - up) * height), round(across * width)
            found[name] = picture[row - 2 : row + 2, column - 2 : column + 2].mean(axis=(0, 1))
        return found

    def alike(self, samples=64):
        """Renders both, which must be alike in all places. Returns the colours of Cycles."""
        ours, cycles = map(self.colors, self.both(samples))
        for name, color in cycles.items():
            np.testing.assert_allclose(ours[name], color, rtol=0.06, atol=0.02, err_msg=name)
        return cycles

    def clear_to(self, output, item, shader=None):
        """Makes the surface of an object clear to the rays of an output of Light Path. `shader`: another one for them."""
        tree = item.data.materials[0].node_tree
        mix, path = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("MixShader", "LightPath"))
        end = tree.nodes["Material Output"].inputs["Surface"]
        ends = (path.outputs[output], end.links[0].from_socket, (shader or tree.nodes.new("ShaderNodeBsdfTransparent")).outputs[0])
        for source, socket in zip(ends, mix.inputs):
            tree.links.new(source, socket)
        tree.links.new(mix.outputs[0], end)

    def assert_changes(self, before, after, names):
        """The colours of these places alone have changed, of those that can tell."""
        changed = {name for name in PLACES if np.abs(before[name] - after[name]).max() > 0.05}
        self.assertEqual(changed, names)


class VisibilityBesideCycles(Stage):
    KINDS = (("camera", {"itself"}), ("diffuse", {"floor", "shadow"}), ("glossy", {"mirror"}), ("transmission", {"pane"}), ("shadow", {"shadow"}))
    """Of rays, and the places that look otherwise where these do not meet the subject."""

    def test_rays_of_one_kind_do_not_meet_what_is_hidden_from_them(self):
        subject = self.stage()
        before = self.alike()
        for kind, places in self.KINDS:
            with self.subTest(kind):
                for each, _ in self.KINDS:
                    setattr(subject, f"visible_{each}", each != kind)
                self.assert_changes(before, self.alike(), places)

    def test_rays_do_not_meet_instances_that_are_hidden_from_them(self):
        subject = self.stage()
        before = self.alike()
        collection = bpy.data.collections.new("Subjects")
        collection.objects.link(subject)
        self.scene.collection.objects.unlink(subject)
        copy = support.add(self.scene, "Copy", None)
        copy.instance_type, copy.instance_collection = "COLLECTION", collection
        subject.visible_shadow = copy.visible_camera = False
        self.assert_changes(before, self.alike(), {"itself", "shadow"})

    def test_a_collection_for_indirect_rays_alone_is_not_before_the_camera(self):
        subject = self.stage()
        before = self.alike()
        collection = bpy.data.collections.new("Indirect")
        self.scene.collection.children.link(collection)
        collection.objects.link(subject)
        self.scene.collection.objects.unlink(subject)
        self.scene.view_layers[0].layer_collection.children["Indirect"].indirect_only = True
        self.assert_changes(before, self.alike(), {"itself"})

    def test_rays_do_not_meet_materials_that_are_clear_to_them(self):
        # what lights the floor is what shines without a ray, so that no diffuse ray counts
        places_of = {"Is Camera Ray": {"itself"}, "Is Glossy Ray": {"mirror", "pane"}, "Is Transmission Ray": {"pane"}, "Is Shadow Ray": {"shadow"}}
        for output, places in places_of.items():
            with self.subTest(output):
                self.scene = support.empty()
                subject = self.stage()
                before = self.alike()
                self.clear_to(output, subject)
                self.assert_changes(before, self.alike(), places)
                self.assertEqual(self.exported.warnings, [])

    def test_faces_that_are_clear_to_the_camera_are_beside_others(self):
        subject = self.stage()
        before = self.alike()
        mesh = support.grid("Parted", 2.0, 2)
        for material in (subject.data.materials[0], subject.data.materials[0].copy()):
            mesh.materials.append(material)
        for index, polygon in enumerate(mesh.polygons):
            polygon.material_index = (index + 1) % 2
        subject.data = mesh
        self.clear_to("Is Camera Ray", subject)
        self.places.update(HALVES)
        after = self.alike()
        self.assertEqual([after[name][1] > 1 for name in HALVES], [True, False])
        self.assertGreater(before["itself"][1], 1)

    def test_a_mesh_lamp_that_the_camera_does_not_see_shines_as_in_cycles(self):
        for hide in ("object", "material", "both"):
            with self.subTest(hide):
                self.scene = support.empty()
                subject = self.stage()
                subject.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 20
                bpy.data.objects["Sun"].data.energy = 0
                if hide != "material":
                    subject.visible_camera = False
                if hide != "object":
                    self.clear_to("Is Camera Ray", subject)
                found = self.alike(256)
                self.assertGreater(found["floor"][1], 1)
                self.assertLess(found["itself"][1], 2)

    def test_a_holdout_is_a_hole_to_the_camera_and_itself_to_others(self):
        for transparent in (False, True):
            with self.subTest(transparent=transparent):
                self.scene = support.empty()
                self.scene.render.film_transparent = transparent
                subject = self.stage()
                before = self.alike()
                subject.is_holdout = True
                after = self.alike()
                self.assert_changes(before, after, {"itself"})
                self.assertEqual(after["itself"].tolist(), [0, 0, 0, 0])

    def test_a_holdout_that_is_cut_out_is_a_hole_where_it_is(self):
        subject = self.stage()
        subject.is_holdout = True
        subject.data.uv_layers.new().data.foreach_set("uv", np.array([0, 0, 1, 0, 1, 1, 0, 1], dtype=np.float32))
        tree = subject.data.materials[0].node_tree
        source = tree.nodes.new("ShaderNodeTexImage")
        source.image, source.interpolation = bpy.data.images.new("Right", 16, 16), "Closest"
        source.image.colorspace_settings.name = "Non-Color"
        pixels = np.ones((16, 16, 4), dtype=np.float32)
        pixels[:, :8, :3] = 0
        source.image.pixels.foreach_set(pixels.ravel())
        tree.links.new(source.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Alpha"])
        # its edge lies in the mirror as well, where pixels are of both halves
        del self.places["mirror"]
        self.places.update(HALVES)
        found = self.alike()
        np.testing.assert_allclose([found[name] for name in HALVES], [[0.1, 0.1, 0.2, 1], [0, 0, 0, 0]], atol=1e-3)

    def test_glass_that_is_clear_to_shadow_rays_casts_none_with_caustics_either(self):
        for caustics in (False, True):
            with self.subTest(caustics=caustics):
                self.scene = support.empty()
                self.scene.afterimage.caustics = caustics
                subject = self.stage()
                subject.data.materials[0] = principled("Clear", Transmission_Weight=1.0, Roughness=0.0, IOR=1.0001, Base_Color=(1, 1, 1, 1))[0]
                self.clear_to("Is Shadow Ray", subject)
                found = self.alike()
                self.assertGreater(found["shadow"][0], 0.3)

    def test_a_holdout_shader_is_a_hole_to_the_camera_and_black_to_others(self):
        subject = self.stage()
        self.scene.render.film_transparent = True
        tree = subject.data.materials[0].node_tree
        tree.links.new(tree.nodes.new("ShaderNodeHoldout").outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        found = self.alike()
        self.assertEqual([found["itself"].tolist(), found["mirror"].round(3).tolist()], [[0, 0, 0, 0], [0, 0, 0, 1]])

    def test_a_holdout_shader_for_the_camera_alone_is_itself_to_others(self):
        subject = self.stage()
        before = self.alike()
        holdout = subject.data.materials[0].node_tree.nodes.new("ShaderNodeHoldout")
        self.clear_to("Is Camera Ray", subject, holdout)
        self.assert_changes(before, self.alike(), {"itself"})

CATCHER = {
    "cube": (0.0, -0.5, 0.5),
    "foot": (0.95, -0.1, 0),
    "shadow": (1.3, 0.3, 0),
    "rim": (1.75, 0.1, 0),
    "lit": (-1.6, -1.4, 0),
    "sky": (0.0, 0.0, 3.2),
}
"""Points of a cube; of its shadow beside it, in its middle and at its soft rim; of a floor that is lit; of what is behind the picture."""


class CatchersBesideCycles(Stage):
    """A cube on a catcher of shadows, in a picture whose background is transparent."""

    def ground(self, transparent=True):
        """A floor that catches shadows, and a cube on it. Returns both objects."""
        scene = self.scene
        self.places = dict(CATCHER)
        scene.render.film_transparent = transparent
        scene.afterimage.samples, scene.afterimage.paths, scene.afterimage.shadow_rays = 3, 64, "16"
        self.camera = support.add_camera(scene, (0, -8, 2.5), (1.36, 0, 0), lens=35)
        matt = principled("Matt", Base_Color=(0.8, 0.8, 0.8, 1), Specular_IOR_level=0.0, Roughness=1.0)[0]
        red = principled("Red", Base_Color=(0.7, 0.2, 0.1, 1), Specular_IOR_level=0.0, Roughness=1.0)[0]
        floor = self.square("Floor", 30, matt, (0, 0, 0), (0, 0, 0))
        floor.is_shadow_catcher = True
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.5), rotation=(0, 0, 0.15))
        cube = bpy.context.object
        cube.data.materials.append(red)
        return floor, cube

    def sun(self):
        support.add(self.scene, "Sun", self.light("SUN", energy=3, angle=0.25), (0, 0, 9), (0.0, -0.85, 0.1))

    def panel(self):
        support.add(self.scene, "Panel", self.light("AREA", energy=300, size=1.5), (-3.0, -0.5, 3.5), (0.12, -0.75, 0))

    def sky(self, *color):
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*color, 1)

    def assert_caught(self, found, name="shadow"):
        """The floor is clear where it is lit, and black where it is not; the cube is there."""
        self.assertLess(found["lit"][3], 0.1)
        self.assertGreater(found[name][3], found["lit"][3] + 0.08)
        self.assertLess(found[name][:3].max(), 0.02)
        np.testing.assert_allclose([found["cube"][3], found["sky"][3]], [1, 0], atol=1e-6)

    def test_shadows_of_a_sun_are_caught(self):
        self.ground()
        self.sun()
        found = self.alike(256)
        self.assert_caught(found)
        self.assertEqual(self.exported.warnings, [])

    def test_shadows_of_a_panel_are_caught(self):
        self.ground()
        self.panel()
        self.assert_caught(self.alike(256))

    def test_shadows_of_a_sky_are_caught(self):
        self.ground()
        self.sky(0.3, 0.5, 0.8)
        self.assert_caught(self.alike(512), "foot")

    def test_shadows_of_both_lamps_and_a_sky_are_caught(self):
        self.ground()
        self.sun(), self.panel(), self.sky(0.2, 0.2, 0.3)
        self.assert_caught(self.alike(512), "foot")

    def test_a_visible_background_is_dimmed_where_shadows_are_caught(self):
        self.ground(transparent=False)
        self.sun(), self.sky(0.3, 0.4, 0.6)
        found = self.alike(256)
        self.assertLess(found["shadow"][2], 0.8 * found["sky"][2])
        self.assertEqual(found["shadow"][3], 1)

    def test_a_hole_casts_a_shadow_that_is_caught(self):
        _, cube = self.ground()
        self.sun()
        cube.is_holdout = True
        found = self.alike(256)
        self.assertEqual(found["cube"].tolist(), [0, 0, 0, 0])
        self.assertGreater(found["shadow"][3], 0.3)

    def test_a_hole_in_a_transparent_picture_hides_what_is_behind_it(self):
        _, cube = self.ground()
        self.panel()
        bpy.data.objects["Floor"].is_shadow_catcher = False
        cube.is_holdout = True
        found = self.alike(256)
        self.assertEqual(found["cube"].tolist(), [0, 0, 0, 0])
        self.assertEqual([found["lit"][3], found["sky"][3]], [1, 0])

    def test_a_veil_before_a_hole_shows_itself_alone(self):
        _, cube = self.ground()
        self.panel()
        bpy.data.objects["Floor"].is_shadow_catcher = False
        cube.is_holdout = True
        veil = principled("Veil", Base_Color=(0.1, 0.2, 0.7, 1), Specular_IOR_level=0.0, Roughness=1.0, Alpha=0.5)[0]
        self.square("Veil", 1.2, veil, (0, -2.0, 1.0), (np.pi / 2 - 0.3, 0, 0))
        found = self.alike(512)
        np.testing.assert_allclose(found["cube"][3], 0.5, atol=0.01)


class ClippingBesideCycles(Stage):
    """What the clipping planes of a camera cut off."""

    def stand(self):
        """Three squares behind each other before the camera, at depths of 2, 5 and 9, on a floor, with a mirror that sees the first. Returns the camera."""
        scene = self.scene
        scene.afterimage.samples, scene.afterimage.paths, scene.afterimage.reflections = 3, 64, 16
        camera = self.camera = support.add_camera(scene, (0, -8, 1.5), (np.pi / 2, 0, 0), lens=35)
        scene.world = bpy.data.worlds.new("World")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.5, 1)
        colors = {"Near": (0.8, 0.1, 0.1, 1), "Middle": (0.1, 0.8, 0.1, 1), "Far": (0.8, 0.8, 0.1, 1), "Floor": (0.8, 0.8, 0.8, 1)}
        matts = {name: principled(name, Base_Color=color, Specular_IOR_level=0.0, Roughness=1.0)[0] for name, color in colors.items()}
        upright = (np.pi / 2, 0, 0)
        self.square("Near", 0.7, matts["Near"], (-0.45, -6, 1.0), upright)
        self.square("Middle", 1.4, matts["Middle"], (0.9, -3, 1.4), upright)
        self.square("Far", 3.0, matts["Far"], (-1.5, 1, 1.5), upright)
        self.square("Floor", 30, matts["Floor"], (0, 0, 0), (0, 0, 0))
        support.add(scene, "Sun", self.light("SUN", energy=2, angle=0.0), (0, 0, 9), (1.2, 0.2, 0))
        self.places = {
            "near": (-0.45, -6, 1.2),
            "middle": (0.9, -3, 1.4),
            "far": (-2.4, 1, 2.4),
            "floor": (0.6, -3.5, 0),
            "far floor": (3.5, 1.5, 0),
            "shadow": (-0.65, -3.37, 0),
        }
        return camera

    def changed(self, before, after):
        """Names of the places whose colours have changed."""
        return {name for name in self.places if np.abs(before[name] - after[name]).max() > 0.03}

    def test_nothing_before_the_clip_start_is_seen_but_its_shadow(self):
        camera = self.stand()
        before = self.alike()
        camera.data.clip_start = 2.5
        after = self.alike()
        # it hid its own shadow
        self.assertEqual(self.changed(before, after), {"near", "shadow"})
        self.assertLess(after["shadow"][0], 0.8 * after["floor"][0])

    def test_nothing_behind_the_clip_end_is_seen(self):
        camera = self.stand()
        before = self.alike()
        camera.data.clip_end = 7
        after = self.alike()
        self.assertEqual(self.changed(before, after), {"far", "far floor"})
        np.testing.assert_allclose(after["far"][:3], [0.2, 0.3, 0.5], atol=0.01)

    def test_what_is_cut_off_is_clear_in_a_transparent_picture(self):
        camera = self.stand()
        self.scene.render.film_transparent = True
        camera.data.clip_start, camera.data.clip_end = 2.5, 7
        found = self.alike()
        self.assertEqual([found[name][3] for name in ("near", "middle", "far", "far floor")], [0, 1, 0, 0])

    def test_clipping_is_along_the_view_axis_to_the_corners_of_the_picture(self):
        # a wall at right angles to the axis is there whole or not at all
        camera = self.stand()
        self.scene.render.film_transparent = True
        for name in ("Near", "Middle", "Far", "Floor"):
            bpy.data.objects.remove(bpy.data.objects[name])
        wall = principled("Wall", Base_Color=(0.5, 0.5, 0.5, 1), Specular_IOR_level=0.0, Roughness=1.0)[0]
        self.square("Wall", 30, wall, (0, -3, 1.5), (np.pi / 2, 0, 0))
        camera.data.lens = 18
        for end, alpha in ((5.05, 1), (4.95, 0)):
            camera.data.clip_end = end
            ours, cycles = self.both(16)
            self.assertEqual([ours[:, :, 3].min(), ours[:, :, 3].max(), cycles[:, :, 3].min(), cycles[:, :, 3].max()], [alpha] * 4)

    def test_an_orthographic_camera_has_clipping_distances_as_well(self):
        camera = self.stand()
        camera.data.type, camera.data.ortho_scale = "ORTHO", 6
        camera.data.clip_start, camera.data.clip_end = 2.5, 7
        self.places = {name: self.places[name] for name in ("near", "middle", "far")}
        self.alike()


if __name__ == "__main__":
    unittest.main()
