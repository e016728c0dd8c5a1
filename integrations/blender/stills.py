# SPDX-License-Identifier: GPL-3.0-or-later
"""Stills that follow each other, as scripts render them frame by frame: which frames to export along with one, so that the next ones reuse its samples."""

import bpy

from .export.mesh_store import has_handlers

AHEAD = (16, 64)
"""Frames that are exported at once when stills begin to follow each other, and when these are rendered."""
MOST_OBJECTS_AT_FIRST = 200
"""Objects of a scene that moves, up to which a script's first still has frames ahead: more take long, and the script may want none of them."""
MOST_MISSES = 2
"""Exports that are found to be out of date, after which none is made ahead: something else than the frame changes from still to still."""


class Stills:
    """What was rendered still by still, of one scene, view layer and view."""

    def __init__(self):
        self.misses = 0
        self.forget()

    def forget(self):
        """Begins anew."""
        self.last, self.step, self.count, self.row, self.rounds = None, None, 0, 0, 0

    def note(self, frame):
        """Notes the frame of a still that is rendered."""
        step = frame - self.last if self.last is not None else None
        if step != self.step or not step or step < 0:
            self.row, self.rounds = 0, 0
        self.last, self.step = frame, step
        self.count, self.row = self.count + 1, self.row + 1

    def miss(self):
        """Notes that the scene has changed since frames of it were exported."""
        self.misses += 1
        self.row, self.rounds = 0, 0

    def frames(self, scene):
        """Frames to export with the still that was noted last, which is the first of them."""
        if self.count == 1:
            self.step = self._likely_step(scene)
        elif not self._is_row():
            return [self.last]
        if not self.step or self.misses >= MOST_MISSES or scene.afterimage.mode == "full" or has_handlers():
            return [self.last]
        count = AHEAD[min(self.rounds, len(AHEAD) - 1)]
        self.rounds += 1
        return list(range(self.last, scene.frame_end + 1, self.step))[:count] or [self.last]

    def _is_row(self):
        """Returns true if stills seem to follow each other: three of them, or the first two of a script without a window."""
        return self.row > 1 or (self.count == 2 and self.step is not None and self.step > 0 and bpy.app.background)

    def _likely_step(self, scene):
        """The step by which a script without a window goes on from its first still, if that is likely."""
        is_likely = bpy.app.background and bpy.data.actions and len(scene.objects) <= MOST_OBJECTS_AT_FIRST
        return scene.frame_step if is_likely else None
