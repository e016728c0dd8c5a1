# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: surfaces to [[material]] tables and their pictures."""

import numpy as np

from . import toml
from .images import safe
from .nodes import Evaluator
from .surfaces import Surface, surface_of


class Materials:
    """The materials of an export. Each is written when a mesh uses it first."""

    def __init__(self, images, warnings):
        self.images, self.warnings = images, warnings
        self.names, self.read, self.tables = {}, {}, {}

    def surface(self, material):
        """The surface of a material, and its evaluator. None is Blender's default grey."""
        key = material.name_full if material else ""
        if key not in self.read:
            evaluator = Evaluator(self.images)
            if material is None:
                surface = Surface()
            else:
                try:
                    surface = surface_of(evaluator, material)
                except (AttributeError, IndexError, KeyError, TypeError, ValueError, RuntimeError) as error:
                    # a node of an unknown version must not end the export
                    surface = Surface()
                    evaluator.said = [f"cannot be read ({type(error).__name__}: {error}) and is shown in grey"]
                if material.node_tree and material.node_tree.animation_data:
                    evaluator.say("its animation is left out: it is shown as at the first frame")
            self.read[key] = (surface, evaluator)
        return self.read[key]

    def name(self, material):
        """The name of a material in the shot, which is also that of the files of its meshes: as Blender's, if files may have it."""
        key = material.name_full if material else ""
        if key not in self.names:
            stem = safe(material.name if material else "default")
            taken = {name.lower() for name in self.names.values()}
            name, count = stem, 1
            while name.lower() in taken:
                count += 1
                name = f"{stem} {count}"
            self.names[key] = name
        return self.names[key]

    def uv(self, material):
        """Name of the UV map of a material's pictures and the mapping of (u, v, 1); None without pictures."""
        return self.surface(material)[1].uv

    def has_bump(self, material):
        """Returns true if it needs to know how large a texture is on its mesh."""
        return self.surface(material)[0].bump is not None

    def use(self, material, density=1.0):
        """Writes the table of a material, once. `density`: units of the world in one unit of the texture."""
        name = self.name(material)
        if name in self.tables:
            return
        surface, evaluator = self.surface(material)
        values = {"name": name, **self._values(name, surface, evaluator, density)}
        self.tables[name] = toml.table("[[material]]", values)
        self.warnings.add_for(f"material `{material.name if material else 'default'}`", evaluator.said)

    def _values(self, name, surface, evaluator, density):
        """Keys of the [[material]]."""
        values = {}
        self._alpha(name, surface, values)
        self._emission(name, surface, values)
        if float(surface.transmission.mean()) > 0.5:
            return {**self._glass(surface, evaluator), **values}
        self._base(name, surface, evaluator, values)
        if float(surface.specular.max()) == 0 and float(surface.metallic.max()) == 0:
            values["illum"] = 1
            values["ks"] = [0.0, 0.0, 0.0]
        else:
            self._number(name, "roughness", surface.roughness, "pr", evaluator, values)
            self._number(name, "metallic", surface.metallic, "pm", evaluator, values)
            values["ni"] = index_of(float(surface.ior.mean()), float(surface.specular.mean()))
        self._normal(name, surface, evaluator, density, values)
        return values

    def _glass(self, surface, evaluator):
        """Glass is clear, smooth and white: that is what the renderer has."""
        if float(surface.roughness.mean()) > 0.05:
            evaluator.say("its rough glass is shown as smooth")
        if float(surface.base.min()) < 0.95:
            evaluator.say("its tinted glass is shown as white")
        if float(surface.transmission.mean()) < 0.95:
            evaluator.say("its partial transmission is shown as full")
        if surface.base.shape[:2] != (1, 1) or surface.normal is not None or surface.bump:
            evaluator.say("pictures on glass are left out")
        return {"illum": 7, "kd": [0.0, 0.0, 0.0], "ks": [1.0, 1.0, 1.0], "ni": float(surface.ior.mean())}

    def _base(self, name, surface, evaluator, values):
        base = surface.base
        if base.shape[:2] == (1, 1):
            values["kd"] = np.clip(base[0, 0], 0, 1).tolist()
            return
        image = self._image(evaluator, base)
        clear = image and (self.images.pixels(image)[:, :, 3] >= 0.5).all()
        if clear and self.images.is_plain(image, "sRGB"):
            values["map_kd"] = self.images.copy(image)
        else:
            values["map_kd"] = self.images.write_color(f"{name} base", base)
        values["kd"] = [1.0, 1.0, 1.0]

    @staticmethod
    def _image(evaluator, value):
        """The image that a value shows unchanged."""
        import bpy

        name = evaluator.image_of(value)
        return next((image for image in bpy.data.images if image.name_full == name), None) if name else None

    def _alpha(self, name, surface, values):
        alpha = surface.alpha
        if alpha.shape[:2] == (1, 1):
            if float(alpha.mean()) < 1:
                values["d"] = max(0.0, float(alpha.mean()))
        elif float(alpha.min()) < 0.999:
            values["map_d"] = self.images.write_numbers(f"{name} alpha", alpha)

    def _emission(self, name, surface, values):
        light = np.clip(surface.emission, 0, 60000)
        if light.shape[:2] == (1, 1):
            values["ke"] = light[0, 0].tolist() if float(light.max()) > 0 else None
            return
        top = float(light.max())
        if top > 0:
            values["map_ke"] = self.images.write_color(f"{name} emission", light / top)
            values["ke"] = [top] * 3

    def _number(self, name, what, value, key, evaluator, values):
        value = np.clip(value, 0, 1)
        if value.shape[:2] == (1, 1):
            values[key] = float(value.mean())
            return
        values[f"map_{key}"] = self.images.write_numbers(f"{name} {what}", value)
        values[key] = 1.0

    def _normal(self, name, surface, evaluator, density, values):
        if surface.bump is not None:
            height, slope = surface.bump
            values["norm"] = self.images.write_numbers(f"{name} bump", normals_of(height[:, :, 0], slope / max(density, 1e-9)))
        elif surface.normal is not None:
            image = self._image(evaluator, surface.normal)
            if image and self.images.is_plain(image, "Non-Color"):
                values["norm"] = self.images.copy(image)
            else:
                values["norm"] = self.images.write_numbers(f"{name} normal", surface.normal)


def index_of(ior, specular):
    """The index of refraction of what reflects `specular` times what `ior` does at right angles."""
    head_on = min(((ior - 1) / (ior + 1)) ** 2 * specular, 0.9)
    root = max(np.sqrt(head_on), 0.005)
    return float((1 + root) / (1 - root))


def normals_of(height, slope):
    """Directions from 0 to 1 of heights that repeat. `slope`: how much a height of 1 rises, in units of the texture's own size."""
    rows, columns = height.shape
    along = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) * (columns / 2) * slope
    up = (np.roll(height, -1, axis=0) - np.roll(height, 1, axis=0)) * (rows / 2) * slope
    direction = np.stack([-along, -up, np.ones_like(height)], axis=2)
    return (direction / np.linalg.norm(direction, axis=2, keepdims=True) * 0.5 + 0.5).astype(np.float32)
