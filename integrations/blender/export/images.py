# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures: pixels of Blender's images, and their files in the shot's folder."""

import os
import shutil

import numpy as np

from . import files, pictures

READ_AS_THEY_ARE = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tga", ".tif", ".tiff")
LARGEST = 4096
"""The longest side of a picture that nodes change. One of tiles has as many texels at most."""
MISSING = (1.0, 0.0, 1.0, 1.0)
"""What Cycles shows where there is no picture."""


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
        self.frame = 1.0
        """The one of which pictures are."""

    def at(self, frame):
        """Has pictures be those of a frame from now on. Of movies those before are let go: they may be many."""
        self.frame = frame
        self.pixels_of = {picture: pixels for picture, pixels in self.pixels_of.items() if picture.number is None}

    def pixels(self, picture):
        """Pixels of a picture as (height, width, 4), linear, or None if it cannot be read."""
        if picture not in self.pixels_of:
            self.pixels_of[picture] = self._read(picture)
        return self.pixels_of[picture]

    def _read(self, picture):
        image, mosaic = picture.image, picture.mosaic
        if image.source == "TILED":
            return self._mosaic(image, mosaic)
        with pictures.at_number(image, picture.number):
            pixels = self._texels(image, mosaic.most(LARGEST) if mosaic else LARGEST)
            if pixels is None:
                self._tell_of_missing(image, picture.path)
            elif pixels.shape[0] < image.size[1]:
                width, height = image.size
                why = f", as it is repeated over {mosaic.columns}x{mosaic.rows} tiles" if mosaic else " where nodes change it"
                self.warnings.add(f"image `{image.name}`: {width}x{height} is made smaller{why}")
        return pixels if pixels is None or mosaic is None else np.tile(pixels, (mosaic.rows, mosaic.columns, 1))

    def _mosaic(self, image, mosaic):
        """Pixels of a mosaic of tiles. Where it has none it is as Cycles shows it."""
        found, is_smaller = {}, False
        try:
            with pictures.tiles_of(image) as opened:
                for tile in image.tiles:
                    shown = opened(tile.number)
                    texels = self._texels(shown, mosaic.most(LARGEST))
                    if texels is None:
                        self._tell_of_missing(image, pictures.tile_file(pictures.path_of(image), tile.number))
                        continue
                    is_smaller |= texels.shape[0] < shown.size[1]
                    found[pictures.place_of(tile.number)] = texels
        except (OSError, RuntimeError, TypeError) as error:
            # Blender 4.2 writes no copies of what is not saved
            self.warnings.add(f"image `{image.name}`: its tiles cannot be read ({error}). Save it")
        if not found:
            return None
        if is_smaller:
            self.warnings.add(f"image `{image.name}`: its tiles are made smaller, as {mosaic.columns}x{mosaic.rows} of them are one picture")
        height, width = (max(texels.shape[side] for texels in found.values()) for side in (0, 1))
        pixels = np.empty((mosaic.rows * height, mosaic.columns * width, 4), dtype=np.float32)
        pixels[:] = MISSING
        for (column, row), texels in found.items():
            low, left = (row - mosaic.bottom) * height, (column - mosaic.left) * width
            pixels[low : low + height, left : left + width] = sized(texels, height, width)
        return pixels

    def _tell_of_missing(self, image, path):
        self.warnings.add(
            f"image `{image.name}` cannot be read ({path or 'no file'}): its nodes' fallback is shown. Find it by"
            " File > External Data > Find Missing Files, or pack it"
        )

    @staticmethod
    def _texels(image, largest):
        """Pixels that an image has loaded, with no side that is longer than `largest`; None if there are none."""
        width, height = image.size
        if not width or not height:
            return None
        values = np.empty(width * height * image.channels, dtype=np.float32)
        image.pixels.foreach_get(values)
        values = values.reshape(height, width, image.channels)
        if max(width, height) > largest:
            step = -(-max(width, height) // largest)
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

    @staticmethod
    def is_file(picture):
        """Returns true if a picture is a file as it lies there."""
        image = picture.image
        is_one = image.source in {"FILE", "SEQUENCE"} and picture.mosaic is None
        return is_one and not image.packed_file and not image.is_dirty and os.path.isfile(picture.path)

    def is_plain(self, picture, colorspace):
        """Returns true if the file itself means what the nodes mean: it need only be copied."""
        is_meant = picture.image.colorspace_settings.name == colorspace
        return is_meant and self.is_file(picture) and picture.path.lower().endswith(READ_AS_THEY_ARE)

    def _target(self, name, ending):
        """A name in the folder that no other picture has, relative to the shot."""
        stem = safe(name)
        count = self.names.get(stem.lower(), 0)
        self.names[stem.lower()] = count + 1
        os.makedirs(os.path.join(self.folder, "textures"), exist_ok=True)
        return f"textures/{stem}{f'-{count + 1}' if count else ''}{ending}"

    def copy(self, picture):
        """Copies the file of a picture, and returns its name relative to the shot."""
        source = picture.path
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


def sized(values, height, width):
    """Values at another size, by the nearest texels."""
    if values.shape[:2] == (height, width):
        return values
    rows, columns = np.arange(height) * values.shape[0] // height, np.arange(width) * values.shape[1] // width
    return values[rows][:, columns]


def safe(name):
    """A name as a file may have it on any system."""
    kept = "".join(sign if sign.isalnum() or sign in "-_. " else "_" for sign in name).strip(". ")
    return kept[:80].strip(". ") or "unnamed"
