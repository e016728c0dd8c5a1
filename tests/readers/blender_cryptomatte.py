"""Has Blender's Cryptomatte node make the matte of NAME in LAYER of a file, and writes it as 32-bit EXR.

python blender_cryptomatte.py LAYER NAME FILE.exr FOLDER, where `bpy` 5 is installed. The one file that FOLDER holds then has the
channel Matte.V.
"""

import sys

import bpy


def main(layer, name, path, folder):
    scene = bpy.context.scene
    tree = bpy.data.node_groups.new("reader", "CompositorNodeTree")
    scene.compositing_node_group = tree
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source, node.image = "IMAGE", bpy.data.images.load(path)
    node.layer_name, node.matte_id = layer, name
    file = tree.nodes.new("CompositorNodeOutputFile")
    file.format.media_type = "MULTI_LAYER_IMAGE"
    file.directory, file.file_name = folder, "read"
    file.format.color_depth, file.format.exr_codec = "32", "NONE"
    file.file_output_items.new("FLOAT", "Matte")
    tree.links.new(node.outputs["Matte"], file.inputs[0])
    scene.render.resolution_x, scene.render.resolution_y = 64, 36
    scene.render.resolution_percentage = 100
    bpy.ops.render.render()


main(*sys.argv[-4:])
