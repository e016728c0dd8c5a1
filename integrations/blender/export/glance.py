# SPDX-License-Identifier: GPL-3.0-or-later
"""Tells whether a frame of a scene is what it was when it was exported ahead of its time, without writing anything.

An export notes a digest of all that each of its frames shows. A glance at one frame, later, makes the same digest of the scene as it is then.
"""

import hashlib
from dataclasses import dataclass, replace

from .mesh_store import MeshStore
from .walk import Walk, times_of
from .warnings import Warnings


class Changed(Exception):
    """The scene shows what the export did not."""


@dataclass
class Noted:
    """What an export has noted of its frames. Nothing of it belongs to Blender, so that it outlives a render."""

    frames: dict
    """From a frame to the digest of what it shows."""
    deforming: set
    """Keys of meshes that deform: of these, normals follow from shapes."""
    materials: dict
    """From the name of a material to whether it is drawn, the colour attributes that it needs, and its clips (see pictures.py)."""

    @classmethod
    def of(cls, walk):
        """Notes what a walk has seen at its frames, which must have been watched."""
        deforming = {stored.key for stored in walk.meshes.stored if stored.deforms}
        materials = walk.meshes.materials
        known = {
            name: (surface.is_there, evaluator.asked if evaluator.painted else set(), evaluator.pictures.clips)
            for name, (surface, evaluator) in materials.read.items()
        }
        return cls({frame: digest_of(walk, frame, deforming) for frame in walk.frames}, deforming, known)

    def is_still(self, scene, depsgraph, settings, frame, set_frame):
        """Returns true if a frame shows what it showed when it was noted."""
        settings = replace(settings, frames=[frame])
        try:
            walk = Walk(scene, depsgraph, Glimpses(Recalled(self.materials)), settings, Warnings())
            walk.over(times_of([frame], settings.shutter), set_frame, lambda share: True)
        except Changed:
            return False
        return digest_of(walk, frame, self.deforming) == self.frames.get(frame)


class Recalled:
    """Stands for the materials of an export that are known already: their pictures are not read again."""

    images = None

    def __init__(self, known):
        self.known, self.seen = known, {}

    def surface(self, material):
        """What is known of a material."""
        name = material.name_full if material else ""
        if name not in self.known:
            raise Changed()
        if material:
            self.seen[name] = material.original
        return self.known[name]

    def is_there(self, material):
        """See Materials."""
        return self.surface(material)[0]

    def attributes(self, materials):
        """See Materials."""
        return {name for material in materials if material for name in self.surface(material)[1]}

    def shown(self, material):
        """Digests tell whether that has changed."""
        return []

    def at(self, frame):
        """No picture is read."""

    def clips(self, material, time):
        """See Materials."""
        return sorted(clip.at(time) for clip in self.surface(material)[2])

    def originals(self):
        """See Materials."""
        return list(self.seen.values())

    def forget(self):
        """Nothing is to be read again."""


class Glimpses(MeshStore):
    """Meshes that are looked at, and never written: those of each time by themselves."""

    is_watched = True

    def __init__(self, materials):
        super().__init__(None, materials, 1.0, Warnings())

    def _read(self, instance, item, materials, before):
        return super()._read(instance, item, materials, None)


def digest_of(walk, frame, deforming):
    """Digest of all that a walk has seen while the shutter of a frame is open."""
    total = hashlib.blake2b(repr(sorted(map(repr, walk.states.get(frame, [])))).encode(), digest_size=16)
    for time in times_of([frame], walk.settings.shutter):
        total.update(repr([key for key in walk.camera_keys if key[0] == time]).encode())
        total.update(repr(sorted((repr(key), fixed, keys.get(time)) for key, (fixed, keys) in walk.lights.items() if time in keys)).encode())
        # in whatever order the dependency graph has them
        parts = [digest_of_placed(key, placed, time, deforming) for key, placed in walk.placed.items() if time in placed.mesh]
        total.update(sum(int.from_bytes(part, "little") for part in parts).to_bytes(32, "little"))
    return total.digest()


def digest_of_placed(key, placed, time, deforming):
    """Digest of one copy of a mesh at a time."""
    stored = placed.mesh[time]
    digest = hashlib.blake2b(repr((key, placed.name, placed.index, stored.key, placed.seen[time].keys(), placed.seen[time].links)).encode(), digest_size=16)
    digest.update(stored.shape_at(time) + stored.looks + (b"" if stored.key in deforming else stored.normals))
    digest.update(placed.matrices[time].tobytes())
    return digest.digest()
