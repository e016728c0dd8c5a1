# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator that exports a shot."""

import os

import bpy
from bpy.props import StringProperty

from . import session


class AFTERIMAGE_OT_export_shot(bpy.types.Operator):
    """Write the scene's frames as a shot: shot.toml, models and pictures in a folder, for the program afterimage"""

    bl_idname = "afterimage.export_shot"
    bl_label = "Export Afterimage Shot"
    bl_options = {"REGISTER"}

    directory: StringProperty(name="Folder", description="Folder for the shot; it is made if need be", subtype="DIR_PATH")

    def invoke(self, context, event):
        """Asks for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        """Exports by way of the render engine, so that the scene is evaluated as it is rendered: with what renders show alone."""
        folder = bpy.path.abspath(self.directory)
        if not folder:
            self.report({"ERROR"}, "Choose a folder for the shot")
            return {"CANCELLED"}
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            self.report({"ERROR"}, f"Cannot make the folder: {error}. Choose another one")
            return {"CANCELLED"}
        scene = context.scene
        render = scene.render
        kept = render.engine, render.use_sequencer, render.use_compositing, scene.frame_current
        session.exported, session.export_folder = None, os.path.abspath(folder)
        context.window_manager.progress_begin(0, 1)
        try:
            render.engine, render.use_sequencer, render.use_compositing = "AFTERIMAGE", False, False
            bpy.ops.render.render(scene=scene.name)
        except RuntimeError as error:
            self.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
            return {"CANCELLED"}
        finally:
            session.export_folder = None
            context.window_manager.progress_end()
            render.engine, render.use_sequencer, render.use_compositing = kept[:3]
            scene.frame_set(kept[3])
        if session.exported is None:
            self.report({"ERROR"}, "The shot was not exported: see the messages above")
            return {"CANCELLED"}
        for message in session.exported.warnings:
            self.report({"WARNING"}, message)
        self.report({"INFO"}, f"Exported {session.exported.path}")
        return {"FINISHED"}


def menu(self, _context):
    """The entry of File > Export."""
    self.layout.operator(AFTERIMAGE_OT_export_shot.bl_idname, text="Afterimage Shot (.toml)")


CLASSES = (AFTERIMAGE_OT_export_shot,)


def register():
    """Registers the operator and its menu entry."""
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.TOPBAR_MT_file_export.append(menu)


def unregister():
    """Removes both."""
    bpy.types.TOPBAR_MT_file_export.remove(menu)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
