# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of materials, colour attributes, and lights. Needs bpy; the renderer is not asked."""

import os
import unittest

import bpy
import numpy as np
import support


def principled(name, **inputs):
    """A material of one Principled BSDF, and that node."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ").replace("IOR level", "IOR Level")].default_value = value
    return material, node


def painted(name, attribute, kind="ShaderNodeVertexColor"):
    """A material whose base colour is a colour attribute."""
    material, node = principled(name)
    source = material.node_tree.nodes.new(kind)
    setattr(source, "layer_name" if kind == "ShaderNodeVertexColor" else "attribute_name", attribute)
    material.node_tree.links.new(source.outputs["Color"], node.inputs["Base Color"])
    return material


def edge_of_rough(tree, toward, head_on):
    """What groups for rough dielectrics mix by: Fresnel of a normal that is so far turned towards the eye, from a share on."""
    group = bpy.data.node_groups.new("Rough Fresnel", "ShaderNodeTree")
    group.interface.new_socket("Toward", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket("Factor", in_out="OUTPUT", socket_type="NodeSocketFloat")
    inside = support.Tree(group)
    begin, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    normal, eye = inside.add("Bump", {"Height": 1.0}).outputs[0], inside.add("NewGeometry").outputs["Incoming"]
    mixed = inside.add("Mix", {0: begin.outputs[0], 6: normal, 7: eye}, data_type="RGBA").outputs[2]
    group.links.new(inside.add("Fresnel", {"IOR": 1.45, "Normal": mixed}).outputs[0], end.inputs[0])
    outer = tree.add("Group", {}, node_tree=group)
    outer.inputs[0].default_value = toward
    return tree.add("Mix", {0: outer.outputs[0], 6: (head_on, head_on, head_on, 1), 7: (1, 1, 1, 1)}, data_type="RGBA").outputs[2]


def read_ply(path):
    """Header, vertices and faces of a PLY that the export wrote."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode().splitlines()
    names = [line.split()[2] for line in header if line.startswith("property float")]
    count, faces = (int(line.split()[2]) for line in header if line.startswith("element"))
    vertices = np.frombuffer(data, dtype=[(name, "<f4") for name in names], count=count, offset=end)
    fields = [("count", "u1"), ("corners", "<i4", 3)] + ([("material", "<i4")] if "property int material_index" in header else [])
    return header, vertices, np.frombuffer(data, dtype=fields, count=faces, offset=end + vertices.nbytes)


class Surfaces(support.ExportCase):
    def setUp(self):
        super().setUp()
        support.add_camera(self.scene)

    def exported(self, *materials, count=1):
        """Exports a square of these materials, in turn, and returns the shot."""
        mesh = support.grid(count=count)
        for index, material in enumerate(materials):
            mesh.materials.append(material)
        for index, polygon in enumerate(mesh.polygons):
            polygon.material_index = index % len(materials)
        support.add(self.scene, "Square", mesh)
        return self.export()

    def ply(self, shot):
        return read_ply(os.path.join(self.folder, shot["model"][0]["ply"]))

    def test_a_huge_picture_is_made_smaller_before_it_is_worked_on(self):
        images = support.extension().export.images
        image = bpy.data.images.new("Wide", 64, 16)
        texels = np.zeros((16, 64, 4), dtype=np.float32)
        texels[:, :, 0], texels[:, :, 1], texels[:, :, 3] = np.arange(64) / 63, (np.arange(16) / 15)[:, None], 1
        image.pixels.foreach_set(texels.ravel())
        picture = images.pictures.Picture(image.name_full, image)
        whole = images.Images(self.folder, support.extension().export.warnings.Warnings()).pixels(picture)
        warnings = support.extension().export.warnings.Warnings()
        largest, images.LARGEST = images.LARGEST, 16
        try:
            smaller = images.Images(self.folder, warnings).pixels(picture)
        finally:
            images.LARGEST = largest
        np.testing.assert_array_equal(smaller, whole[::4, ::4])
        self.assertIsNone(smaller.base, "the whole picture is kept")
        self.assertEqual(list(warnings), ["image `Wide`: 64x16 is made smaller where nodes change it"])

    def test_glass_has_the_tint_and_the_share_that_it_lets_through(self):
        clear, _ = principled("Clear", Transmission_Weight=1.0, Base_Color=(0.25, 1, 0.64, 1), Roughness=0.0, IOR=1.4)
        values = self.exported(clear)["material"][0]
        self.assertEqual((values["illum"], values["kd"]), (7, [0, 0, 0]))
        np.testing.assert_allclose(values["tf"], [0.5, 1, 0.8], atol=1e-6)
        np.testing.assert_allclose(values["ni"], 1.4, atol=1e-6)
        self.assertEqual(self.warnings(), [])

    def test_what_glass_does_not_let_through_it_scatters(self):
        half, _ = principled("Half", Transmission_Weight=0.5, Base_Color=(0.64, 0.64, 0.64, 1), Roughness=0.0)
        values = self.exported(half)["material"][0]
        np.testing.assert_allclose(values["tf"], [0.4] * 3, atol=1e-6)
        # the renderer scatters kd of the share that the filter keeps back, here 0.6: Blender's half of 0.64
        np.testing.assert_allclose(np.array(values["kd"]) * 0.6, [0.32] * 3, atol=1e-6)

    def test_a_value_at_nan_is_told_by_the_name_of_its_material(self):
        values = self.exported(principled("Odd", Roughness=float("nan"))[0])["material"][0]
        self.assertEqual((values["pr"], len(self.warnings())), (0, 1))
        self.assertRegex(self.warnings()[0], "material `Odd`: its values that are not numbers")

    def displaced(self, method, height):
        """The MaterialX file of a square whose material displaces; None without one. `height` gives the socket or number of its heights."""
        for item in [item for item in self.scene.objects if item.type == "MESH"]:
            bpy.data.objects.remove(item)
        material, _ = principled("Stone")
        tree = support.Tree(material)
        node = tree.add("Displacement", {"Height": height(tree), "Midlevel": 0.25, "Scale": 0.5})
        tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Displacement"])
        material.displacement_method = method
        shot = self.exported(material)
        self.assertEqual(self.warnings(), [])
        if "mtlx" not in shot["material"][0]:
            return None
        with open(os.path.join(self.folder, shot["material"][0]["mtlx"]), encoding="utf-8") as file:
            return file.read()

    def test_displacement_moves_vertices_where_the_material_says_so(self):
        noise = lambda tree: tree.add("TexNoise").outputs[0]  # noqa: E731
        for method, moves, bends in (("BUMP", False, True), ("DISPLACEMENT", True, False), ("BOTH", True, True)):
            with self.subTest(method=method):
                file = self.displaced(method, noise)
                self.assertEqual(("<blender_displacement" in file, "<blender_bump" in file), (moves, bends))
                if moves:
                    self.assertIn('<input name="scale" type="float" value="0.5"/>', file)
                    self.assertIn('<input name="midlevel" type="float" value="0.25"/>', file)
                    self.assertIn('name="displacementshader"', file)
        self.assertIsNone(self.displaced("BUMP", lambda _: 0.75), "even heights bend nothing")
        self.assertIn('<input name="displacement" type="float" value="0.75"/>', self.displaced("DISPLACEMENT", lambda _: 0.75))

    def test_rough_glass_is_as_rough(self):
        rough, _ = principled("Rough", Transmission_Weight=1.0, Roughness=0.4)
        values = self.exported(rough)["material"][0]
        self.assertEqual((values["illum"], self.warnings()), (7, []))
        self.assertAlmostEqual(values["pr"], 0.4, places=6)

    def test_glass_has_the_pictures_of_its_normals(self):
        wavy, node = principled("Wavy", Transmission_Weight=1.0, Roughness=0.0)
        image = bpy.data.images.new("Waves", 8, 8)
        image.pixels.foreach_set(np.linspace(0, 1, 256).astype(np.float32))
        nodes, links = wavy.node_tree.nodes, wavy.node_tree.links
        source, bump = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeBump")
        source.image = image
        links.new(source.outputs["Color"], bump.inputs["Height"])
        links.new(bump.outputs["Normal"], node.inputs["Normal"])
        values = self.exported(wavy)["material"][0]
        self.assertEqual((values["illum"], "norm" in values), (7, True))

    def test_coats_are_above_plastic_and_metal(self):
        tint = (0.9, 0.5, 0.2)
        coated, _ = principled("Coated", Coat_Weight=1.0, Coat_Roughness=0.1, Coat_IOR=1.6, Coat_Tint=(*tint, 1), IOR=1.5, Roughness=0.6)
        metal, _ = principled("Metal", Coat_Weight=0.5, Metallic=1.0, Roughness=0.6)
        shot = self.exported(coated, metal, count=2)
        one, other = ({entry["name"]: entry for entry in shot["material"]}[name] for name in ("Coated", "Metal"))
        np.testing.assert_allclose([one[key] for key in ("pr", "ni", "coat", "coat_roughness", "coat_ni")], [0.6, 1.5, 1, 0.1, 1.6], atol=1e-4)
        np.testing.assert_allclose(one["coat_color"], tint, atol=1e-6)
        np.testing.assert_allclose([other["pr"], other["pm"], other["coat"], other["coat_ni"]], [0.6, 1, 0.5, 1.5], atol=1e-6)
        self.assertNotIn("coat_color", other)
        self.assertEqual(self.warnings(), [])

    def mixed(self, name, factor):
        """A material of a rougher metal and a smoother one, mixed by what a function makes for its tree."""
        material, node = principled(name, Metallic=1.0, Base_Color=(0.8, 0.1, 0.05, 1), Roughness=0.5)
        tree = support.Tree(material)
        mirror = tree.add("BsdfGlossy", {"Color": (0.5, 0.5, 0.5, 1), "Roughness": 0.1})
        mix = tree.add("MixShader", {0: factor(tree), 1: node.outputs[0], 2: mirror.outputs[0]})
        tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        return material

    def test_a_mirror_on_metal_by_the_angle_is_a_clear_coat(self):
        paint = self.mixed("Paint", lambda tree: tree.add("Fresnel", {"IOR": 1.6}).outputs[0])
        # by what is 0 head-on the colours are mixed instead
        rim = self.mixed("Rim", lambda tree: tree.add("LayerWeight", {"Blend": 0.5}).outputs["Facing"])
        # and where the weight depends on the place as well
        worn = self.mixed("Worn", lambda tree: tree.add("Math", {0: tree.add("Fresnel").outputs[0], 1: tree.add("TexNoise").outputs[0]}, operation="MULTIPLY").outputs[0])
        values = {entry["name"]: entry for entry in self.exported(paint, rim, worn, count=2)["material"]}
        keys = ("pm", "pr", "coat", "coat_roughness", "coat_ni", "coat_darkening")
        np.testing.assert_allclose([values["Paint"][key] for key in keys], [1, 0.5, 0.5, 0.1, 1.6, 0], atol=0.01)
        np.testing.assert_allclose(values["Paint"]["kd"], [0.8, 0.1, 0.05], atol=1e-6)
        self.assertFalse([name for name in ("Rim", "Worn") if "coat" in values[name]])
        self.assertEqual(self.warnings(), [])

    def test_normals_that_are_turned_towards_the_eye_take_part_in_graphs(self):
        def shade(name, normal):
            material, node = principled(name)
            tree = support.Tree(material)
            mixed = tree.add("Mix", {0: 0.25, 4: normal(tree), 5: tree.add("NewGeometry").outputs["Incoming"]}, data_type="VECTOR").outputs[1]
            tree.links.new(tree.add("LayerWeight", {"Normal": mixed}).outputs["Facing"], node.inputs["Base Color"])
            return material

        bent = shade("Turned", lambda tree: tree.add("NewGeometry").outputs["Normal"])
        other = shade("Other", lambda tree: tree.add("TexCoord").outputs["Object"])
        self.exported(bent, other, count=2)
        with open(os.path.join(self.folder, "materials.mtlx"), encoding="utf-8") as file:
            graphs = file.read().split("<surfacematerial")
        self.assertEqual(["toward" in graph for graph in graphs[:2]], [True, False])
        self.assertIn('<input name="toward" type="float" value="0.25"/>', graphs[0])

    def test_outputs_that_the_renderer_does_not_know_are_told_once_by_name(self):
        outputs = (
            ("NewGeometry", "Parametric", "Parametric of node `Geometry` (Geometry)", 0.5),
            ("NewGeometry", "Backfacing", "Backfacing of node `Geometry` (Geometry)", 0.0),
            ("Wireframe", 0, "node `Wireframe` (Wireframe)", 0.0),
            ("AmbientOcclusion", "AO", "AO of node `Ambient Occlusion` (Ambient Occlusion)", 1.0),
            ("TexCoord", "Window", "Window of node `Texture Coordinate` (Texture Coordinate)", 0.5),
            ("ShaderToRGB", "Color", "Color of node `Shader to RGB` (Shader to RGB)", 0.5),
        )
        for kind, name, told, value in outputs:
            with self.subTest(kind, output=name):
                self.scene = support.empty()
                support.add_camera(self.scene)
                material, node = principled("Odd")
                tree = support.Tree(material)
                output = tree.add(kind).outputs[name]
                for taken in ("Base Color", "Roughness"):
                    tree.links.new(output, node.inputs[taken])
                values = self.exported(material)["material"][0]
                np.testing.assert_allclose([*values["kd"], values["pr"]], [value] * 4, atol=1e-6)
                self.assertEqual(self.warnings(), [f"material `Odd`: {told} is replaced by a constant"])

    def test_a_mesh_of_several_materials_is_one_model(self):
        red, _ = principled("Red", Base_Color=(1, 0, 0, 1))
        blue, _ = principled("Blue", Base_Color=(0, 0, 1, 1))
        shot = self.exported(red, blue, count=2)
        self.assertEqual([model["name"] for model in shot["model"]], ["Square"])
        header, vertices, faces = self.ply(shot)
        named = [line.removeprefix("comment material ") for line in header if line.startswith("comment material")]
        self.assertEqual(named, ["Red", "Blue"])
        # quads 0 and 2 of the four are red: they lie at the left
        middle = vertices["x"][faces["corners"]].mean(axis=1)
        self.assertEqual({name: set(np.sign(middle[faces["material"] == index])) for index, name in enumerate(named)}, {"Red": {-1}, "Blue": {1}})

    def test_colours_of_vertices_and_corners_are_the_base_colour(self):
        for kind, domain in (("FLOAT_COLOR", "POINT"), ("BYTE_COLOR", "CORNER")):
            with self.subTest(kind=kind, domain=domain):
                self.scene = support.empty()
                support.add_camera(self.scene)
                mesh = support.grid(count=2)
                attribute = mesh.color_attributes.new("Paint", kind, domain)
                values = np.zeros((len(attribute.data), 4), dtype=np.float32)
                values[:, 0] = np.linspace(0, 1, len(values))
                values[:, 3] = 1
                attribute.data.foreach_set("color", values.ravel())
                mesh.materials.append(painted("Painted", "Paint"))
                support.add(self.scene, "Square", mesh)
                shot = self.export()
                self.assertEqual(shot["material"][0]["kd"], [1, 1, 1])
                _, vertices, faces = self.ply(shot)
                self.assertEqual(float(vertices["green"].max()), 0)
                if domain == "POINT":
                    order = np.lexsort((vertices["x"], vertices["y"]))
                    np.testing.assert_allclose(vertices["red"][order], values[:, 0], atol=1e-6)
                else:
                    np.testing.assert_allclose(np.unique(vertices["red"]), values[:, 0], atol=0.01)

    def test_nodes_change_colours_of_vertices(self):
        material = painted("Inverted", "", "ShaderNodeVertexColor")
        tree = material.node_tree
        node, source = tree.nodes["Principled BSDF"], next(entry for entry in tree.nodes if entry.type == "VERTEX_COLOR")
        invert = tree.nodes.new("ShaderNodeInvert")
        tree.links.new(source.outputs["Color"], invert.inputs["Color"])
        tree.links.new(invert.outputs[0], node.inputs["Base Color"])
        tree.links.new(source.outputs["Color"], node.inputs["Roughness"])
        mesh = support.grid()
        attribute = mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
        attribute.data.foreach_set("color", [0.25, 0.5, 1, 1] * 4)
        mesh.materials.append(material)
        support.add(self.scene, "Square", mesh)
        _, vertices, _ = self.ply(self.export())
        np.testing.assert_allclose([vertices["red"], vertices["green"], vertices["blue"]], [[0.75] * 4, [0.5] * 4, [0] * 4], atol=1e-6)
        self.assertEqual(self.warnings(), ["material `Inverted`: colour attributes count for its base colour alone"])

    def test_a_mesh_without_the_attribute_is_told(self):
        shot = self.exported(painted("Painted", "Nowhere", "ShaderNodeAttribute"))
        _, vertices, _ = self.ply(shot)
        self.assertEqual(float(vertices["red"].max()), 0)
        self.assertIn("no colour attribute `Nowhere`", "\n".join(self.warnings()))

    def test_what_deforms_keeps_colours_of_its_vertices(self):
        self.scene.frame_end = 2
        mesh = support.grid()
        attribute = mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
        attribute.data.foreach_set("color", [0.5, 0, 0, 1] * 4)
        mesh.materials.append(painted("Painted", "Paint"))
        item = support.add(self.scene, "Flag", mesh)
        item.shape_key_add(name="Basis")
        key = item.shape_key_add(name="Up")
        key.data[0].co.z = 1.0
        for frame in (1, 2):
            key.value = frame - 1
            key.keyframe_insert("value", frame=frame)
        model = self.export()["model"][0]
        with open(os.path.join(self.folder, model["obj"]), encoding="utf-8") as file:
            lines = [line.split() for line in file if line.startswith("v ")]
        # OBJ has colours as screens show them
        np.testing.assert_allclose([[float(part) for part in line[4:]] for line in lines], [[0.7354, 0, 0]] * 4, atol=1e-3)

    def area(self, turn, **values):
        data = bpy.data.lights.new("Panel", "AREA")
        for key, value in values.items():
            setattr(data, key, value)
        support.add(self.scene, "Floor", support.grid())
        support.add(self.scene, "Panel", data, (0, 0, 2), turn)
        return self.export()["light"][0]

    def test_a_rectangle_keeps_the_turn_about_its_axis(self):
        light = self.area((0, 0, np.pi / 6), shape="RECTANGLE", size=2, size_y=0.5)
        np.testing.assert_allclose(light["size"], [2, 0.5], atol=1e-6)
        # Blender's Y, turned to the left, which is -Z of the shot
        np.testing.assert_allclose(light["up"], [-0.5, 0, -np.sqrt(0.75)], atol=1e-6)
        self.assertEqual(self.warnings(), [])

    def test_an_ellipse_and_its_spread(self):
        light = self.area((0, 0, 0), shape="ELLIPSE", size=2, size_y=0.5, spread=1.0)
        self.assertEqual((light["type"], light["size"], self.warnings()), ("disk", [2, 0.5], []))
        self.assertAlmostEqual(light["spread"], np.degrees(1.0), places=4)

    def test_the_warning_of_a_light_names_it(self):
        light = self.area((0, 0, 0), spread=0.001)
        self.assertAlmostEqual(light["spread"], 1.0, places=9)
        self.assertEqual(len(self.warnings()), 1)
        self.assertRegex(self.warnings()[0], "^area light `Panel`: its spread is below a degree")

    def test_a_spot_has_its_radius(self):
        data = bpy.data.lights.new("Spot", "SPOT")
        data.shadow_soft_size = 0.5
        support.add(self.scene, "Floor", support.grid())
        support.add(self.scene, "Spot", data, (0, 0, 2))
        light = self.export()["light"][0]
        self.assertEqual((light["type"], light["radius"], self.warnings()), ("spot", 0.5, []))

    def test_the_softness_of_spots_is_that_of_the_shot_whatever_their_cone(self):
        data = bpy.data.lights.new("Spot", "SPOT")
        lights = support.extension().export.lights
        for degrees in range(1, 181):
            data.spot_size = np.radians(degrees)
            for blend, least, most in ((0.0, 0.0, 1e-9), (0.5, 0.2, 0.4), (1.0, 1.0, 1.0)):
                data.spot_blend = blend
                soft = lights.spot(data, None, 4, lambda message: None)[0]["soft"]
                self.assertTrue(least <= soft <= most, (degrees, blend, soft))

    def test_values_beyond_the_ranges_of_shots_are_brought_into_them(self):
        data = bpy.data.lights.new("Sun", "SUN")
        data.angle = np.pi
        support.add(self.scene, "Sun", data)
        shot = self.exported(principled("Glass", Transmission_Weight=1.0, IOR=1000.0)[0])
        self.assertLess(shot["light"][0]["angle"], 180)
        self.assertEqual(shot["material"][0]["ni"], 100)

    def test_copies_of_a_light_in_several_sizes_are_at_rest(self):
        self.scene.frame_end = 2
        collection = bpy.data.collections.new("Lamps")
        collection.objects.link(bpy.data.objects.new("Panel", bpy.data.lights.new("Panel", "AREA")))
        for index in range(2):
            copy = support.add(self.scene, f"Copy {index}", None)
            copy.instance_type, copy.instance_collection, copy.scale = "COLLECTION", collection, (1 + index,) * 3
        self.assertEqual(sorted(light["size"][0] for light in self.export()["light"]), [0.25, 0.5])
        self.assertEqual([line for line in self.warnings() if "Panel" in line], [])

    def smoke(self):
        """A material with a volume and no surface."""
        material, node = principled("Smoke")
        volume = material.node_tree.nodes.new("ShaderNodeVolumePrincipled")
        material.node_tree.links.new(volume.outputs[0], material.node_tree.nodes["Material Output"].inputs["Volume"])
        material.node_tree.nodes.remove(node)
        return material

    def test_faces_of_a_volume_alone_are_left_out_and_told_once(self):
        smoke = self.smoke()
        shot = self.exported(principled("Stone")[0], smoke, count=2)
        self.assertEqual([material["name"] for material in shot["material"]], ["Stone"])
        _, vertices, faces = read_ply(os.path.join(self.folder, shot["model"][0]["ply"]))
        self.assertEqual((len(faces), len(vertices)), (4, 8 - 2))
        told = [line for line in self.warnings() if "`Smoke`" in line]
        self.assertEqual(len(told), 1)
        self.assertRegex(told[0], "volume and no surface")

    def test_an_object_of_a_volume_alone_is_a_medium(self):
        support.add(self.scene, "Floor", support.grid("Floor"))
        self.scene.frame_end = 3
        shot = self.exported(self.smoke())
        self.assertEqual({model["name"] for model in shot["model"]}, {"Floor", "Square"})
        self.assertIs({table["name"]: table for table in shot["material"]}["Smoke"]["surface"], False)
        self.assertEqual([line for line in self.warnings() if "`Smoke`" in line], [])

    def test_a_volume_alone_in_a_mesh_that_deforms_is_left_out(self):
        self.scene.frame_end = 2
        mesh = support.grid(count=2)
        for material in (principled("Stone")[0], self.smoke()):
            mesh.materials.append(material)
        mesh.polygons[0].material_index = 1
        support.add(self.scene, "Sea", mesh).modifiers.new("Wave", "WAVE")
        shot = self.export()
        with open(os.path.join(self.folder, shot["model"][0]["obj"]), encoding="utf-8") as file:
            kinds = [line.split()[0] for line in file]
        self.assertEqual((kinds.count("f"), kinds.count("v"), kinds.count("usemtl")), (6, 9, 1))

    def animate(self, holder, path, *values):
        """Gives a property a value in each frame from the first one on."""
        self.scene.frame_end = len(values)
        for frame, value in enumerate(values, 1):
            setattr(holder, path, value)
            holder.keyframe_insert(path, frame=frame)

    def world(self):
        """Gives the scene a world, and returns its Background node."""
        self.scene.world = bpy.data.worlds.new("Dusk")
        self.scene.world.use_nodes = True
        return self.scene.world.node_tree.nodes["Background"]

    def test_an_animated_world_is_that_of_the_first_frame_and_told_once(self):
        node = self.world()
        node.inputs["Color"].default_value = (1, 1, 1, 1)
        self.animate(node.inputs["Strength"], "default_value", 1.0, 2.0, 3.0)
        self.assertEqual(self.export()["background"]["color"], [1, 1, 1])
        self.assertEqual([line for line in self.warnings() if "Dusk" in line], ["world `Dusk` is animated: frame 1 is shown"])
        # the frame itself, where there is one alone, whatever the frame that is shown in the window
        self.scene.frame_start = 3
        self.assertEqual(self.export()["background"]["color"], [3, 3, 3])
        self.assertEqual([line for line in self.warnings() if "Dusk" in line], [])

    def test_a_world_at_rest_is_not_told(self):
        self.animate(self.world().inputs["Strength"], "default_value", 1.0, 1.0)
        self.export()
        self.assertEqual([line for line in self.warnings() if "Dusk" in line], [])

    def test_animated_materials_are_told_once_also_within_groups_and_by_drivers(self):
        ramp, node = principled("Ramp", Emission_Color=(1, 1, 1, 1))
        self.animate(node.inputs["Emission Strength"], "default_value", 1.0, 2.0, 3.0)
        group = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
        group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        inner, output = group.nodes.new("ShaderNodeBsdfDiffuse"), group.nodes.new("NodeGroupOutput")
        group.links.new(inner.outputs[0], output.inputs[0])
        self.animate(inner.inputs["Color"], "default_value", (1, 0, 0, 1), (0, 1, 0, 1), (0, 0, 1, 1))
        grouped, node = principled("Grouped")
        outer = grouped.node_tree.nodes.new("ShaderNodeGroup")
        outer.node_tree = group
        grouped.node_tree.links.new(outer.outputs[0], grouped.node_tree.nodes["Material Output"].inputs["Surface"])
        driven, node = principled("Driven")
        node.inputs["Roughness"].driver_add("default_value").driver.expression = "frame / 10"
        still, node = principled("Still")
        self.animate(node.inputs["Roughness"], "default_value", 0.5, 0.5, 0.5)
        shot = self.exported(ramp, grouped, driven, still, count=2)
        materials = {material["name"]: material for material in shot["material"]}
        self.assertEqual(materials["Ramp"]["ke"], [1, 1, 1])
        self.assertEqual(materials["Grouped"]["kd"], [1, 0, 0])
        told = {f"material `{name}` is animated: frame 1 is shown" for name in ("Ramp", "Grouped", "Driven")}
        self.assertEqual((len(self.warnings()), set(self.warnings())), (3, told))

    def test_sizes_of_lights_have_keys(self):
        spot = bpy.data.lights.new("Spot", "SPOT")
        self.animate(spot, "spot_size", 0.5, 1.0)
        self.animate(spot, "spot_blend", 0.0, 1.0)
        support.add(self.scene, "Spot", spot)
        panel = bpy.data.lights.new("Panel", "AREA")
        self.animate(support.add(self.scene, "Panel", panel), "scale", (1, 1, 1), (3, 1, 1))
        sun = bpy.data.lights.new("Sun", "SUN")
        self.animate(sun, "energy", 1.0, 2.0)
        support.add(self.scene, "Sun", sun)
        support.add(self.scene, "Floor", support.grid())
        lights = {light["name"]: light for light in self.export()["light"]}
        np.testing.assert_allclose([key["cone"] for key in lights["Spot"]["key"]], np.degrees([0.5, 1.0]), atol=1e-4)
        self.assertEqual(lights["Spot"]["key"][0]["soft"], 0)
        self.assertGreater(lights["Spot"]["key"][1]["soft"], 0.1)
        widths = [key["size"][0] for key in lights["Panel"]["key"]]
        self.assertAlmostEqual(widths[1], 3 * widths[0], places=5)
        self.assertEqual(len(lights["Sun"]["key"]), 2)
        self.assertEqual(self.warnings(), [])

    def test_a_point_that_becomes_a_sphere_is_a_small_one_before(self):
        lamp = bpy.data.lights.new("Lamp", "POINT")
        self.animate(lamp, "shadow_soft_size", 0.0, 0.5)
        support.add(self.scene, "Lamp", lamp)
        support.add(self.scene, "Floor", support.grid())
        light = self.export()["light"][0]
        self.assertEqual((light["type"], light["samples"]), ("sphere", 4))
        np.testing.assert_allclose([key["radius"] for key in light["key"]], [1e-6, 0.5])

    def seen_by_the_camera(self, color):
        """Gives the scene a world that lights as its Background node does, and which the camera sees in another colour."""
        node = self.world()
        tree = self.scene.world.node_tree
        mix, path, other = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("MixShader", "LightPath", "Background"))
        other.inputs["Color"].default_value = color
        tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
        tree.links.new(node.outputs[0], mix.inputs[1])
        tree.links.new(other.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], tree.nodes["World Output"].inputs["Surface"])
        return node

    def test_a_world_that_the_camera_sees_otherwise(self):
        self.seen_by_the_camera((1, 0, 0, 1)).inputs["Color"].default_value = (0, 0, 1, 1)
        shot = self.export()
        self.assertEqual((shot["background"]["color"], shot["environment"]["visible"]), ([1, 0, 0], False))
        np.testing.assert_allclose(support.read_pixels(os.path.join(self.folder, shot["environment"]["map"]))[:, :, :3], [[[0, 0, 1]] * 4] * 2)
        self.assertEqual([line for line in self.warnings() if "Dusk" in line], [])

    def test_a_map_that_the_camera_does_not_see(self):
        node = self.seen_by_the_camera((1, 0, 0, 1))
        tree = self.scene.world.node_tree
        source = tree.nodes.new("ShaderNodeTexEnvironment")
        source.image = bpy.data.images.new("Studio", 8, 4, float_buffer=True)
        tree.links.new(source.outputs[0], node.inputs["Color"])
        shot = self.export()
        self.assertEqual((shot["background"]["color"], shot["environment"]["visible"]), ([1, 0, 0], False))

    def test_a_world_within_a_group(self):
        group = bpy.data.node_groups.new("Studio", "ShaderNodeTree")
        group.interface.new_socket("Strength", in_out="INPUT", socket_type="NodeSocketFloat")
        group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketShader")
        enters, leaves = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        shader, source = group.nodes.new("ShaderNodeBackground"), group.nodes.new("ShaderNodeTexEnvironment")
        source.image = bpy.data.images.new("Studio", 8, 4, float_buffer=True)
        group.links.new(source.outputs[0], shader.inputs["Color"])
        group.links.new(enters.outputs[0], shader.inputs["Strength"])
        group.links.new(shader.outputs[0], leaves.inputs[0])
        self.world()
        tree = self.scene.world.node_tree
        outer = tree.nodes.new("ShaderNodeGroup")
        outer.node_tree = group
        outer.inputs["Strength"].default_value = 3.0
        tree.links.new(outer.outputs[0], tree.nodes["World Output"].inputs["Surface"])
        shot = self.export()
        self.assertEqual(shot["environment"]["power"], 3)
        self.assertEqual([line for line in self.warnings() if "Dusk" in line], [])

    def test_normals_shaders_and_coordinates_come_into_groups_through_their_inputs(self):
        group = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
        for name, kind in (("Normal", "Vector"), ("Below", "Shader"), ("Place", "Vector")):
            group.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
        group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketShader")
        inside = {kind: group.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput")}
        diffuse, mix, source = (group.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfDiffuse", "MixShader", "TexImage"))
        source.image = bpy.data.images.new("Colors", 4, 4)
        enters = inside["NodeGroupInput"].outputs
        mix.inputs[0].default_value = 0.0
        for output, socket in (
            (enters["Place"], source.inputs["Vector"]),
            (source.outputs["Color"], diffuse.inputs["Color"]),
            (enters["Normal"], diffuse.inputs["Normal"]),
            (diffuse.outputs[0], mix.inputs[1]),
            (enters["Below"], mix.inputs[2]),
            (mix.outputs[0], inside["NodeGroupOutput"].inputs[0]),
        ):
            group.links.new(output, socket)
        material, node = principled("Grouped")
        tree = material.node_tree
        outer = tree.nodes.new("ShaderNodeGroup")
        outer.node_tree = group
        normals, uvs, picture, place = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("NormalMap", "UVMap", "TexImage", "Mapping"))
        picture.image = bpy.data.images.new("Normals", 4, 4)
        picture.image.colorspace_settings.name = "Non-Color"
        uvs.uv_map = "Second"
        place.inputs["Scale"].default_value = (3, 3, 3)
        for output, socket in (
            (uvs.outputs[0], place.inputs["Vector"]),
            (place.outputs[0], outer.inputs["Place"]),
            (place.outputs[0], picture.inputs["Vector"]),
            (picture.outputs["Color"], normals.inputs["Color"]),
            (normals.outputs[0], outer.inputs["Normal"]),
            (node.outputs[0], outer.inputs["Below"]),
            (outer.outputs[0], tree.nodes["Material Output"].inputs["Surface"]),
        ):
            tree.links.new(output, socket)
        mesh = support.grid()
        for name in ("First", "Second"):
            mesh.uv_layers.new(name=name)
        mesh.materials.append(material)
        support.add(self.scene, "Square", mesh)
        shot = self.export()
        values = shot["material"][0]
        self.assertEqual(("norm" in values, "map_kd" in values, self.warnings()), (True, True, []))
        _, vertices, _ = read_ply(os.path.join(self.folder, shot["model"][0]["ply"]))
        self.assertAlmostEqual(float(np.ptp(vertices["s"])), 3.0, places=5)
        # the shader that comes in is shown where the mix says so
        mix.inputs[0].default_value = 1.0
        node.inputs["Metallic"].default_value = 1.0
        self.assertEqual(self.export()["material"][0]["pm"], 1)
        self.assertEqual(self.warnings(), [])

    def leaf(self, alpha):
        """Keys of a glowing material with this picture of its alpha."""
        image = bpy.data.images.new("Leaf", 8, 8, alpha=True)
        image.pixels.foreach_set(np.dstack([np.full((8, 8, 3), 0.5), alpha.reshape(8, 8)]).astype(np.float32).ravel())
        material, node = principled("Leaf", Emission_Strength=1.0, Emission_Color=(1, 1, 1, 1))
        source = material.node_tree.nodes.new("ShaderNodeTexImage")
        source.image = image
        material.node_tree.links.new(source.outputs["Alpha"], node.inputs["Alpha"])
        return self.exported(material)["material"][0]

    def test_soft_alpha_is_blended_and_dims_what_is_emitted(self):
        values = self.leaf(np.linspace(0, 1, 64))
        self.assertEqual((values["alpha_mode"], "map_ke" in values), ("blend", False))

    def test_hard_alpha_cuts_out(self):
        values = self.leaf(np.repeat([0.0, 1.0], 32))
        self.assertEqual((values["alpha_mode"], "map_ke" in values), ("cut", True))


if __name__ == "__main__":
    unittest.main()
