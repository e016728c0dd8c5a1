# SPDX-License-Identifier: GPL-3.0-or-later
"""What images show: a file, a frame of a movie or a sequence, or tiles of UDIM as one mosaic.

Blender gives the pixels of an image's first tile, and of whichever frame it has loaded last. A texture of our own asks for frames, and an
image of our own for tiles. Both stay where they are, without pixels: removing one would tell viewports that the scene has changed, which
would have them export it again, and so on for ever.
"""

import math
import os
import re
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

OWN = ".Afterimage"
"""Name of our own texture and image. Blender lists none whose name begins with a dot, and saves none that nobody uses."""

MOVING = {"MOVIE", "SEQUENCE"}
"""Sources of images whose pictures follow each other."""

FIRST_TILE, TILES_IN_A_ROW = 1001, 10


def path_of(image):
    """The file of an image, wherever the library lies that it comes from."""
    import bpy

    return os.path.normpath(bpy.path.abspath(image.filepath_raw, library=image.library)) if image.filepath_raw else ""


def numbered(path, number):
    """The file of a sequence that has this number, by the path of any of them: the last digits before its ending count."""
    folder, name = os.path.split(path)
    stem, ending = os.path.splitext(name)
    digits = [match.span() for match in re.finditer("[0-9]+", stem)]
    first, last = digits[-1] if digits else (len(stem), len(stem))
    return os.path.join(folder, f"{stem[:first]}{max(number, 0):0{last - first}d}{stem[last:]}{ending}") if path else ""


def status_of(path):
    """What tells whether a file is the one that it was."""
    status = os.stat(path) if os.path.isfile(path) else None
    return [path, status.st_size, status.st_mtime_ns] if status else [path]


@dataclass(frozen=True)
class Clip:
    """How a node goes through the pictures of a movie or a sequence. Nothing of it belongs to Blender, so that it outlives a render."""

    name: str
    """Of the image."""
    path: str
    is_sequence: bool
    length: int
    start: int
    offset: int
    is_cyclic: bool

    @classmethod
    def of(cls, image, user):
        """That of an image and its user; None for an image that stands still, or without a user."""
        if user is None or image is None or image.source not in MOVING:
            return None
        times = user.frame_duration, user.frame_start, user.frame_offset, user.use_cyclic
        return cls(image.name_full, path_of(image), image.source == "SEQUENCE", *times)

    def number(self, time):
        """Number of the picture at a time, as Blender counts. It does so for renders also without Auto-Refresh."""
        if not self.length:
            return 0
        at = math.floor(time) - self.start + 1
        if self.is_cyclic:
            at = at % self.length or self.length
        return min(max(at, 0), self.length) + self.offset

    def at(self, time):
        """What is shown at a time, as a list to compare."""
        number = self.number(time)
        return [self.name, number, *status_of(numbered(self.path, number) if self.is_sequence else self.path)]


def clip_of(node):
    """The clip of a node; None of those that show no movie and no sequence."""
    return Clip.of(getattr(node, "image", None), getattr(node, "image_user", None))


@dataclass(frozen=True)
class Mosaic:
    """Tiles of UDIM as one picture: the first column and row, and how many there are of each."""

    left: int
    bottom: int
    columns: int
    rows: int

    @classmethod
    def of(cls, images):
        """One that has room for the tiles of all of these images; None if none of them has tiles."""
        tiles = {image: None for image in images if image is not None and image.source == "TILED"}
        places = [place_of(tile.number) for image in tiles for tile in image.tiles]
        if not places:
            return None
        (left, bottom), (right, top) = np.min(places, axis=0).tolist(), np.max(places, axis=0).tolist()
        return cls(left, bottom, right - left + 1, top - bottom + 1)

    @property
    def scale(self):
        """Factors on texture coordinates, of which it covers 0 to 1."""
        return 1 / self.columns, 1 / self.rows

    @property
    def offset(self):
        """What is added to them behind the factors."""
        return -self.left / self.columns, -self.bottom / self.rows

    @property
    def matrix(self):
        """Both, for (u, v, 1)."""
        return np.array([[self.scale[0], 0, self.offset[0]], [0, self.scale[1], self.offset[1]], [0, 0, 1]])

    def most(self, largest):
        """The longest side of a tile with which it has no more texels than a picture of this side."""
        return max(1, int(largest / math.sqrt(self.columns * self.rows)))


def place_of(number):
    """Column and row of a tile."""
    return (number - FIRST_TILE) % TILES_IN_A_ROW, (number - FIRST_TILE) // TILES_IN_A_ROW


def tile_file(path, number):
    """The file of a tile, by a path with a mark in its place."""
    column, row = place_of(number)
    return path.replace("<UDIM>", str(number)).replace("<UVTILE>", f"u{column + 1}_v{row + 1}")


@dataclass(frozen=True)
class Picture:
    """What an image shows."""

    name: str
    """Of the image."""
    image: object = field(compare=False)
    number: int | None = None
    """Of a movie's or sequence's picture."""
    mosaic: Mosaic | None = None
    """The tiles that it has, or all over which it is repeated."""

    @property
    def path(self):
        """Its file, where it is one file."""
        return numbered(path_of(self.image), self.number) if self.image.source == "SEQUENCE" else path_of(self.image)


class Pictures:
    """The pictures of one material, which share a mosaic if any of them has tiles. `read`: the Images that read them; `images`: all that it
    may show."""

    def __init__(self, read, images=()):
        self.read, self.mosaic, self.clips = read, Mosaic.of(images), set()
        """The clips of what was asked for."""

    def of(self, node, is_alone=False):
        """The picture that a node shows, over the mosaic of all, or of its image `is_alone`."""
        image, clip = node.image, clip_of(node)
        if clip is not None:
            self.clips.add(clip)
        mosaic = self.mosaic
        if is_alone or mosaic is None:
            mosaic = Mosaic.of([image])
        return Picture(image.name_full, image, None if clip is None else clip.number(self.read.frame), mosaic)

    def pixels(self, picture):
        """See Images."""
        return self.read.pixels(picture)


def own(collection, make):
    """Our own datablock of a collection, which is made if it is not there."""
    found = collection.get((OWN, None))
    if found is None:
        found = make()
        found.name = OWN
    return found


@contextmanager
def at_number(image, number):
    """Has an image show a picture of a movie or sequence as long as the context lasts. A number of None: as it is."""
    if number is None:
        yield
        return
    import bpy

    texture = own(bpy.data.textures, lambda: bpy.data.textures.new(OWN, "IMAGE"))
    texture.image = image
    try:
        texture.image_user.frame_current = number
        # reads the picture, also without a window, where `gl_load` ends Blender
        texture.evaluate((0, 0, 0))
        yield
    finally:
        texture.image = None


@contextmanager
def tiles_of(image):
    """Gives a function that opens a tile by its number, and returns an image of its pixels. It has them until the next call."""
    import bpy

    with files_of_tiles(image) as files:
        shown = None

        def opened(number):
            nonlocal shown
            shown = own(bpy.data.images, lambda: bpy.data.images.new(OWN, 1, 1))
            shown.source, shown.filepath = "FILE", files[number]
            shown.colorspace_settings.name, shown.alpha_mode = image.colorspace_settings.name, image.alpha_mode
            shown.reload()
            return shown

        try:
            yield opened
        finally:
            if shown is not None:
                shown.buffers_free()


@contextmanager
def files_of_tiles(image):
    """The files of tiles by their numbers. What is packed, or not saved, is written into a folder for as long as the context lasts."""
    # Blender 4.2 does not say which tiles it has made
    is_made = image.is_dirty or any(getattr(tile, "is_generated_tile", not image.filepath_raw) for tile in image.tiles)
    if not is_made and not image.packed_files:
        yield {tile.number: tile_file(path_of(image), tile.number) for tile in image.tiles}
        return
    with tempfile.TemporaryDirectory(prefix="afterimage-tiles-") as folder:
        if is_made:
            image.save(filepath=os.path.join(folder, "<UDIM>"), save_copy=True)
        else:
            for packed in image.packed_files:
                with open(os.path.join(folder, str(packed.tile_number)), "wb") as file:
                    file.write(packed.packed_file.data)
        yield {tile.number: os.path.join(folder, str(tile.number)) for tile in image.tiles}
