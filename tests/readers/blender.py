"""Shows a file to Blender's compositor and writes what each output of its Image node brings, as 32-bit EXR.

blender -b --factory-startup -P blender.py -- [VIEW] FILE.exr FOLDER, or python blender.py [VIEW] FILE.exr FOLDER where `bpy` is
installed. VIEW: which of a file of several. The one file that FOLDER holds then has a layer for each output.
"""

import sys

import bpy


def compositor(scene):
    """The scene's empty tree of nodes, in Blender 3, 4 and 5."""
    if hasattr(scene, "compositing_node_group"):
        scene.compositing_node_group = bpy.data.node_groups.new("reader", "CompositorNodeTree")
        return scene.compositing_node_group
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree


def connect(tree, outputs, folder):
    """A node that writes all `outputs`; its inputs have their names."""
    file = tree.nodes.new("CompositorNodeOutputFile")
    is_new = hasattr(file, "file_output_items")
    if is_new:
        file.format.media_type = "MULTI_LAYER_IMAGE"
        file.directory, file.file_name = folder, "read"
    else:
        file.format.file_format = "OPEN_EXR_MULTILAYER"
        file.base_path = folder + "/read"
        file.layer_slots.clear()
    file.format.color_depth, file.format.exr_codec = "32", "NONE"
    for number, output in enumerate(outputs):
        if is_new:
            file.file_output_items.new({"VALUE": "FLOAT"}.get(output.type, output.type), output.name)
        else:
            file.layer_slots.new(output.name)
        tree.links.new(output, file.inputs[number])


def main(path, folder, view=None):
    image = bpy.data.images.load(path)
    scene = bpy.context.scene
    tree = compositor(scene)
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    if view:
        node.view = view
    connect(tree, node.outputs, folder)
    if not hasattr(scene, "compositing_node_group"):
        # without it Blender 3 does not run the compositor
        composite = tree.nodes.new("CompositorNodeComposite")
        tree.links.new(node.outputs[0], composite.inputs[0])
    scene.render.resolution_x, scene.render.resolution_y = 64, 36
    scene.render.resolution_percentage = 100
    bpy.ops.render.render()


arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
main(*arguments[-2:], *arguments[:-2])
