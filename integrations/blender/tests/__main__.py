# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs all tests: python integrations/blender/tests. Says what is skipped, and why."""

import faulthandler
import importlib.util
import os
import sys
import unittest

if importlib.util.find_spec("bpy") is None:
    print(f"blender: skipped, {sys.executable} has no bpy (BPY_PYTHON names a Python that has it)")
    sys.exit(0)
faulthandler.dump_traceback_later(900, exit=True)
here = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, here)
found = unittest.defaultTestLoader.discover(here, pattern="test_*.py") if len(sys.argv) < 2 else unittest.defaultTestLoader.loadTestsFromNames(sys.argv[1:])
result = unittest.TextTestRunner(verbosity=2).run(found)
for _, why in result.skipped:
    print(f"blender: skipped: {why}")
sys.stdout.flush()
sys.stderr.flush()
# bpy 4.5 may hang while Python ends
os._exit(0 if result.wasSuccessful() else 1)
