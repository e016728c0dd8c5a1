# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a scene: `scene.afterimage`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty


class AfterimageSettings(bpy.types.PropertyGroup):
    """How Afterimage renders a scene."""

    error: FloatProperty(
        name="Noise Threshold",
        description="Noise that a frame may have before it is denoised, in percent of its mean brightness: samples, paths, reflections and shadow rays that "
        "are not set follow from it. 0: none do",
        default=5.0,
        min=0.0,
        max=90.0,
        soft_min=0.5,
        soft_max=20.0,
        subtype="PERCENTAGE",
    )
    samples: IntProperty(name="Samples", description="N, for N x N samples in a pixel", default=3, min=1, max=16)
    paths: IntProperty(
        name="Paths", description="Paths by which each sample gathers light of other surfaces and of the world", default=4, min=0, max=1024
    )
    bounces: IntProperty(name="Bounces", description="Surfaces that such a path meets, at most", default=3, min=0, max=64)
    depth: IntProperty(name="Depth", description="Mirrors and glass surfaces on the way from the camera, at most", default=12, min=0, max=64)
    volume_bounces: IntProperty(
        name="Volume Bounces",
        description="Times that a path is scattered in volumes, at most, beside the first that the camera sees",
        default=4,
        min=0,
        max=64,
    )
    volume_samples: IntProperty(
        name="Volume Samples", description="Places along each ray of the camera at which volumes scatter light", default=1, min=1, max=64
    )
    reflections: IntProperty(name="Reflections", description="Paths by which a sample of a rough surface reflects", default=4, min=0, max=64)
    shadow_rays: EnumProperty(
        name="Shadow Rays",
        description="Rays from each sample to a light that has a size",
        items=[("1", "1", ""), ("4", "4", ""), ("16", "16", "")],
        default="4",
    )
    mode: EnumProperty(
        name="Reuse",
        description="Which frames of an animation reuse the samples of the frame before",
        items=[
            ("auto", "Where it pays", "Reuse samples where this is estimated to be faster"),
            ("reproject", "Always", "Reuse samples in all frames but base frames"),
            ("full", "Never", "Trace each frame in full"),
        ],
        default="auto",
    )
    base_every: IntProperty(
        name="Base Every", description="Frames from one that is traced in full to the next one; 0: the first one alone", default=48, min=0, max=100000
    )
    hold: BoolProperty(
        name="Hold Materials",
        description="Show materials, worlds and sizes of lights that are animated as they are in the first frame: all frames reuse samples",
        default=False,
    )
    exposures: IntProperty(
        name="Exposures",
        description="With motion blur or depth of field: the most exposures among which the samples of a pixel are divided. 0: as many as suit the scene",
        default=0,
        min=0,
        max=256,
    )
    clamp: FloatProperty(name="Clamp", description="The most that a path may bring by indirect ways. 0: no limit", default=0.0, min=0.0, soft_max=100.0)
    caustics: BoolProperty(
        name="Caustics", description="Light through glass is bent and focused. Needs hundreds of paths; otherwise glass casts no shadow", default=False
    )
    denoise: BoolProperty(name="Denoise", description="Show the picture that Open Image Denoise makes of it", default=False)
    denoising_data: BoolProperty(name="Denoising Data", description="Passes for denoising in the compositor", default=False)


CLASSES = (AfterimageSettings,)


def register():
    """Adds the settings to scenes."""
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.afterimage = bpy.props.PointerProperty(type=AfterimageSettings)


def unregister():
    """Removes them."""
    del bpy.types.Scene.afterimage
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
