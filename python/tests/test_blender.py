"""The module beside Blender's, which brings its own Embree, TBB and Open Image Denoise."""

import importlib.util
import os
import subprocess
import sys
import unittest

from support import COURT

TEXT = """
import {first}
import {second}
import hashlib
scene = afterimage.load({court!r})
def digests():
    frames = afterimage.render(scene, frames="1-2", size=(96, 54), paths=2)
    return [hashlib.sha256(frame.layers["RGBA"].tobytes()).hexdigest() for frame in frames]
before = digests()
settings = bpy.context.scene
settings.render.engine, settings.cycles.samples = "CYCLES", 1
settings.render.resolution_x, settings.render.resolution_y = 32, 18
bpy.ops.render.render()
assert digests() == before
print("digests", *before)
"""


@unittest.skipUnless(importlib.util.find_spec("bpy"), "this Python has no module bpy")
class Blender(unittest.TestCase):
    def test_both_render_in_one_process_in_either_order(self):
        said = []
        for first, second in [("bpy", "afterimage"), ("afterimage", "bpy")]:
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
            text = TEXT.format(first=first, second=second, court=str(COURT))
            ended = subprocess.run([sys.executable, "-c", text], env=environment, timeout=300, check=False,
                                   capture_output=True, text=True)
            self.assertEqual(ended.returncode, 0, ended.stderr)
            said += [line for line in ended.stdout.splitlines() if line.startswith("digests")]
        self.assertEqual(len(said), 2)
        self.assertEqual(said[0], said[1])


if __name__ == "__main__":
    unittest.main()
