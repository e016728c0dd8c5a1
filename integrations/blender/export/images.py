# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures: pixels of Blender's images, and their files in the shot's folder."""

import os
import shutil

import numpy as np

from . import files

READ_AS_THEY_ARE = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tga", ".tif", ".tiff")
LARGEST = 4096


def to_linear(encoded):
    """sRGB to linear."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((np.maximum(encoded, 0.0) + 0.055) / 1.055) ** 2.4).astype(np.float32)


def to_srgb(linear):
    """Linear to sRGB, from 0 to 1."""
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


class Images:
    """The pictures of an export. Pixels have row 0 at the bottom here, as v counts upwards; files have it at the top."""

    def __init__(self, folder, warnings):
        self.folder, self.warnings = folder, warnings
        self.pixels_of, self.sources, self.names = {}, {}, {}

    def pixels(self, image):
        """Pixels of an image as (height, width, 4), linear, or None if it cannot be read."""
        key = image.name_full
        if key not in self.pixels_of:
            self.pixels_of[key] = self._read(image)
        return self.pixels_of[key]

    def _read(self, image):
        if image.source in {"MOVIE", "SEQUENCE"}:
            self.warnings.add(f"image `{image.name}`: of movies and sequences one picture is shown")
        if image.source == "TILED":
            self.warnings.add(f"image `{image.name}`: of UDIM tiles the first one is shown everywhere")
        width, height = image.size
        if not width or not height:
            self.warnings.add(
                f"image `{image.name}` cannot be read ({image.filepath or 'no file'}): its nodes' fallback is shown. Find it by"
                " File > External Data > Find Missing Files, or pack it"
            )
            return None
        values = np.empty(width * height * image.channels, dtype=np.float32)
        image.pixels.foreach_get(values)
        values = values.reshape(height, width, image.channels)
        if max(width, height) > LARGEST:
            step = -(-max(width, height) // LARGEST)
            self.warnings.add(f"image `{image.name}`: {width}x{height} is made smaller where nodes change it")
            # at once, and as a copy, so that nothing of its whole size is kept
            values = values[::step, ::step].copy()
        pixels = np.ones((*values.shape[:2], 4), dtype=np.float32)
        if image.channels >= 3:
            pixels[:, :, : image.channels] = values
        else:
            pixels[:, :, :3] = values[:, :, :1]
        if image.channels == 2:
            pixels[:, :, 3] = values[:, :, 1]
        if image.alpha_mode == "NONE":
            pixels[:, :, 3] = 1
        # pixels of byte images are as the file has them; those of float images are linear already
        if not image.is_float and image.colorspace_settings.name == "sRGB":
            pixels[:, :, :3] = to_linear(pixels[:, :, :3])
        return pixels

    def is_plain(self, image, colorspace):
        """Returns true if the file itself means what the nodes mean: it need only be copied."""
        path = path_of(image)
        return (
            image.source == "FILE"
            and not image.packed_file
            and not image.is_dirty
            and image.colorspace_settings.name == colorspace
            and path.lower().endswith(READ_AS_THEY_ARE)
            and os.path.isfile(path)
        )

    def _target(self, name, ending):
        """A name in the folder that no other picture has, relative to the shot."""
        stem = safe(name)
        count = self.names.get(stem.lower(), 0)
        self.names[stem.lower()] = count + 1
        os.makedirs(os.path.join(self.folder, "textures"), exist_ok=True)
        return f"textures/{stem}{f'-{count + 1}' if count else ''}{ending}"

    def copy(self, image):
        """Copies the file of an image, and returns its name relative to the shot."""
        source = path_of(image)
        if source not in self.sources:
            stem, ending = os.path.splitext(os.path.basename(source))
            target = self._target(stem, ending.lower())
            path = os.path.join(self.folder, target)
            # a picture may lie there already: that of a scene beside its shot. Never truncated, for Blender may be reading it
            if not (os.path.exists(path) and os.path.samefile(source, path)):
                with open(source, "rb") as picture:
                    files.whole(path, lambda file: shutil.copyfileobj(picture, file))
            self.sources[source] = target
        return self.sources[source]

    def write_color(self, name, pixels):
        """Writes linear colours as an sRGB picture."""
        return self._write(name, to_srgb(pixels[:, :, :3]))

    def write_numbers(self, name, pixels):
        """Writes numbers from 0 to 1 (one or three a texel) as they are."""
        return self._write(name, np.clip(pixels, 0, 1))

    def _write(self, name, values):
        target = self._target(name, ".png")
        texels = (values * 255 + 0.5).astype(np.uint8)
        if texels.shape[2] == 2:
            texels = texels[:, :, :1]
        files.write_png(os.path.join(self.folder, target), np.ascontiguousarray(texels[::-1]))
        return target

    def write_light(self, name, pixels):
        """Writes linear light, row 0 at the bottom, as OpenEXR."""
        target = self._target(name, ".exr")
        light = np.nan_to_num(np.clip(pixels[:, :, :3], 0, 1e30), nan=0.0, posinf=1e30)
        files.write_exr(os.path.join(self.folder, target), np.ascontiguousarray(light[::-1], dtype="<f4"))
        return target


def path_of(image):
    """The file of an image, wherever the library lies that it comes from."""
    import bpy

    return os.path.normpath(bpy.path.abspath(image.filepath_raw, library=image.library)) if image.filepath_raw else ""


def safe(name):
    """A name as a file may have it on any system."""
    kept = "".join(sign if sign.isalnum() or sign in "-_. " else "_" for sign in name).strip(". ")
    return kept[:80].strip(". ") or "unnamed"
