"""Reads a file and renders a small frame of it, in a process of its own: `python -m peers.loading_worker JOB.json`.

The job is that of `loading`: `renderer`, `kind`, `file`, `size`, `eye`, `target`, `fov` (vertical, degrees). One sample a pixel.
"""

import json
import math
import sys


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        job = json.load(file)
    {"mitsuba": by_mitsuba, "cycles": by_cycles}[job["renderer"]](job)


def by_mitsuba(job):
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    width, height = job["size"]
    made = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct"},
            "sensor": {
                "type": "perspective",
                "fov": job["fov"],
                "fov_axis": "y",
                "to_world": mi.ScalarTransform4f().look_at(origin=job["eye"], target=job["target"], up=[0, 1, 0]),
                "film": {"type": "hdrfilm", "width": width, "height": height},
            },
            "mesh": {"type": job["kind"], "filename": job["file"], "face_normals": True},
            "light": {"type": "point", "position": [0.5, 2.0, 0.5], "intensity": {"type": "rgb", "value": 4.0}},
        }
    )
    assert mi.render(made, spp=1).numpy().max() > 0, "the picture is black"


def by_cycles(job):
    import bpy

    from . import cycles_worker

    bpy.ops.wm.read_factory_settings(use_empty=True)
    read = {"obj": bpy.ops.wm.obj_import, "ply": bpy.ops.wm.ply_import, "glb": bpy.ops.import_scene.gltf}[job["kind"]]
    # files have Y up, as the camera here
    axes = {} if job["kind"] == "glb" else {"forward_axis": "Y", "up_axis": "Z"}
    read(filepath=job["file"], **axes)
    scene = bpy.context.scene
    scene.camera = cycles_worker.add("camera", cycles_worker.camera(job["fov"]))
    pose = cycles_worker.looking(job["eye"], job["target"])
    place = (0.5, 2.0, 0.5)
    if job["kind"] == "glb":
        # this reader turns Y up into Z up
        import mathutils

        turned = mathutils.Matrix.Rotation(math.radians(90), 4, "X")
        pose, place = turned @ pose, turned @ mathutils.Vector(place)
    scene.camera.matrix_world = pose
    light = bpy.data.lights.new("light", "POINT")
    light.energy = 200
    cycles_worker.add("light", light).location = place
    cycles_worker.settings(scene, *job["size"])
    scene.cycles.samples = 1
    bpy.ops.render.render()


if __name__ == "__main__":
    main()
