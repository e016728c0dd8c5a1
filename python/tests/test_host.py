"""A module is a guest: whatever a script does, the process that runs it never hangs, and never ends but by its own will."""

import gc
import itertools
import os
import subprocess
import sys
import textwrap
import time
import unittest
import weakref

import numpy as np

import afterimage
from support import COURT, CUBE, CUBE_FACES, moved, still

SMALL = {"size": (32, 18), "samples": 1, "paths": 0}
BEGIN = f"""
import afterimage, os, sys
def begun(frames="1-3", **more):
    return afterimage.render(afterimage.load({str(COURT)!r}), frames=frames, size=(32, 18), samples=1, paths=0, **more)
"""


def run(text):
    """What a script of its own says, which must end before long."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    return subprocess.run([sys.executable, "-c", BEGIN + textwrap.dedent(text)], env=environment, timeout=60, check=False,
                          capture_output=True, text=True)


class Host(unittest.TestCase):
    def assert_says(self, ran, *lines):
        self.assertEqual((ran.returncode, ran.stdout.split("\n")[:-1]), (0, list(lines)), ran.stderr)

    def test_a_script_ends_whatever_render_it_still_holds(self):
        for name, text, code in [
            ("one frame of three", "frames = begun(); next(frames)", 0),
            ("none", "frames = begun()", 0),
            ("a loop that is left", "frames = begun()\nfor frame in frames: break", 0),
            ("an exception", "frames = begun()\nfor frame in frames: raise ValueError", 1),
            ("an exception of a function", "def main():\n    frames = begun()\n    next(frames)\n    raise ValueError\nmain()", 1),
            ("one that was cancelled", "frames = begun(); next(frames); frames.cancel()", 0),
            ("several", "all = [begun() for _ in range(3)]; next(all[1])", 0),
        ]:
            with self.subTest(name):
                ran = run(text)
                self.assertEqual(ran.returncode, code, ran.stderr)
                self.assertEqual("ValueError" in ran.stderr, code == 1, ran.stderr)

    def test_nothing_is_rendered_once_the_interpreter_ends(self):
        ran = run("""
            import atexit
            def late():
                try: print(next(begun()).number)
                except afterimage.Error as error: print("about to end" in str(error))
            atexit.register(late)       # comes before the function of the module, which was registered before
            atexit._run_exitfuncs()
            late()
        """)
        self.assert_says(ran, "1", "True")

    def test_a_render_and_its_progress_function_may_hold_each_other(self):
        scene = afterimage.load(COURT)

        class Job:
            def __init__(self):
                self.frames = afterimage.render(scene, frames="1-9", progress=self.tell, threads=2, **SMALL)

            def tell(self, frame, share):
                pass

        def tasks():
            return len(os.listdir("/proc/self/task"))

        gc.collect()
        before = tasks()
        for _ in range(8):
            next(Job().frames)
        # the last one's samples are kept for as long as the scene
        del scene
        gc.collect()
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline and tasks() > before:
            time.sleep(0.05)
        self.assertLessEqual(tasks(), before, "threads are left")

    def test_a_frame_may_be_in_its_own_layers(self):
        class Probe:
            pass

        probe = Probe()
        seen = weakref.ref(probe)
        (frame,) = afterimage.render(still(), **SMALL)
        frame.layers["own"], frame.stats["probe"] = frame, probe
        del frame, probe
        gc.collect()
        self.assertIsNone(seen())

    def test_values_in_themselves_or_without_an_end_are_errors(self):
        own, own_list, deep = {}, [], []
        own["own"] = own
        own_list.append(own_list)
        for _ in range(30_000):
            deep = [deep]
        endless = itertools.count
        scene = afterimage.Scene()
        for words, make in [
            ("in itself", lambda: afterimage.render(still(), stereo=own)),
            ("in itself", lambda: afterimage.Scene(shutter=own)),
            ("in itself", lambda: scene.add_material("m", base_color=own_list)),
            ("in itself", lambda: scene.add_material("m", base_color=deep)),
            ("in itself", lambda: scene.set_camera(keys={1: own})),
            ("in itself", lambda: scene.set("floor", height=deep)),
            ("`base_color`: more than 1000000 values", lambda: scene.add_material("m", base_color=endless())),
            ("more than 1000000 values", lambda: scene.add_material("m", base_color=(iter([0]) for _ in endless()))),
            ("more than 1000000 characters", lambda: scene.add_material("m", base_color_map="x" * 2_000_000)),
            ("more than 1000000 numbers", lambda: afterimage.render(still(), frames=endless())),
            ("frames", lambda: afterimage.render(still(), frames=range(1, 1 << 40))),
            ("of them", lambda: scene.add_mesh("m", CUBE, CUBE_FACES, materials=(None for _ in endless()))),
            ("a material is what", lambda: scene.add_mesh("m", CUBE, CUBE_FACES, materials=range(1 << 60))),
            ("must be a list", lambda: scene.add_mesh("m", CUBE, CUBE_FACES, materials="red")),
            ("is no array", lambda: scene.add_mesh("m", own_list, CUBE_FACES)),
            ("is no array", lambda: scene.add_mesh("m", endless(), CUBE_FACES)),
        ]:
            with self.subTest(words), self.assertRaises(afterimage.Error) as caught:
                make()
            self.assertIn(words, str(caught.exception))

    def test_exceptions_of_the_callers_own_functions_stay_as_they_are(self):
        def interrupted():
            yield 1
            raise KeyboardInterrupt

        scene = afterimage.Scene()
        self.assertRaises(KeyboardInterrupt, scene.add_material, "m", base_color=interrupted())
        self.assertRaises(KeyboardInterrupt, afterimage.render, still(), frames=interrupted())

    def test_a_dict_that_changes_while_it_is_read_counts_as_it_was(self):
        shutter, places = {}, {}

        class Opening:
            def __float__(self):
                shutter.update((f"more{number}", 1) for number in range(100))
                return -0.25

        class First:
            def __float__(self):
                places.update((number, "no matrix") for number in range(100, 200))
                return 1.0

        shutter["open"] = Opening()
        self.assertEqual(len(list(afterimage.render(still(exposures=1), shutter=shutter, **SMALL))), 1)
        self.assertEqual(len(shutter), 101)
        places.update({First(): np.eye(4), 2: np.eye(4)})
        still().add_mesh("m", CUBE, CUBE_FACES, transform=places)
        self.assertEqual(len(places), 102)

    def test_numbers_may_lie_at_any_byte(self):
        packed = np.zeros(8, dtype=[("kind", "u1"), ("place", "<f4", 3), ("face", "<i4", 3), ("matrix", "<f8", (4, 4))])
        packed["place"], packed["matrix"][0] = CUBE, moved(x=1)
        packed["face"] = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]]
        self.assertFalse(any(packed[name].flags.aligned for name in ("place", "face", "matrix")))
        images = []
        for arrays in [packed, {name: packed[name].copy() for name in packed.dtype.names}]:
            scene = afterimage.Scene(**SMALL)
            scene.add_mesh("cube", arrays["place"], arrays["face"], transform=arrays["matrix"][0])
            scene.add_light("sun", direction=(-1, -2, -3))
            scene.set_camera(eye=(4, 3, 6), target=(0, 0, 0))
            images.append(next(afterimage.render(scene)).layers["RGBA"])
        self.assertGreater(images[0].max(), 0)
        self.assertTrue(np.array_equal(*images))

    def test_meshes_that_do_not_fit_into_memory_are_errors(self):
        ran = run("""
            import resource, numpy as np
            def limit(more):
                with open("/proc/self/statm", encoding="ascii") as file:
                    size = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
                resource.setrlimit(resource.RLIMIT_AS, (size + more, resource.getrlimit(resource.RLIMIT_AS)[1]))
            def told(make):
                try: make()
                except (afterimage.Error, MemoryError) as error: print(type(error).__name__, "memory" in str(error))
            points = np.zeros((30_000_000, 3), np.float32)      # 360 MB that nothing is written to
            faces = np.zeros((6_000_000, 3), np.uint32)
            scene = afterimage.Scene()
            scene.set_camera(eye=(0, 0, 5), target=(0, 0, 0))
            limit(300 << 20)
            told(lambda: scene.add_mesh("m", points, [[0, 1, 2]]))
            limit(2000 << 20)
            scene.add_mesh("m", np.zeros((3, 3), np.float32), faces, uv=np.zeros((18_000_000, 2), np.float32))
            limit(1000 << 20)
            told(lambda: afterimage.render(scene))
            print("alive")
        """)
        self.assert_says(ran, "Error True", "Error True", "alive")

    def test_what_lives_in_threads_is_refused_in_a_forked_process(self):
        ran = run("""
            def in_child(what):
                sys.stdout.flush()
                child = os.fork()
                if child == 0:
                    # and the interpreter ends, with all that it does then
                    try: print(what())
                    except afterimage.Error as error: print("forked" in str(error))
                    sys.exit(7)
                assert os.waitpid(child, 0)[1] == 7 << 8
            def in_fresh_child():
                return next(begun()).number
            in_child(in_fresh_child)
            scene = afterimage.load(%r)
            small = {"frames": 1, "size": (32, 18), "samples": 1, "paths": 0}
            in_child(lambda: next(afterimage.render(scene, **small)).number)
            in_child(lambda: afterimage.load(%r))
            frames = begun()
            in_child(lambda: next(frames))
            next(frames)
            in_child(lambda: next(frames))
            in_child(lambda: next(begun()))
            in_child(lambda: afterimage.render(scene, **small))
            in_child(lambda: frames.cancel() or "cancelled")
            print(next(frames).number)
        """ % (str(COURT), str(COURT)))
        self.assert_says(ran, "1", "1", "True", "True", "True", "True", "True", "cancelled", "2")


if __name__ == "__main__":
    unittest.main()
