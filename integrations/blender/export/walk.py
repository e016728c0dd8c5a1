# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks over what the dependency graph shows, at one time after the other, and notes where everything is."""

import math

import numpy as np

from . import camera as cameras
from . import grids, lights, strands
from .at_rest import AtRest, may_change, state_of, surroundings_of, values_of
from .camera import TO_Y_UP
from .clipping import Clipping
from .meshes import FARTHEST
from .visibility import Visibility
from .warnings import Cancelled, ExportError
from .world import World

STEPS_A_FRAME = 4
"""Places of what moves in each frame with motion blur. They are evenly spaced, as samples of point caches must be."""

LEAST_SCALE = 1e-8
"""What is smaller by more is not there: the renderer takes factors down to 1e-9."""
LARGEST_SCALE = 1e9
"""What is scaled by more the renderer refuses."""
LEAST_THICKNESS = 1e-6
"""Of flat things, beside their largest scale."""


def times_of(frames, shutter):
    """Times at which the scene is evaluated, rising: the frames, or steps around them where the shutter is open."""
    if shutter is None:
        return [float(frame) for frame in sorted(frames)]
    steps = set()
    for frame in frames:
        first, last = math.floor((frame + shutter[0]) * STEPS_A_FRAME), math.ceil((frame + shutter[1]) * STEPS_A_FRAME)
        steps.update(range(first, last + 1))
        steps.add(frame * STEPS_A_FRAME)
    return [step / STEPS_A_FRAME for step in sorted(steps)]


def thickened(linear):
    """A linear map that is not flat, for the renderer takes no other: what Blender shows flat becomes next to flat. None where nothing is left."""
    # some thousand of them a frame: plain numbers take a tenth of the time of arrays
    (a, b, c), (d, e, f), (g, h, i) = linear.tolist()
    size = math.sqrt(a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i)
    if size < LEAST_SCALE:
        return None
    if abs(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)) > 1e-12 * size**3:
        return linear
    out, sizes, back = np.linalg.svd(linear)
    return out @ np.diag(np.maximum(sizes, max(sizes[0] * LEAST_THICKNESS, LEAST_SCALE))) @ back


def is_taken(matrix, reach):
    """Returns true if the renderer takes a mesh whose coordinates reach so far, where a matrix puts it."""
    rows = matrix.tolist()
    largest = 3 * max(abs(value) for row in rows[:3] for value in row[:3])
    return largest <= LARGEST_SCALE and largest * reach + max(abs(row[3]) for row in rows[:3]) <= FARTHEST


def is_of_gas(item):
    """Returns true if an object is a domain in which smoke and fire are simulated: its density varies."""
    domains = (modifier for modifier in item.modifiers if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN")
    return any(modifier.show_render and modifier.domain_settings.domain_type == "GAS" for modifier in domains)


def random_number(instance, item):
    """Number of an object from 0 to 1, by which copies differ, as Cycles has it: of objects that are no instances a hash of the name."""
    number = instance.random_id if instance.is_instance else hashed(name_number(item.name), 0)
    return (number & 0xFFFFFFFF) / 0xFFFFFFFF


def name_number(name):
    """Number of a name."""
    number = 0
    for byte in name.encode():
        number = (number * 37 + byte) & 0xFFFFFFFF
    return number


def hashed(first, second):
    """Hash of two whole numbers of 32 bits (B. Jenkins, lookup3, 2006)."""

    def turned(value, bits):
        return (value << bits | value >> (32 - bits)) & 0xFFFFFFFF

    c = (0xDEADBEEF + (2 << 2) + 13) & 0xFFFFFFFF
    a, b = (c + first) & 0xFFFFFFFF, (c + second) & 0xFFFFFFFF
    c = ((c ^ b) - turned(b, 14)) & 0xFFFFFFFF
    a = ((a ^ c) - turned(c, 11)) & 0xFFFFFFFF
    b = ((b ^ a) - turned(a, 25)) & 0xFFFFFFFF
    c = ((c ^ b) - turned(b, 16)) & 0xFFFFFFFF
    a = ((a ^ c) - turned(c, 4)) & 0xFFFFFFFF
    b = ((b ^ a) - turned(a, 14)) & 0xFFFFFFFF
    return ((c ^ b) - turned(b, 24)) & 0xFFFFFFFF


def with_group(tables, group):
    """Tables of a world, whose light is in a group: its sky and its suns."""
    out = []
    for table in tables:
        head, _, rest = table.partition("\n")
        key = {"[environment]": "light_group", "[[light]]": "group"}.get(head)
        out.append(f'{head}\n{key} = "{group}"\n{rest}' if key else table)
    return out


class Placed:
    """One copy of a mesh, where it is and to which rays it shows itself: `matrices` from times to row-major 4x4 matrices in the shot's axes."""

    __slots__ = ("name", "random", "index", "mesh", "matrices", "seen")

    def __init__(self, name, random, index=0):
        self.name, self.random, self.index, self.mesh, self.matrices, self.seen = name, random, index, {}, {}, {}

    def is_before_the_camera(self, time):
        """Returns true if it is there at a time, and the camera is to see it."""
        return time in self.mesh and "camera" not in self.seen[time].hidden


class Walk:
    """What was seen at all times so far."""

    def __init__(self, scene, depsgraph, meshes, settings, warnings):
        self.scene, self.depsgraph, self.meshes = scene, depsgraph, meshes
        self.settings, self.warnings = settings, warnings
        self.frames = sorted(settings.frames)
        self.whole = set(self.frames)
        self.placed, self.lights, self.camera_keys, self.times = {}, {}, [], []
        self.world, self.rest, self.clipping = None, AtRest(warnings), Clipping()
        self.states, self.settled = {}, {}
        self.layer = depsgraph.view_layer
        self.visibility = Visibility(scene, self.layer, warnings)
        self.strands = strands.StrandStore(meshes, warnings)
        self.volumes = grids.VolumeStore(meshes, warnings)

    def over(self, times, set_frame, progress):
        """Evaluates the scene at each time. `progress(share)` returns false to cancel."""
        for index, time in enumerate(times):
            share, whole = index / len(times), math.floor(time)
            if not progress(share):
                raise Cancelled()
            set_frame(whole, time - whole)
            self.at(time, lambda share=share: progress(share))
            if self.settings.ends_at_changes and self.rest.changed:
                self._end_before(time)
                break
        self.rest.tell(self.settings.ends_at_changes)
        self.clipping.drop(self.camera_keys)
        return self

    def _end_before(self, time):
        """Forgets the frames from a time on, and what no other frame needs."""
        self.frames = [frame for frame in self.frames if frame < time]
        kept = set(times_of(self.frames, self.settings.shutter))
        self.times = [each for each in self.times if each in kept]
        self.camera_keys = [key for key in self.camera_keys if key[0] in kept]

    def at(self, time, goes_on):
        """Notes the scene as it is now. `goes_on()` returns false to cancel."""
        self.times.append(time)
        # what has no tracks is as it is at frames, and not as it is when the shutter opens
        is_frame = time in self.whole
        if time == self.frames[0]:
            self.meshes.materials.forget()
        if is_frame or time < self.frames[0]:
            self.meshes.materials.at(max(time, self.frames[0]))
        if is_frame:
            self._world(time, goes_on)
        override = self.layer.material_override
        self.meshes.override = override and override.evaluated_get(self.depsgraph)
        self.camera_keys.append((time, *self._camera(time)))
        seen, seen_lights = set(), set()
        self.meshes.begin(time)
        self.visibility.begin()
        for instance in self.depsgraph.object_instances:
            item = instance.object
            if item.type == "LIGHT":
                self._light(time, instance, seen_lights)
            elif item.type == "MESH":
                if instance.show_particles:
                    self._hair(time, instance, item, seen)
                # curves, text and metaballs come twice: as themselves, and as an instance of what is shown of them, a mesh
                if instance.show_self and self.layer.use_solid:
                    self._mesh(time, instance, item, seen)
            elif item.type == "CURVES":
                if instance.show_self:
                    self._hair_curves(time, instance, item, seen)
            elif item.type == "VOLUME":
                if instance.show_self:
                    self._volume(time, instance, item, seen)
            elif item.type in {"POINTCLOUD", "GPENCIL", "GREASEPENCIL"}:
                self.warnings.add(f"object `{item.name}` is left out: {item.type.lower()} is not rendered. Convert it to a mesh")
        self.meshes.end()
        if self.settings.camera is None:
            camera = self._camera_at(time).evaluated_get(self.depsgraph)
            before = [placed for placed in self.placed.values() if placed.is_before_the_camera(time)]
            self.clipping.see(camera, self.settings.size, before, time)
        if is_frame:
            self._materials(time)

    def _materials(self, time):
        """Notes what materials are like at a frame."""
        materials = self.meshes.materials
        for material in materials.originals():
            evaluated = material.evaluated_get(self.depsgraph)
            materials.surface(evaluated)
            changes, clips = may_change(material), materials.clips(evaluated, time)
            if changes or clips:
                shown = materials.shown(evaluated) if changes else clips
                self.rest.see(material.name_full, f"material `{material.name}`", time, {"": shown})
            if self.meshes.is_watched:
                self._watch(time, evaluated, changes)
                self.states[time].append(clips)

    def _world(self, time, goes_on):
        """Notes the world. The original does not change from frame to frame. A view layer may have another one, or none."""
        found = (getattr(self.layer, "world_override", None) or self.scene.world) if self.layer.use_sky else None
        found = found and found.evaluated_get(self.depsgraph)
        settings, images = self.settings, self.meshes.materials.images
        if self.world is None and images:
            self.world = World(images, not settings.transparent, settings.exposure, time, goes_on, settings.shadow_rays and 4).tables(found, self.warnings)
            if group := found and self.visibility.light_groups.of(found):
                self.world = with_group(self.world, group)
        if found:
            around = surroundings_of(found, time)
            if around or may_change(found):
                self.rest.see(None, f"world `{found.name}`", time, {"": [*values_of(found), *around]})
            if self.meshes.is_watched:
                self._watch(time, found, may_change(found))
                self.states[time].append(around)

    def _watch(self, time, owner, changes):
        """Notes all that a material or world is at a frame, once where nothing changes it."""
        name = (type(owner).__name__, owner.name_full)
        state = state_of(owner) if changes or name not in self.settled else self.settled[name]
        self.settled[name] = state
        self.states.setdefault(time, []).append([name, state])

    def _camera(self, time):
        """Name of the camera, its projection, and the values of its key."""
        if self.settings.camera is not None:
            return "", *self.settings.camera
        camera = self._camera_at(time)
        if camera is None:
            raise ExportError("the scene has no camera: add one, and make it the active camera (Ctrl Numpad 0)")
        return camera.name_full, *cameras.key_of(camera, self.scene, self.depsgraph, self.settings.size, self.warnings, self.settings.eye)

    def _camera_at(self, time):
        """The camera of a time. A shutter that is open before the first frame sees by the camera of that frame."""
        frames = self.settings.frames
        camera = cameras.camera_at(self.scene, min(max(time, min(frames)), max(frames)))
        return camera and cameras.camera_of_view(self.scene, camera, self.settings.view)

    @staticmethod
    def _key(instance, item, seen):
        """What an instance is called in all frames."""
        if instance.is_instance:
            key = (instance.parent.name_full, item.name_full, tuple(instance.persistent_id))
        else:
            key = (item.name_full,)
        while key in seen:
            key += ("again",)
        seen.add(key)
        return key

    def _light(self, time, instance, seen):
        key = self._key(instance, instance.object, seen)
        found = lights.light_of(instance, instance.object.data, self.settings, self.warnings)
        if found and self.visibility.light(instance):
            fixed, values = found
            fixed["links"] = self.visibility.links_of_light(instance.object)
            if group := self.visibility.light_groups.of(instance.object):
                fixed["group"] = group
            track = self.lights.setdefault(key, [fixed, {}])
            if lights.has_size(fixed):
                track[0] = fixed
            track[1][time] = values

    def _mesh(self, time, instance, item, seen):
        self._place(time, instance, item, lambda _: (self._key(instance, item, seen), self.meshes.of(instance, item)))

    def _hair(self, time, instance, item, seen):
        """Notes the hair of an object's particle systems."""
        for modifier, system in strands.hair_systems(item):
            slot = system.settings.material - 1
            materials = [each.material for each in item.material_slots]
            material = self.meshes.override or (materials[min(max(slot, 0), len(materials) - 1)] if materials else None)

            def found(matrix, modifier=modifier, system=system, material=material):
                key = (*self._key(instance, item, seen), "hair", system.name)
                hairs = strands.of_system(item, modifier, system, self.depsgraph.mode == "RENDER")
                return key, self.strands.of(key, f"{item.name} {system.name}", hairs, material, matrix)

            self._place(time, instance, item, found)

    def _hair_curves(self, time, instance, item, seen):
        """Notes hair curves."""
        materials = [each.material for each in item.material_slots]
        material = self.meshes.override or (materials[0] if materials else None)

        def found(matrix):
            key = (*self._key(instance, item, seen), "curves")
            return key, self.strands.of(key, item.name, strands.of_curves(item.data), material, matrix)

        self._place(time, instance, item, found)

    def _volume(self, time, instance, item, seen):
        """Notes a volume."""
        materials = [each.material for each in item.material_slots]
        material = self.meshes.override or (materials[0] if materials else None)

        def found(matrix):
            key = (*self._key(instance, item, seen), "volume")
            return key, self.volumes.of(key, item, material, matrix)

        self._place(time, instance, item, found)

    def _place(self, time, instance, item, found):
        """Notes where something of an object is. `found(matrix)`: its key, and the mesh or None."""
        shown = self.visibility.of(instance, item)
        if shown.is_nowhere():
            return
        if is_of_gas(item):
            self.warnings.add(f"object `{item.name}` is left out: the smoke of a domain is not rendered")
            return
        matrix = np.array(instance.matrix_world, dtype=float)
        if not np.isfinite(matrix).all():
            self.warnings.add(f"object `{item.name}` is left out: its place is not a finite number (check its drivers and constraints)")
            return
        linear = thickened(matrix[:3, :3])
        if linear is None:
            return  # scaled to nothing: not there at this time
        matrix[:3, :3] = linear
        key, mesh = found(matrix)
        if mesh is None:
            return
        if not is_taken(matrix, mesh.reach):
            self.warnings.add(f"object `{item.name}` is left out where it is too large or too far away to be shown (check its drivers and constraints)")
            return
        placed = self.placed.get(key)
        if placed is None:
            placed = self.placed[key] = Placed(item.name, random_number(instance, item), item.pass_index)
        placed.mesh[time], placed.seen[time] = mesh, shown
        placed.matrices[time] = (TO_Y_UP @ matrix)[:3].ravel()

    def light_tracks(self):
        """Lights with a value for each time, or None where they are not there."""
        return [(fixed, {time: keys.get(time) for time in self.times}) for fixed, keys in self.lights.values()]
