# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes: which of the renderer's layers each of Blender's is made of. docs/blender.md has the same table for people."""

from dataclasses import dataclass
from typing import Callable

import bpy
import numpy as np

from .export.light_groups import LightGroups
from .hashing import murmur3

FAR = 1e10
BLENDER_5 = bpy.app.version >= (5, 0, 0)


def to_z_up(vectors):
    """Vectors of the shot's axes in Blender's."""
    return np.stack([vectors[:, :, 0], -vectors[:, :, 2], vectors[:, :, 1]], axis=2)


def divided(light, albedo):
    """Light without the colour of its surface, as Blender's light passes are."""
    return np.where(albedo > 1e-4, light / np.maximum(albedo, 1e-4), light)


@dataclass(frozen=True)
class Pass:
    """A pass of Blender."""

    name: str
    channels: str
    kind: str
    wanted: Callable
    """Of the scene and the view layer."""
    layers: tuple
    make: Callable
    """Pixels, the top row first, of the layers."""


def _flag(name):
    return lambda scene, view_layer: getattr(view_layer, name, False)


def _data(scene, view_layer):
    return scene.afterimage.denoising_data


def _catcher(scene, view_layer):
    return getattr(getattr(view_layer, "cycles", None), "use_pass_shadow_catcher", False)


def _ones(layers):
    return np.ones_like(layers["albedo"])


def _passes():
    """All passes, by the names that this version of Blender gives them."""

    def named(new, old):
        return new if BLENDER_5 else old

    light = [
        ("Diffuse Direct", "DiffDir", "diffuse_direct", ("direct", "albedo"), lambda l: divided(l["direct"], l["albedo"])),
        ("Diffuse Indirect", "DiffInd", "diffuse_indirect", ("indirect", "albedo"), lambda l: divided(l["indirect"], l["albedo"])),
        ("Diffuse Color", "DiffCol", "diffuse_color", ("albedo",), lambda l: l["albedo"]),
        ("Glossy Direct", "GlossDir", "glossy_direct", ("specular",), lambda l: l["specular"]),
        ("Glossy Indirect", "GlossInd", "glossy_indirect", ("reflection",), lambda l: l["reflection"]),
        ("Glossy Color", "GlossCol", "glossy_color", ("albedo",), _ones),
        ("Transmission Direct", "TransDir", "transmission_direct", ("refraction",), lambda l: np.zeros_like(l["refraction"])),
        ("Transmission Indirect", "TransInd", "transmission_indirect", ("refraction",), lambda l: l["refraction"]),
        ("Transmission Color", "TransCol", "transmission_color", ("albedo",), _ones),
        ("Emission", "Emit", "emit", ("emission",), lambda l: l["emission"]),
        ("Environment", "Env", "environment", ("background",), lambda l: l["background"]),
        ("Ambient Occlusion", "AO", "ambient_occlusion", ("occlusion",), lambda l: np.repeat(l["occlusion"], 3, axis=2)),
    ]
    passes = [
        Pass("Depth", "Z", "VALUE", _flag("use_pass_z"), ("Z",), lambda l: l["Z"]),
        Pass("Position", "XYZ", "VECTOR", _flag("use_pass_position"), ("P",), lambda l: to_z_up(l["P"])),
        Pass("Normal", "XYZ", "VECTOR", _flag("use_pass_normal"), ("N",), lambda l: to_z_up(l["N"])),
        Pass("Vector", "XYZW", "VECTOR", _flag("use_pass_vector"), ("motion",), lambda l: l["motion"]),
        Pass("UV", "UVA", "VECTOR", _flag("use_pass_uv"), ("uv",), lambda l: l["uv"]),
        Pass("Mist", "Z", "VALUE", _flag("use_pass_mist"), ("mist",), lambda l: l["mist"]),
        Pass(named("Object Index", "IndexOB"), "X", "VALUE", _flag("use_pass_object_index"), ("object",), lambda l: l["object index"]),
        Pass(
            named("Material Index", "IndexMA"), "X", "VALUE", _flag("use_pass_material_index"), ("CryptoMaterial00",), lambda l: l["material index"]
        ),
        Pass("Shadow Catcher", "RGB", "COLOR", _catcher, ("catcher",), lambda l: l["catcher"]),
    ]
    passes += [Pass(named(new, old), "RGB", "COLOR", _flag(f"use_pass_{flag}"), layers, make) for new, old, flag, layers, make in light]
    for kind in ("Object", "Material"):
        for rank in range(3):
            name = f"Crypto{kind}{rank:02d}"
            flag, depth = f"use_pass_cryptomatte_{kind.lower()}", rank * 2
            wanted = lambda scene, view_layer, flag=flag, depth=depth: getattr(view_layer, flag) and view_layer.pass_cryptomatte_depth > depth
            passes.append(Pass(name, "rgba", "COLOR", wanted, (name,), lambda l, name=name: l[name]))
    passes += [
        Pass("Denoising Normal", "XYZ", "VECTOR", _data, ("denoise_normal",), lambda l: to_z_up(l["denoise_normal"])),
        Pass("Denoising Albedo", "RGB", "COLOR", _data, ("denoise_albedo",), lambda l: l["denoise_albedo"]),
        Pass("Denoising Depth", "Z", "VALUE", _data, ("Z",), lambda l: l["Z"]),
        Pass("Noisy Image", "RGBA", "COLOR", lambda s, v: s.afterimage.denoise, (), lambda l: l["RGBA"]),
    ]
    return passes


PASSES = _passes()


def wanted(scene, view_layer):
    """The passes that a view layer asks for, beside Combined."""
    return [each for each in PASSES if each.wanted(scene, view_layer)]


def light_groups(view_layer):
    """Names of the passes of light groups, from the names of these in the shot."""
    return {name: f"Combined_{group}" for group, name in LightGroups(view_layer).names.items()}


def layers(scene, view_layers):
    """Names of the layers that the passes of view layers are made of, as shot files select them."""
    names = [layer for view_layer in view_layers for each in wanted(scene, view_layer) for layer in each.layers]
    # Cryptomattes are selected without the digits
    names = [name[:-2] if name.startswith("Crypto") else name for name in names]
    return list(dict.fromkeys(names))


def register(engine, scene, view_layer):
    """Tells Blender which passes the engine has."""
    engine.register_pass(scene, view_layer, "Combined", 4, "RGBA", "COLOR")
    for each in wanted(scene, view_layer):
        engine.register_pass(scene, view_layer, each.name, len(each.channels), each.channels, each.kind)
    for name in light_groups(view_layer).values():
        engine.register_pass(scene, view_layer, name, 3, "RGB", "COLOR")


@dataclass(frozen=True)
class Numbers:
    """Pass indices of what a shot shows."""

    objects: list
    """Of models, in their order."""
    materials: dict
    """Of materials, by their names in the shot."""

    def layers(self, found):
        """Layers of indices, as far as what they follow from is among `found`: those of the things that a pixel shows, and 0 for the world."""
        out = {}
        if "object" in found:
            table = np.array([0, *self.objects], dtype=np.float32)
            # models that no object stands for have none
            out["object index"] = table[np.clip(found["object"], 0, len(table) - 1).astype(int)]
        if "CryptoMaterial00" in found:
            # the matte that covers most of the pixel
            ids = np.ascontiguousarray(found["CryptoMaterial00"][:, :, :1], dtype=np.float32).view(np.uint32)
            out["material index"] = np.zeros(ids.shape, dtype=np.float32)
            for name, index in self.materials.items():
                out["material index"][ids == murmur3(name.encode(), as_float=True)] = index
        return out


def combined(frame, denoise, is_transparent=False):
    """The picture. Beside a pass of shadows on catchers its alpha is that of the things before these alone, as in Cycles."""
    picture = frame.layers["RGBA"]
    if is_transparent and "catcher" in frame.layers:
        hidden = picture[:, :, 3:4] - 1 + frame.layers["catcher"].mean(axis=2, keepdims=True)
        picture = np.concatenate([picture[:, :, :3], np.clip(hidden, 0, 1)], axis=2)
    if denoise and "denoised" in frame.layers:
        return np.concatenate([frame.layers["denoised"], picture[:, :, 3:4]], axis=2)
    return picture


def fill(result, frame, scene, view_layer, numbers, of_groups):
    """Puts a frame into Blender's render result. `numbers`: pass indices of what the frame shows; `of_groups`: what each light group brings
    of it, by the group's name in the shot."""
    slots = result.layers[0].passes
    put(slots.find_by_name("Combined", ""), combined(frame, scene.afterimage.denoise, scene.render.film_transparent))
    found = {**frame.layers, **numbers.layers(frame.layers)}
    for each in wanted(scene, view_layer):
        slot = slots.find_by_name(each.name, "")
        if slot is not None:
            put(slot, each.make(found))
    for group, name in light_groups(view_layer).items():
        slot = slots.find_by_name(name, "")
        if slot is not None and group in of_groups:
            put(slot, of_groups[group])


def put(slot, pixels):
    """Writes pixels, the top row first, into a pass, whose first row is the bottom."""
    flat = np.ascontiguousarray(pixels[::-1], dtype=np.float32)
    slot.rect.foreach_set(flat.ravel())


def add_manifests(result, scene, view_layer, objects, materials):
    """Adds the names of Cryptomattes, so that Blender's Cryptomatte node knows them."""
    for kind, flag, names in (("Object", "object", objects), ("Material", "material", materials)):
        if not getattr(view_layer, f"use_pass_cryptomatte_{flag}"):
            continue
        name = f"{view_layer.name}.Crypto{kind}"
        key = f"{murmur3(name.encode()):08x}"[:7]
        entries = ",".join(f'"{escaped(each)}":"{murmur3(each.encode(), as_float=True):08x}"' for each in names)
        prefix = f"cryptomatte/{key}/"
        result.stamp_data_add_field(prefix + "name", name)
        result.stamp_data_add_field(prefix + "hash", "MurmurHash3_32")
        result.stamp_data_add_field(prefix + "conversion", "uint32_to_float32")
        result.stamp_data_add_field(prefix + "manifest", "{" + entries + "}")


def escaped(name):
    """A name within quotes of JSON."""
    return name.replace("\\", "\\\\").replace('"', '\\"')


def numbered(names):
    """Names of the mattes of models: those of one name are numbered from the second one on."""
    counts, out = {}, []
    for name in names:
        counts[name] = counts.get(name, 0) + 1
        out.append(name if counts[name] == 1 else f"{name} {counts[name]}")
    return out
