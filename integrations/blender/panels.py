# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: the engine's settings, and Blender's own panels that hold for it."""

import bpy

from .export.rays import KINDS


class Panel:
    """What all panels of the engine have in common."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"AFTERIMAGE"}

    @classmethod
    def poll(cls, context):
        """Shows it for this engine alone."""
        return context.engine in cls.COMPAT_ENGINES


def columns(layout):
    """A layout of names and values."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


class SettingsPanel(Panel):
    """A panel of the engine's own settings, by their names."""

    NAMES = ()

    def draw(self, context):
        """Draws it."""
        layout = columns(self.layout)
        for name in self.NAMES:
            layout.prop(context.scene.afterimage, name)


class AFTERIMAGE_PT_sampling(SettingsPanel, bpy.types.Panel):
    """Samples and light."""

    bl_label = "Sampling"
    COUNTS = ("samples", "paths", "reflections", "shadow_rays")
    """Counts that follow from the noise threshold while nobody has set them."""
    NAMES = ("bounces", "volume_bounces", "volume_samples", "depth", "exposures", "clamp", "caustics", "denoise")

    def draw(self, context):
        """Draws it."""
        layout, own = columns(self.layout), context.scene.afterimage
        layout.prop(own, "error")
        for name in self.COUNTS:
            row = layout.row()
            row.active = own.error <= 0 or own.is_property_set(name)
            row.prop(own, name)
        super().draw(context)


class AFTERIMAGE_PT_reuse(SettingsPanel, bpy.types.Panel):
    """Reuse from frame to frame."""

    bl_label = "Reuse"
    NAMES = ("mode", "base_every", "hold")


class AFTERIMAGE_PT_film(Panel, bpy.types.Panel):
    """Background and motion blur."""

    bl_label = "Film"

    def draw(self, context):
        """Draws it."""
        layout, render = columns(self.layout), context.scene.render
        layout.prop(render, "film_transparent")
        layout.prop(render, "use_motion_blur")
        column = layout.column()
        column.active = render.use_motion_blur
        column.prop(render, "motion_blur_position")
        column.prop(render, "motion_blur_shutter")
        column.template_curve_mapping(render, "motion_blur_shutter_curve")
        layout.operator("afterimage.export_shot")


class AFTERIMAGE_PT_passes(Panel, bpy.types.Panel):
    """Passes of a view layer."""

    bl_label = "Passes"
    bl_context = "view_layer"
    FLAGS = ("z", "mist", "position", "normal", "vector", "uv", "object_index", "material_index", "diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct", "glossy_indirect")
    MORE = ("glossy_color", "transmission_direct", "transmission_indirect", "transmission_color", "emit", "environment", "ambient_occlusion")

    def draw(self, context):
        """Draws it."""
        layout, view_layer = columns(self.layout), context.view_layer
        for flag in (*self.FLAGS, *self.MORE, "cryptomatte_object", "cryptomatte_material"):
            layout.prop(view_layer, f"use_pass_{flag}")
        layout.prop(view_layer, "pass_cryptomatte_depth")
        if hasattr(view_layer, "cycles"):
            layout.prop(view_layer.cycles, "use_pass_shadow_catcher")
        layout.prop(context.scene.afterimage, "denoising_data")
        layout.label(text="Light Groups")
        row = layout.row()
        row.template_list("UI_UL_list", "lightgroups", view_layer, "lightgroups", view_layer, "active_lightgroup_index", rows=2)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        column.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")
        if context.scene.world:
            layout.prop_search(context.scene.world, "lightgroup", view_layer, "lightgroups", text="World")


class AFTERIMAGE_PT_ray_visibility(Panel, bpy.types.Panel):
    """Kinds of rays that meet an object."""

    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        """Shows it for what has surfaces, or makes instances of them."""
        item = context.object
        has_surfaces = item and (item.type in {"MESH", "CURVE", "SURFACE", "FONT", "META"} or item.instance_type == "COLLECTION")
        return bool(has_surfaces) and super().poll(context)

    def draw(self, context):
        """Draws it."""
        layout = columns(self.layout)
        for kind in KINDS:
            layout.prop(context.object, f"visible_{kind}", text=kind.capitalize())


class AFTERIMAGE_PT_light_linking(Panel, bpy.types.Panel):
    """Which objects a light lights, and which cast shadows in its light."""

    bl_label = "Light Linking"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        """Shows it for what may shine."""
        item = context.object
        return bool(item) and item.type in {"LIGHT", "MESH", "CURVE", "SURFACE", "FONT", "META"} and super().poll(context)

    def draw(self, context):
        """Draws it."""
        layout, linking = self.layout, context.object.light_linking
        layout.prop_search(context.object, "lightgroup", context.view_layer, "lightgroups", text="Light Group")
        for name, label, operator in (
            ("receiver_collection", "Receivers", "object.light_linking_receiver_collection_new"),
            ("blocker_collection", "Blockers", "object.light_linking_blocker_collection_new"),
        ):
            column = layout.column()
            column.label(text=label)
            column.template_ID(linking, name, new=operator)
            if getattr(linking, name):
                column.template_light_linking_collection(column, linking, name)


CLASSES = (
    AFTERIMAGE_PT_sampling,
    AFTERIMAGE_PT_reuse,
    AFTERIMAGE_PT_film,
    AFTERIMAGE_PT_passes,
    AFTERIMAGE_PT_ray_visibility,
    AFTERIMAGE_PT_light_linking,
)
NOT_OURS = {
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_layer_passes",
    "RENDER_PT_freestyle",
    "RENDER_PT_simplify_greasepencil",
}


def blenders_own():
    """Blender's panels that hold for any engine, and those of lights, materials and worlds that are of Cycles or Eevee."""
    for each in bpy.types.Panel.__subclasses__():
        engines = getattr(each, "COMPAT_ENGINES", None)
        if engines and "BLENDER_RENDER" in engines and each.__name__ not in NOT_OURS:
            yield each


def register():
    """Registers the panels."""
    for each in CLASSES:
        bpy.utils.register_class(each)
    for each in blenders_own():
        each.COMPAT_ENGINES.add("AFTERIMAGE")


def unregister():
    """Removes them."""
    for each in blenders_own():
        each.COMPAT_ENGINES.discard("AFTERIMAGE")
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
