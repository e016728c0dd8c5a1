# SPDX-License-Identifier: GPL-3.0-or-later
"""Pointiness of vertices, and what exports make of it. Needs bpy; the renderer is not asked."""

import unittest

import bpy
import numpy as np
import support
from support import Tree
from test_surfaces import principled


def of_mesh(mesh):
    """The pointiness of a mesh's vertices."""
    export = support.extension().export
    normals = export.meshes.read_array(mesh.vertex_normals, "vector", 3, np.float32)
    edges = export.meshes.read_array(mesh.edges, "vertices", 2, np.int32)
    return export.pointiness.of_vertices(export.meshes.read_positions(mesh), normals, edges)


def cube(scale=(1, 1, 1)):
    bpy.ops.mesh.primitive_cube_add(scale=scale)
    return bpy.context.object


def with_modifier(item, kind, **values):
    """The mesh of an object with one modifier."""
    modifier = item.modifiers.new(kind, kind)
    for key, value in values.items():
        setattr(modifier, key, value)
    return item.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


class Pointiness(support.ExportCase):
    def test_flat_convex_and_hollow(self):
        np.testing.assert_allclose(of_mesh(support.grid(count=3)), 0.5, atol=1e-6)
        # the mean of a corner's edges is a third of the diagonal, towards the inside
        corner = np.arccos(-1 / np.sqrt(3)) / np.pi
        mesh = cube().data
        np.testing.assert_allclose(of_mesh(mesh), corner, atol=1e-6)
        mesh.flip_normals()
        np.testing.assert_allclose(of_mesh(mesh), 1 - corner, atol=1e-6)

    def test_neighbours_take_part(self):
        # a square with a raised middle: its corners have two neighbours, which are flat but for the middle
        mesh = support.grid(count=2)
        mesh.vertices[4].co.z = 0.5
        mesh.update()
        found = of_mesh(mesh)
        self.assertGreater(found[4], 0.5)
        np.testing.assert_allclose(found[[1, 3, 5, 7]], found[1], atol=1e-6)
        np.testing.assert_allclose(found[[0, 2, 6, 8]], found[0], atol=1e-6)
        self.assertGreater(abs(found[1] - found[0]), 0.01)

    def test_vertices_at_one_place_are_one(self):
        item = cube((1.0, 0.7, 0.4))
        whole = of_mesh(item.data)
        split = with_modifier(item, "EDGE_SPLIT", split_angle=0.0)
        self.assertEqual(len(split.vertices), 24)
        places = np.array([vertex.co for vertex in split.vertices])
        own = np.array([vertex.co for vertex in item.data.vertices])
        nearest = np.linalg.norm(places[:, None] - own[None], axis=2).argmin(axis=1)
        np.testing.assert_allclose(of_mesh(split), whole[nearest], atol=1e-5)

    def test_merging_finds_all(self):
        pointiness = support.extension().export.pointiness
        chance = np.random.default_rng(3)
        # many sums of coordinates are equal
        places = chance.integers(0, 6, (400, 3)).astype(np.float32) / 4
        roots = pointiness.merged(places)
        np.testing.assert_array_equal(places[roots], places)
        self.assertEqual(len(np.unique(roots)), len(np.unique(places, axis=0)))
        self.assertEqual(len(np.unique(pointiness.merged(places * np.float32(1e-7)))), 1)

    def test_vertices_alone(self):
        pointiness = support.extension().export.pointiness
        found = pointiness.of_vertices(np.zeros((1, 3), np.float32), np.array([[0, 0, 1]], np.float32), np.zeros((0, 2), np.int32))
        np.testing.assert_array_equal(found, [0])

    def test_colors_stand_for_it(self):
        pointiness = support.extension().export.pointiness
        values = np.linspace(0, 1, 101)
        np.testing.assert_allclose(pointiness.from_colors(pointiness.to_colors(values))[:, 0], values, atol=1e-12)
        # meshes without colours are white
        self.assertEqual(pointiness.from_colors(np.ones((1, 1, 3)))[0, 0, 0], pointiness.FLAT)

    def test_the_first_attribute_counts(self):
        material, node = principled("Worn")
        tree = Tree(material)
        outputs = tree.add("NewGeometry").outputs
        paint = tree.add("VertexColor", layer_name="Paint").outputs["Color"]
        mixed = tree.add("Mix", {0: outputs["Pointiness"], 6: outputs["Random Per Island"], 7: paint}, data_type="RGBA").outputs[2]
        tree.links.new(mixed, node.inputs["Base Color"])
        cube().data.materials.append(material)
        support.add_camera(self.scene)
        self.export()
        self.assertEqual(self.warnings(), ["material `Worn`: of its colour attributes `.Pointiness` counts beside what nodes compute"])


if __name__ == "__main__":
    unittest.main()
