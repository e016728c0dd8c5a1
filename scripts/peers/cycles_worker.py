"""Renders with Cycles, in a process of its own: `python -m peers.cycles_worker JOB.json`.

The job is that of `mitsuba_worker`, without a variant; `sampler` is "plain" or one of `DENOISING`. Or it has `sequences`, a list of `{"path",
"samples", "seeds", "name"}`, with `views` (pairs of eye and target), `depth`, `rounds` and `rows`. Depths are Mitsuba's; Cycles
counts the bounces after direct light, two fewer. A scene's emission is not known here.
"""

import json
import math
import os
import pathlib
import sys
import time

import bpy
import mathutils
import numpy as np

from . import measure, places, scene

# ways to denoise: quality, and how its guides are denoised beforehand; the first is Cycles' own choice
DENOISING = {
    "denoised": ("HIGH", "ACCURATE"),
    "denoised balanced": ("BALANCED", "ACCURATE"),
    "denoised balanced, guides fast": ("BALANCED", "FAST"),
}


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        job = json.load(file)
    load(job["place"])
    file = pathlib.Path(sys.argv[1]).with_suffix(".picture.exr")
    if "reference" in job:
        reference(file, **job["reference"])
    for series in job.get("measure", []):
        measured(job, file, **series)
    for one in job.get("sequences", []):
        sequence(job, file, **one)
    file.unlink(missing_ok=True)


# --- the scene ---


def load(place):
    """Makes Blender's scene that of a place. Y is up there, too: nothing in it asks what is up."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for part in scene.load(place["scene"]):
        add("mesh", mesh(part))
    width, height = place["size"]
    blender = bpy.context.scene
    blender.camera = add("camera", camera(place["fov"]))
    blender.camera.matrix_world = looking(place["eye"], place["target"])
    if "turn" in place:
        turn(blender, place)
    if "lens" in place:
        focus(blender.camera.data, **place["lens"])
    if "panel" in place:
        light = add("panel", panel(**place["panel"]))
        light.visible_camera = False
        # an area light shines along its -Z, and its size is along X and Y
        light.matrix_world = mathutils.Matrix.Translation(place["panel"]["center"]) @ mathutils.Matrix.Rotation(
            math.radians(-90), 4, "X"
        )
    if "sun" in place:
        along = mathutils.Vector(place["sun"]["direction"])
        add("sun", sun(place["sun"]["irradiance"])).matrix_world = along.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*place.get("sky", [0, 0, 0]), 1)
    blender.world = world
    settings(blender, width, height)


def settings(blender, width, height):
    """No adaptive sampling, no clamping, a box filter, scenes kept in memory from render to render."""
    blender.render.engine = "CYCLES"
    render, cycles = blender.render, blender.cycles
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.threads_mode, render.threads = "FIXED", os.cpu_count()
    render.use_persistent_data = True
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    blender.view_settings.view_transform = "Raw"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.transmission_bounces = cycles.volume_bounces = 0
    cycles.caustics_reflective = cycles.caustics_refractive = False


def add(name, data):
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def mesh(part):
    """A part of a scene as a mesh, flat."""
    positions, faces = part["positions"], part["faces"]
    made = bpy.data.meshes.new(part["material"]["name"])
    made.vertices.add(len(positions))
    made.vertices.foreach_set("co", positions.ravel())
    made.loops.add(faces.size)
    made.loops.foreach_set("vertex_index", faces.ravel())
    made.polygons.add(len(faces))
    made.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    made.uv_layers.new().data.foreach_set("uv", part["uv"][faces.ravel()].ravel())
    made.update(calc_edges=True)
    made.materials.append(surface(part["material"]))
    made.shade_flat()
    return made


def surface(material):
    """The material of a part: matt, or with a rough layer above."""
    made = bpy.data.materials.new(material["name"])
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    kind, color = ("Diffuse", "Color") if material["roughness"] is None else ("Principled", "Base Color")
    bsdf, end = nodes.new(f"ShaderNodeBsdf{kind}"), nodes.new("ShaderNodeOutputMaterial")
    links.new(bsdf.outputs["BSDF"], end.inputs["Surface"])
    if material["roughness"] is not None:
        bsdf.inputs["Roughness"].default_value, bsdf.inputs["IOR"].default_value = material["roughness"], 1.5
    if material["image"]:
        texture = nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.load(material["image"], check_existing=True)
        links.new(texture.outputs["Color"], bsdf.inputs[color])
    else:
        bsdf.inputs[color].default_value = (*material["albedo"], 1)
    return made


def camera(fov):
    made = bpy.data.cameras.new("camera")
    made.sensor_fit, made.angle = "VERTICAL", math.radians(fov)
    made.clip_start, made.clip_end = 1e-3, 1e5
    return made


def looking(eye, target):
    """The pose of a camera that looks along its -Z, with Y up."""
    back = (mathutils.Vector(eye) - mathutils.Vector(target)).normalized()
    right = mathutils.Vector((0, 1, 0)).cross(back).normalized()
    columns = [right, back.cross(right), back, mathutils.Vector(eye)]
    rows = [[*(column[row] for column in columns)] for row in range(3)]
    return mathutils.Matrix([*rows, [0, 0, 0, 1]])


def turn(blender, place):
    """Lets the camera turn, with a shutter about the last frame, which becomes the scene's."""
    blender.camera.rotation_mode = "XYZ"  # pitch first, then yaw: linear in yaw, it turns about the vertical axis
    for frame in places.turn_ends(place):
        blender.camera.rotation_euler = (*(math.radians(angle) for angle in places.heading(place, frame)), 0)
        blender.camera.keyframe_insert("rotation_euler", frame=frame)
    for curve in blender.camera.animation_data.action.layers[0].strips[0].channelbags[0].fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    blender.frame_set(place["turn"]["frames"])
    render = blender.render
    render.use_motion_blur, render.motion_blur_shutter, render.motion_blur_position = True, place["turn"]["shutter"], "CENTER"


def focus(camera, focus, radius):
    """Depth of field of a lens of this radius, in the scene's units, which are metres there; a lens's length is in millimetres."""
    camera.dof.use_dof, camera.dof.focus_distance = True, focus
    camera.dof.aperture_fstop = camera.lens / 1000 / (2 * radius)


def panel(center, size, radiance):
    """A light that shines to one side; its watts are spread over its area and, by the cosine, over the half space."""
    made = bpy.data.lights.new("panel", "AREA")
    made.shape, made.size, made.size_y = "RECTANGLE", *size
    made.energy = radiance * math.pi * size[0] * size[1]
    return made


def sun(irradiance):
    """A sun whose shadows are sharp; `irradiance` of what faces it."""
    made = bpy.data.lights.new("sun", "SUN")
    made.energy, made.angle = irradiance, 0
    return made


# --- the work ---


def render(file, depth, samples, seed, denoising=None):
    """Seconds of one render, and its picture. `denoising`: one of `DENOISING`, or else none.

    Reading the picture takes a file, which is written after the clock stopped."""
    blender = bpy.context.scene
    cycles = blender.cycles
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = depth - 2
    cycles.samples, cycles.seed = samples, seed
    cycles.use_denoising = denoising in DENOISING
    if cycles.use_denoising:
        cycles.denoising_quality, cycles.denoising_prefilter = DENOISING[denoising]
        cycles.denoiser = "OPENIMAGEDENOISE"
        cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
    began = time.perf_counter()
    bpy.ops.render.render()
    seconds = time.perf_counter() - began
    bpy.data.images["Render Result"].save_render(str(file))
    image = bpy.data.images.load(str(file), check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    picture = pixels.reshape(height, width, -1)[::-1, :, :3].copy()
    bpy.data.images.remove(image)
    return seconds, picture


def reference(file, depth, samples, parts, path):
    pictures = [render(file, depth, samples, 1000 + part)[1] for part in range(parts)]
    np.save(path, np.array(pictures, np.float32))


def measured(job, file, name, depth, sampler, reference):
    truth = measure.Reference(reference).picture
    with measure.timed_turn():
        render(file, depth, 1, 0, sampler)  # builds
    for samples in job["samples"]:
        seconds, errors = [], []
        with measure.timed_turn():
            for seed in range(job["rounds"]):
                took, picture = render(file, depth, samples, seed, sampler)
                seconds.append(took)
                errors.append(measure.relative_rmse(picture, truth))
        row = {"renderer": name, "depth": depth, "setting": f"{samples} samples", "samples": samples}
        error = float(np.mean(errors))
        measure.append(job["rows"], row | {"seconds": min(seconds), "error": error})
        if error < measure.TARGET:
            break


def sequence(job, file, path, samples, seeds, name=""):
    """Writes denoised pictures of the job's `views`, each with a seed of its own; its row has the mean of their seconds."""
    seconds, pictures = [], []
    with measure.timed_turn():
        for (eye, target), seed in zip(job["views"], seeds):
            bpy.context.scene.camera.matrix_world = looking(eye, target)
            render(file, job["depth"], 1, 0, "denoised")  # builds
            taken = [render(file, job["depth"], samples, seed, "denoised") for _ in range(job["rounds"])]
            seconds.append(min(took for took, _ in taken))
            pictures.append(taken[-1][1])
    np.save(path, np.array(pictures))
    if "rows" in job:
        measure.append(job["rows"], {"name": name, "samples": samples, "seconds": float(np.mean(seconds))})


if __name__ == "__main__":
    main()
