# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: what Blender calls."""

import traceback

import bpy

from . import passes, session, viewport
from .export import Cancelled, ExportError


class AfterimageEngine(bpy.types.RenderEngine):
    """Afterimage as Blender's render engine."""

    bl_idname = "AFTERIMAGE"
    bl_label = "Afterimage"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True
    bl_use_gpu_context = False
    bl_use_postprocess = True

    def update_render_passes(self, scene=None, renderlayer=None):
        """Says which passes there are."""
        passes.register(self, scene, renderlayer)

    def render(self, depsgraph):
        """Renders one frame of one view layer. No error leaves it: Blender shows what `error_set` says."""
        try:
            self._render(depsgraph)
        except Cancelled:
            self.update_stats("", "Afterimage | cancelled")
        except (ExportError, session.MissingRenderer) as error:
            self._fail(str(error))
        except OSError as error:
            self._fail(f"cannot write the shot: {error}. For renders see Preferences > File Paths > Temporary Files: a folder that can be written")
        except MemoryError:
            self._fail("there is not enough memory for this scene: render fewer pixels, samples or frames")
        except Exception as error:  # noqa: BLE001  an error must not take Blender down
            kind = type(error).__name__
            # the renderer's own exceptions; its module may not be there to name them
            if kind == "Cancelled":
                self.update_stats("", "Afterimage | cancelled")
            elif kind == "Error":
                self._fail(str(error))
            else:
                traceback.print_exc()
                self._fail(f"{kind}: {error}")

    def render_frame_finish(self):
        """Ends a frame, all its view layers. Blender says before each frame of an animation that it is one, and never takes it back: an
        engine that persistent data keeps would take the stills that follow for more of the animation, and each would be exported by itself."""
        self.is_animation = False

    def _fail(self, message):
        """Ends the render with an error, in the picture's header and in the reports of whoever called for it."""
        self.report({"ERROR"}, f"Afterimage: {message}")
        self.error_set(f"Afterimage: {message}")

    def _render(self, depsgraph):
        scene, view_layer = bpy.data.scenes.get(depsgraph.scene.name) or depsgraph.scene, depsgraph.view_layer
        if session.export_folder is not None:
            frames = session.frames_of(scene)
            session.exported = session.export(self, scene, depsgraph, [view_layer], session.export_folder, frames)
            return
        session.renderer()
        for view in session.views_of(scene):
            self.active_view_set(view)
            self._render_view(scene, depsgraph, view)

    def _render_view(self, scene, depsgraph, view):
        """Renders one frame of one view, whose name is empty where there is one alone."""
        view_layer = depsgraph.view_layer
        self.update_stats("", "Afterimage | exporting")
        job = session.job_of(self, scene, depsgraph, view_layer, view)
        self.update_stats("", f"Afterimage | frame {scene.frame_current}")
        frame = job.frame(self, scene, view_layer)
        height, width = frame.layers["RGBA"].shape[:2]
        result = self.begin_result(0, 0, width, height, layer=view_layer.name, view=view)
        passes.add_manifests(self.get_result(), scene, view_layer, job.objects, job.exported.materials)
        passes.fill(result, frame, scene, view_layer, job.numbers, job.of_groups)
        self.end_result(result)
        reused = frame.stats.get("samples", {})
        kept, total = sum(reused.get(key, 0) for key in ("good", "overlapped")), sum(v for k, v in reused.items() if k != "spare") or 1
        self.update_stats("", f"Afterimage | {frame.seconds:.2f} s, {kept / total:.0%} of the samples reused")

    viewport = None
    """The pictures of the viewport that this engine serves, once there is one."""

    def view_update(self, context, depsgraph):
        """Notes that the scene has changed. The viewport's view may change without."""
        if self.viewport is not None:
            self.viewport.change()

    def view_draw(self, context, depsgraph):
        """Draws the newest picture of the view. No error leaves it: the viewport says it."""
        try:
            if self.viewport is None:
                self.viewport = viewport.Viewport()
            scene, view = bpy.data.scenes.get(depsgraph.scene.name) or depsgraph.scene, viewport.View.of(context.region, context.region_data)
            pixels, goes_on, messages = self.viewport.show(scene, depsgraph, view)
            if pixels is not None:
                viewport.draw(self, depsgraph.scene, pixels, view.size)
            if goes_on:
                bpy.app.timers.register(viewport.redraw, first_interval=0.1)
            if messages:
                self.update_stats("Afterimage", messages[-1])
        except Exception as error:  # noqa: BLE001  an error must not take Blender down
            self.update_stats("Afterimage has no picture of this view", str(error))


CLASSES = (AfterimageEngine,)


def register():
    """Registers the engine."""
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister():
    """Unregisters it."""
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
