# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of small scenes, good and bad. Needs bpy; the renderer is not asked."""

import itertools
import os
import re
import stat
import sys
import time
import types
import unittest

import bpy
import numpy as np
import support


class Export(support.ExportCase):
    def warnings(self):
        return "\n".join(support.extension().session.exported.warnings)

    def refused(self, pattern):
        """Exports, and expects an error that the operator reports (which bpy raises)."""
        with self.assertRaisesRegex(RuntimeError, pattern):
            bpy.ops.afterimage.export_shot(directory=self.folder)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "shot.toml")))

    def test_counts_that_nobody_has_set_follow_from_the_noise_threshold(self):
        lamp = bpy.data.lights.new("Lamp", "POINT")
        lamp.shadow_soft_size = 0.5
        support.add(self.scene, "Lamp", lamp)
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        own = self.scene.afterimage
        own.error = 4.0
        shot = self.export()
        self.assertAlmostEqual(shot["render"]["error"], 0.04)
        self.assertFalse({"samples", "reflections"} & shot["render"].keys())
        self.assertNotIn("paths", shot["indirect"])
        self.assertNotIn("samples", shot["light"][0])
        own.samples, own.shadow_rays = 5, "16"
        shot = self.export()
        self.assertEqual((shot["render"]["samples"], shot["light"][0]["samples"]), (5, 16))
        self.assertNotIn("paths", shot["indirect"])
        own.error = 0
        shot = self.export()
        self.assertNotIn("error", shot["render"])
        self.assertEqual((shot["render"]["reflections"], shot["indirect"]["paths"]), (own.reflections, own.paths))

    def test_a_scene_without_anything_but_a_camera_is_a_shot(self):
        support.add_camera(self.scene)
        self.assertEqual([model["visible"] for model in self.export()["model"]], [False])
        self.assertIn("no mesh", self.warnings())

    def test_without_a_camera_the_message_asks_for_one(self):
        self.refused("(?i)camera")

    def test_a_mesh_without_faces_is_left_out(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Nothing", bpy.data.meshes.new("Nothing"))
        support.add(self.scene, "Floor", support.grid())
        self.assertEqual([model["name"] for model in self.export()["model"]], ["Floor"])

    def test_what_is_in_edit_mode_is_there_as_it_is_being_edited(self):
        support.add_camera(self.scene)
        edited = support.add(self.scene, "Edited", support.grid())
        support.add(self.scene, "Twin", edited.data)
        layers = support.add(self.scene, "Layers", support.grid("Layers"))
        layers.modifiers.new("Array", "ARRAY")
        bpy.context.view_layer.objects.active = edited
        for item in (edited, layers):
            item.select_set(True)
        bpy.ops.object.mode_set(mode="EDIT")
        import bmesh  # bpy brings it

        next(iter(bmesh.from_edit_mesh(edited.data).verts)).co.z = 2
        models = {model["name"]: model for model in self.export()["model"]}
        self.assertEqual(set(models), {"Edited", "Twin", "Layers"})
        for name in ("Edited", "Twin"):
            with open(os.path.join(self.folder, models[name]["ply"]), "rb") as file:
                self.assertEqual(np.frombuffer(file.read().split(b"end_header\n")[1][:12], dtype="<f4")[2], 2)

    def test_an_object_at_nan_is_left_out_and_told(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        support.add(self.scene, "Lost", support.grid("Other"), (float("nan"), 0, 0))
        self.assertEqual([model["name"] for model in self.export()["model"]], ["Floor"])
        self.assertIn("`Lost`", self.warnings())

    def test_what_is_scaled_flat_is_there(self):
        support.add_camera(self.scene)
        flat = support.add(self.scene, "Flat", support.grid())
        flat.scale = (2, 1, 0)
        support.add(self.scene, "Gone", flat.data).scale = (0, 0, 0)
        models = self.export()["model"]
        self.assertEqual([model["name"] for model in models], ["Flat"])
        matrix = np.array(models[0]["matrix"])[:, :3]
        # X is X, Y is -Z, and Z, which would be Y, is next to nothing
        np.testing.assert_allclose(matrix, [[2, 0, 0], [0, 0, 0], [0, -1, 0]], atol=1e-5)
        self.assertGreater(abs(np.linalg.det(matrix)), 0)

    def test_vertices_at_nan_or_infinity_are_told_by_the_name_of_their_object(self):
        for value in (float("nan"), float("inf"), 1e30):
            for deforms in (False, True):
                with self.subTest(value=value, deforms=deforms):
                    self.scene = support.empty()
                    support.add_camera(self.scene)
                    support.add(self.scene, "Floor", support.grid())
                    torn = support.add(self.scene, "Torn", support.grid())
                    if deforms:
                        self.scene.frame_end = 3
                        torn.shape_key_add(name="Basis")
                        key = torn.shape_key_add(name="Torn")
                        key.data[0].co.x = value
                        for frame, share in ((1, 0.0), (2, 0.0), (3, 1.0)):
                            key.value = share
                            key.keyframe_insert("value", frame=frame)
                    else:
                        torn.data.vertices[0].co.x = value
                    models = self.export()["model"]
                    self.assertEqual([model["name"] for model in models if model["name"] != "Floor"], ["Torn"] * deforms)
                    self.assertRegex(self.warnings(), "`Torn` is left out where vertices")
                    if deforms:
                        self.assertEqual([key["frame"] for key in models[-1]["key"] if not key["visible"]], [3])

    def test_what_is_too_large_or_too_far_away_is_told_by_its_name(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        support.add(self.scene, "Huge", support.grid()).scale = (1e10, 1e10, 1e10)
        support.add(self.scene, "Far", support.grid(), (1e19, 0, 0))
        self.assertEqual([model["name"] for model in self.export()["model"]], ["Floor"])
        for name in ("Huge", "Far"):
            self.assertIn(f"`{name}` is left out", self.warnings())

    def test_a_light_without_a_finite_power_is_told_by_its_name(self):
        support.add_camera(self.scene)
        data = bpy.data.lights.new("Lamp", "POINT")
        data.energy = float("inf")
        support.add(self.scene, "Lamp", data)
        self.assertNotIn("light", self.export())
        self.assertIn("light `Lamp` is left out", self.warnings())

    def test_a_missing_picture_is_told_with_its_remedy(self):
        support.add_camera(self.scene)
        mesh = support.grid()
        mesh.uv_layers.new()
        material = bpy.data.materials.new("Lost")
        material.use_nodes = True
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.new("gone", 1, 1)
        node.image.source = "FILE"
        node.image.filepath = "//nowhere/gone.png"
        material.node_tree.links.new(node.outputs[0], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
        mesh.materials.append(material)
        support.add(self.scene, "Floor", mesh)
        self.export()
        self.assertIn("Find Missing Files", self.warnings())

    def test_pictures_that_lie_in_the_folder_of_the_shot_stay_as_they_are(self):
        support.add_camera(self.scene)
        mesh = support.grid()
        mesh.uv_layers.new()
        material = bpy.data.materials.new("Wood")
        material.use_nodes = True
        tree = material.node_tree
        os.makedirs(os.path.join(self.folder, "textures"))
        for name, socket in (("wood", "Base Color"), ("rough", "Roughness")):
            image = bpy.data.images.new(name, 8, 8)
            image.filepath_raw, image.file_format = os.path.join(self.folder, "textures", f"{name}.png"), "PNG"
            image.save()
            node = tree.nodes.new("ShaderNodeTexImage")
            node.image = image
            tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs[socket])
        mesh.materials.append(material)
        support.add(self.scene, "Floor", mesh)
        path = os.path.join(self.folder, "textures", "wood.png")
        with open(path, "rb") as file:
            before, kept = file.read(), os.stat(path)
        self.assertEqual(self.export()["material"][0]["map_kd"], "textures/wood.png")
        with open(path, "rb") as file:
            self.assertEqual((file.read(), os.stat(path).st_ino, os.stat(path).st_mtime_ns), (before, kept.st_ino, kept.st_mtime_ns))

    def test_a_missing_library_leaves_the_rest(self):
        support.add_camera(self.scene)
        library = os.path.join(self.scratch.name, "library.blend")
        item = support.add(self.scene, "Linked", support.grid("Linked"))
        bpy.data.libraries.write(library, {item})
        bpy.data.objects.remove(item)
        with bpy.data.libraries.load(library, link=True) as (_, into):
            into.objects = ["Linked"]
        self.scene.collection.objects.link(into.objects[0])
        support.add(self.scene, "Floor", support.grid())
        path = os.path.join(self.scratch.name, "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        os.remove(library)
        bpy.ops.wm.open_mainfile(filepath=path)
        self.scene = bpy.context.scene
        self.assertEqual([model["name"] for model in self.export()["model"]], ["Floor"])

    def test_ten_thousand_instances_share_a_file(self):
        support.add_camera(self.scene)
        mesh = support.grid()
        for index in range(10000):
            support.add(self.scene, f"Copy {index}", mesh, (index % 100, index // 100, 0))
        models = self.export()["model"]
        self.assertEqual(len(models), 1)
        places = np.load(os.path.join(self.folder, models[0]["places"]["file"]))
        self.assertEqual(len(np.unique(places.reshape(-1, 12), axis=0)), 10000)

    def test_a_mesh_that_nothing_changes_is_read_once_for_all_frames(self):
        self.scene.frame_end = 4
        support.add_camera(self.scene)
        item = support.add(self.scene, "Moves", support.grid())
        for frame, x in ((1, 0.0), (4, 1.0)):
            item.location.x = x
            item.keyframe_insert("location", frame=frame)
        support.add(self.scene, "Copy", item.data)
        store, reads = support.extension().export.shot.MeshStore, []
        read = store._read
        store._read = lambda *values: reads.append(values[2].name) or read(*values)
        try:
            self.assertEqual(len(self.export()["model"]), 2)
            self.assertEqual(len(reads), 1)
            # what listens to frames may change meshes
            bpy.app.handlers.frame_change_post.append(lambda scene, graph: setattr(item.data.vertices[0], "co", (scene.frame_current, 0, 0)))
            shapes = self.export()["model"][0]["shapes"]
            with open(os.path.join(self.folder, shapes["cache"]), "rb") as file:
                points = np.frombuffer(file.read()[32:], dtype="<f4").reshape(4, 4, 3)
            np.testing.assert_allclose(points[:, 0, 0], [1, 2, 3, 4])
        finally:
            store._read = read
            bpy.app.handlers.frame_change_post.clear()

    def test_an_output_folder_that_cannot_be_written_is_told(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        # a file in the place of the folder: root may write into any folder
        with open(self.folder, "w", encoding="ascii"):
            pass
        with self.assertRaisesRegex(RuntimeError, "Cannot make the folder|cannot write"):
            bpy.ops.afterimage.export_shot(directory=os.path.join(self.folder, "deeper"))

    def test_a_read_only_folder_is_told(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        if os.geteuid() == 0:
            self.folder = "/proc/self"  # where even root may write nothing
        else:
            os.mkdir(self.folder)
            os.chmod(self.folder, stat.S_IRUSR | stat.S_IXUSR)
        self.refused("cannot write")

    def sky(self):
        """Gives the scene a sky texture."""
        self.scene.world = bpy.data.worlds.new("Sky")
        self.scene.world.use_nodes = True
        tree = self.scene.world.node_tree
        node = tree.nodes.new("ShaderNodeTexSky")
        tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
        node.sun_elevation = 0.7
        return node

    def test_a_sky_is_baked_again_only_when_it_has_changed(self):
        support.add_camera(self.scene)
        node, bake = self.sky(), support.extension().export.world.world_bake
        runs, run = [], bake._run
        light = np.ones((2, 4, 3), dtype=np.float32)
        bake._run = lambda request, what, goes_on: runs.append(request) or bake.Baked(light, None, [])
        try:
            self.export()
            self.export()
            self.assertEqual(len(runs), 1)
            node.sun_elevation = 0.8
            self.export()
            self.assertEqual(len(runs), 2)
        finally:
            bake._run = run
            bake._baked.clear()

    def test_a_sky_that_cannot_be_baked_ends_the_export_with_its_error(self):
        support.add_camera(self.scene)
        self.sky()
        bake = support.extension().export.world.world_bake
        popen = bake.subprocess.Popen
        text = "print('about to fail'); raise MemoryError('no room for a sky')"
        bake.subprocess.Popen = lambda command, **more: popen([sys.executable, "-c", text], **more)
        try:
            self.refused("sky texture cannot be rendered.*code 1.*no room for a sky")
        finally:
            bake.subprocess.Popen = popen

    def test_a_sky_is_waited_for_however_long_it_takes(self):
        support.add_camera(self.scene)
        self.sky()
        bake = support.extension().export.world.world_bake
        popen, clock, hours = bake.subprocess.Popen, bake.time, itertools.count(0, 3600)
        text = "import sys, numpy; numpy.savez(sys.argv[1], light=numpy.ones((2, 4, 3)), suns=numpy.zeros((0, 7)))"
        bake.subprocess.Popen = lambda command, **more: popen([sys.executable, "-c", text, command[-1]], **more)
        bake.time = types.SimpleNamespace(sleep=time.sleep, monotonic=lambda: next(hours))
        try:
            self.assertIn("map", self.export()["environment"])
            self.assertEqual(self.warnings().count("sky"), 0)
        finally:
            bake.subprocess.Popen, bake.time = popen, clock
            bake._baked.clear()

    def test_cancelling_while_the_sky_is_baked_ends_its_process(self):
        shot, bake = support.extension().export, support.extension().export.world.world_bake
        support.add_camera(self.scene)
        self.sky()
        started, popen, asked = [], bake.subprocess.Popen, []
        bake.subprocess.Popen = lambda *values, **more: started.append(popen(*values, **more)) or started[-1]

        def progress(share):
            asked.append(share)
            return not started or len(asked) < 4

        graph = bpy.context.evaluated_depsgraph_get()
        settings = shot.Settings(frames=[1], size=(64, 48), rate=24)
        try:
            with self.assertRaises(shot.Cancelled):
                shot.export_shot(self.scene, graph, self.folder, settings, lambda f, s: self.scene.frame_set(f, subframe=s), progress)
        finally:
            bake.subprocess.Popen = popen
        self.assertEqual([process.poll() is None for process in started], [False])
        self.assertLess(started[0].returncode, 0, "it was killed, and did not end by itself")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "shot.toml")))

    def test_cancelling_leaves_no_shot_and_no_half_files(self):
        shot = support.extension().export
        self.scene.frame_end = 6
        support.add_camera(self.scene)
        item = support.add(self.scene, "Floor", support.grid())
        item.modifiers.new("Wave", "WAVE")
        graph = bpy.context.evaluated_depsgraph_get()
        settings = shot.Settings(frames=list(range(1, 7)), size=(64, 48), rate=24)
        calls = []

        def progress(share):
            calls.append(share)
            return share < 0.5

        with self.assertRaises(shot.Cancelled):
            shot.export_shot(self.scene, graph, self.folder, settings, lambda f, s: self.scene.frame_set(f, subframe=s), progress)
        self.assertGreater(len(calls), 2)
        left = [name for _, _, names in os.walk(self.folder) for name in names]
        self.assertEqual([name for name in left if name.endswith((".part", ".toml", ".pc2"))], [])

    def test_a_frame_range_backwards_is_one_frame(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        self.scene.frame_start, self.scene.frame_end = 5, 9
        self.scene.frame_end = 2  # Blender moves the start along
        self.assertEqual(self.export()["render"]["frames"], "2")

    def test_a_character_deforms_by_a_point_cache(self):
        self.scene.frame_end = 4
        support.add_camera(self.scene)
        mesh = support.grid(count=2)
        item = support.add(self.scene, "Flag", mesh)
        item.shape_key_add(name="Basis")
        key = item.shape_key_add(name="Up")
        key.data[0].co.z = 1.0
        for frame, value in ((1, 0.0), (4, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        model = self.export()["model"][0]
        self.assertEqual((model["shapes"]["first"], model["shapes"]["every"]), (1, 1))
        with open(os.path.join(self.folder, model["shapes"]["cache"]), "rb") as file:
            head, data = file.read(32), file.read()
        points = np.frombuffer(data, dtype="<f4").reshape(4, 9, 3)
        self.assertEqual(head[:11], b"POINTCACHE2")
        np.testing.assert_allclose(points[[0, 3], 0, 2], [0, 1], atol=1e-6)
        self.assertTrue(0 < points[1, 0, 2] < points[2, 0, 2] < 1)

    def test_a_mesh_that_gets_other_faces_is_another_model(self):
        self.scene.frame_end = 2
        support.add_camera(self.scene)
        item = support.add(self.scene, "Grows", support.grid())
        array = item.modifiers.new("Array", "ARRAY")
        for frame, count in ((1, 1), (2, 3)):
            array.count = count
            array.keyframe_insert("count", frame=frame)
        models = self.export()["model"]
        self.assertEqual(len({model["ply"] for model in models}), 2)
        self.assertEqual([[key["frame"] for key in model["key"] if key.get("visible")] for model in models], [[1], [2]])

    def test_text_and_instances_of_geometry_nodes_are_models(self):
        support.add_camera(self.scene)
        text = bpy.data.curves.new("Text", "FONT")
        text.body = "A"
        support.add(self.scene, "Text", text)
        nodes = bpy.data.node_groups.new("Points", "GeometryNodeTree")
        nodes.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        points, cube, copies, output = (
            nodes.nodes.new(kind) for kind in ("GeometryNodeMeshGrid", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints", "NodeGroupOutput")
        )
        nodes.links.new(points.outputs[0], copies.inputs["Points"])
        nodes.links.new(cube.outputs[0], copies.inputs["Instance"])
        nodes.links.new(copies.outputs[0], output.inputs[0])
        support.add(self.scene, "Copies", bpy.data.meshes.new("Copies")).modifiers.new("Nodes", "NODES").node_group = nodes
        models = self.export()["model"]
        self.assertEqual(sorted({model["name"] for model in models}), ["Copies", "Text"])
        self.assertEqual(len(models), 1 + 9)
        self.assertEqual(len({model["ply"] for model in models}), 2)

    def test_markers_cut_between_cameras(self):
        self.scene.frame_end = 4
        first = support.add_camera(self.scene)
        second = support.add_camera(self.scene, (0, -9, 1))
        for frame, camera in ((1, first), (3, second)):
            self.scene.timeline_markers.new(f"cut {frame}", frame=frame).camera = camera
        support.add(self.scene, "Floor", support.grid())
        keys = self.export()["camera"]["key"]
        cuts = [key for key in keys if key.get("cut")]
        self.assertEqual([key["frame"] for key in cuts], [3])
        np.testing.assert_allclose(cuts[0]["eye"], [0, 1, 9], atol=1e-5)

    def test_hidden_objects_and_collections_are_left_out(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        support.add(self.scene, "Hidden", support.grid("b")).hide_render = True
        collection = bpy.data.collections.new("Away")
        self.scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects.new("Excluded", support.grid("c")))
        bpy.context.view_layer.layer_collection.children["Away"].exclude = True
        self.assertEqual([model["name"] for model in self.export()["model"]], ["Floor"])

    def test_the_warnings_of_a_material_are_one(self):
        support.add_camera(self.scene)
        mesh = support.grid()
        material = bpy.data.materials.new("Odd")
        material.use_nodes = True
        tree = material.node_tree
        shader = tree.nodes["Principled BSDF"]
        shader.inputs["Thin Film Thickness"].default_value = 200
        shader.inputs["Specular Tint"].default_value = (1, 0.5, 0.1, 1)
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs[0], shader.inputs["Roughness"])
        mesh.materials.append(material)
        support.add(self.scene, "Floor", mesh)
        self.export()
        told = [line for line in self.warnings().splitlines() if "`Odd`" in line]
        self.assertEqual(len(told), 1)
        self.assertRegex(told[0], "(?s)thin film.*specular tint")

    def test_what_is_linked_from_a_file_that_is_gone_is_told(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        props, shot = (os.path.join(os.path.dirname(self.folder), name) for name in ("props.blend", "shot.blend"))
        sets = bpy.data.collections.new("Set")
        sets.objects.link(bpy.data.objects.new("Chair", support.grid("Chair")))
        bpy.data.libraries.write(props, {sets})
        bpy.data.collections.remove(sets)
        with bpy.data.libraries.load(props, link=True) as (_, into):
            into.collections = ["Set"]
        stand_in = bpy.data.objects.new("Sets", None)
        stand_in.instance_type, stand_in.instance_collection = "COLLECTION", bpy.data.collections["Set"]
        self.scene.collection.objects.link(stand_in)
        bpy.ops.wm.save_as_mainfile(filepath=shot)
        self.assertNotIn("missing", self.warnings() if self.export() else "")
        os.remove(props)
        bpy.ops.wm.open_mainfile(filepath=shot)
        self.scene = bpy.context.scene
        self.assertEqual([model["name"] for model in self.export()["model"]], ["Floor"])
        self.assertRegex(self.warnings(), "linked file `.*props.blend` is missing, and with it collection `Set`: left out")

    def test_without_the_renderer_exports_work_and_renders_say_so(self):
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid())
        kept = sys.modules.get("afterimage")
        sys.modules["afterimage"] = None  # so an import fails
        try:
            self.export()
            self.scene.render.engine = "AFTERIMAGE"
            with self.assertRaisesRegex(RuntimeError, "renderer is not installed"):
                bpy.ops.render.render()
        finally:
            del sys.modules["afterimage"]
            if kept:
                sys.modules["afterimage"] = kept

    def test_a_million_triangles_are_written_in_seconds(self):
        support.add_camera(self.scene)
        mesh = support.grid(count=707)
        support.add(self.scene, "Large", mesh)
        start = time.perf_counter()
        self.export()
        seconds = time.perf_counter() - start
        print(f"export of {2 * 707 * 707} triangles: {seconds:.2f} s")
        self.assertLess(seconds, 10, "two seconds on an idle machine; this only finds loops over vertices")
        path = os.path.join(self.folder, self.shot()["model"][0]["ply"])
        with open(path, "rb") as file:
            self.assertIn(f"element face {2 * 707 * 707}", re.sub(rb"end_header.*", b"", file.read(400), flags=re.S).decode())


if __name__ == "__main__":
    unittest.main()
