"""Renders with Mitsuba 3, in a process of its own: `python -m peers.mitsuba_worker JOB.json`.

The job is a dictionary: `place` (of `places`), `variant`, and one of

- `reference`: `{"depth", "samples", "parts", "path"}`; writes an array of `parts` pictures of `samples` each;
- `measure`: a list of `{"depth", "sampler", "reference", "name"}`, with `samples`, `rounds` and `rows`: for each number of
  samples a pixel a line in the file `rows`, until the error is below the target.

Depths are Mitsuba's: 2 is direct light, 3 is one bounce more.
"""

import json
import sys
import time

import mitsuba as mi
import numpy as np

from . import measure, scene

CHUNK = 64  # samples a pixel that are rendered at once: more do not fit into memory


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        job = json.load(file)
    mi.set_variant(job["variant"])
    mi.set_log_level(mi.LogLevel.Error)
    if "reference" in job:
        reference(job["place"], **job["reference"])
    for series in job.get("measure", []):
        measured(job, **series)


# --- the scene ---


def load(place, sampler):
    """The scene of a place, as Mitsuba's."""
    described = {"type": "scene", "sensor": sensor(place, sampler)}
    for number, part in enumerate(scene.load(place["scene"])):
        described[f"part{number}"] = mesh(part)
    if "panel" in place:
        described["panel"] = panel(**place["panel"])
    if "sky" in place:
        described["sky"] = {"type": "constant", "radiance": color(place["sky"])}
    return mi.load_dict(described)


def color(rgb):
    return {"type": "rgb", "value": rgb}


def sensor(place, sampler):
    width, height = place["size"]
    look_at = mi.ScalarTransform4f().look_at(origin=place["eye"], target=place["target"], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32"}
    film["rfilter"] = {"type": "box"}
    kind = {"type": "perspective"}
    if "lens" in place:
        kind = {"type": "thinlens", "aperture_radius": place["lens"]["radius"], "focus_distance": place["lens"]["focus"]}
    return kind | {
        "fov": place["fov"],
        "fov_axis": "y",
        "near_clip": 1e-3,
        "to_world": look_at,
        "film": film,
        "sampler": {"type": sampler},
    }


def mesh(part):
    """A part of a scene as a mesh without normals."""
    material = part["material"]
    reflectance = color(material["albedo"])
    if material["image"]:
        reflectance = {"type": "bitmap", "filename": material["image"]}
    inner = {"type": "diffuse", "reflectance": reflectance}
    if material["roughness"] is not None:
        # `specular` 0.5 is an index of refraction of 1.5
        inner = {"type": "principled", "base_color": reflectance, "roughness": material["roughness"], "specular": 0.5}
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "twosided", "inner": inner})
    if any(material["emission"]):
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": color(material["emission"])})
    positions, uv, faces = part["positions"], part["uv"], part["faces"]
    made = mi.Mesh(material["name"], len(positions), len(faces), properties, has_vertex_texcoords=True)
    values = mi.traverse(made)
    values["vertex_positions"] = positions.ravel()
    # the first row of an image is its upper edge here, and v = 1 in an OBJ
    values["vertex_texcoords"] = (uv * [1, -1] + [0, 1]).astype(np.float32).ravel()
    values["faces"] = faces.astype(np.uint32).ravel()
    values.update()
    return made


def panel(center, size, radiance):
    """A rectangle that shines down. It is a black surface to bounced rays: Mitsuba's emitters are surfaces."""
    place = mi.ScalarTransform4f()
    place = place.look_at(origin=center, target=[center[0], center[1] - 1, center[2]], up=[0, 0, 1])
    return {
        "type": "rectangle",
        "to_world": place @ mi.ScalarTransform4f().scale([size[0] / 2, size[1] / 2, 1]),
        "emitter": {"type": "area", "radiance": color([radiance] * 3)},
        "bsdf": {"type": "diffuse", "reflectance": color([0.0] * 3)},
    }


def path_tracer(depth, place):
    """Paths of at most `depth` segments; never ended by chance, as Afterimage's are not."""
    hidden = "panel" in place
    return mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 1000, "hide_emitters": hidden})


# --- the work ---


def reference(place, depth, samples, parts, path):
    loaded, integrator = load(place, "independent"), path_tracer(depth, place)
    pictures = []
    for part in range(parts):
        chunks = -(-samples // CHUNK)
        seeds = range(1000 + part * chunks, 1000 + (part + 1) * chunks)
        chunk = min(samples, CHUNK)
        rendered = [np.array(mi.render(loaded, integrator=integrator, spp=chunk, seed=seed)) for seed in seeds]
        pictures.append(np.mean(rendered, axis=0, dtype=np.float64))
    np.save(path, np.array(pictures, np.float32))


def measured(job, name, depth, sampler, reference):
    place, rounds = job["place"], job["rounds"]
    loaded, integrator = load(place, sampler), path_tracer(depth, place)
    truth = measure.Reference(reference).picture
    for samples in job["samples"]:
        seconds, errors = [], []
        with measure.timed_turn():
            for seed in range(rounds + 1):  # the first round compiles
                began = time.perf_counter()
                picture = np.array(mi.render(loaded, integrator=integrator, spp=samples, seed=seed))
                if seed > 0:
                    seconds.append(time.perf_counter() - began)
                    errors.append(measure.relative_rmse(picture, truth))
        row = {"renderer": name, "depth": depth, "setting": f"{samples} samples", "samples": samples}
        error = float(np.mean(errors))
        measure.append(job["rows"], row | {"seconds": min(seconds), "error": error})
        if error < measure.TARGET:
            break


if __name__ == "__main__":
    main()
