"""Progress, cancelling, threads, memory, and what happens to exceptions."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

import afterimage
from support import COURT, ROOT, still

LONG = {"frames": 1, "size": (1280, 720), "samples": 4, "paths": 16}
"""A frame that takes half a minute on two cores."""


class Control(unittest.TestCase):
    def test_progress_rises_to_one_in_each_frame(self):
        told = []
        render = afterimage.render(
            afterimage.load(COURT), frames="1-2", size=(320, 180), paths=4,
            progress=lambda frame, done: told.append((frame, done)),
        )
        next(render)
        self.assertEqual({frame for frame, _ in told}, {1}, "nothing is rendered ahead")
        list(render)
        for number in (1, 2):
            shares = [done for frame, done in told if frame == number]
            self.assertEqual(shares, sorted(shares))
            self.assertEqual(shares[-1], 1.0)

    def assert_stops(self, kind, **arguments):
        render = afterimage.render(afterimage.load(COURT), **LONG, **arguments)
        start = time.monotonic()
        with self.assertRaises(kind):
            next(render)
        self.assertRaises(afterimage.Cancelled, next, render)
        return time.monotonic() - start

    def test_an_exception_in_the_progress_function_is_raised(self):
        def progress(frame, done):
            raise ZeroDivisionError

        self.assertLess(self.assert_stops(ZeroDivisionError, progress=progress), 2)

    def test_a_progress_function_that_says_false_cancels(self):
        self.assertLess(self.assert_stops(afterimage.Cancelled, progress=lambda frame, done: False), 2)

    def test_another_thread_cancels_within_a_second(self):
        render = afterimage.render(afterimage.load(COURT), **LONG)
        cancelled = []

        def cancel():
            cancelled.append(time.monotonic())
            render.cancel()

        timer = threading.Timer(0.7, cancel)
        timer.start()
        self.assertRaises(afterimage.Cancelled, next, render)
        self.assertLess(time.monotonic() - cancelled[0], 1)
        timer.join()

    def test_a_render_that_was_cancelled_before_says_so(self):
        render = afterimage.render(still())
        render.cancel()
        self.assertRaises(afterimage.Cancelled, next, render)
        self.assertTrue(issubclass(afterimage.Cancelled, afterimage.Error))

    def test_an_interrupt_ends_the_wait_within_a_second(self):
        # a process that was started in the background ignores the signal
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        render = afterimage.render(afterimage.load(COURT), **LONG)
        sent = []

        def interrupt():
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        threading.Timer(0.7, interrupt).start()
        with self.assertRaises(KeyboardInterrupt):
            next(render)
        self.assertLess(time.monotonic() - sent[0], 1)

    def test_other_threads_run_meanwhile(self):
        counted, end = [0], threading.Event()

        def count():
            while not end.is_set():
                counted[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        list(afterimage.render(afterimage.load(COURT), frames=1, size=(480, 270), paths=4))
        during = counted[0] - before
        end.set()
        thread.join()
        self.assertGreater(during, 20)

    def test_two_renders_in_two_threads(self):
        scene = afterimage.load(COURT)

        def render(results, name):
            frames = afterimage.render(scene, frames="1-3", size=(160, 90), paths=2, threads=2)
            results[name] = [frame.layers["RGBA"] for frame in frames]

        results = {}
        threads = [threading.Thread(target=render, args=(results, name)) for name in "ab"]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        self.assertEqual(len(results["a"]), 3)
        for one, other in zip(results["a"], results["b"]):
            self.assertTrue(np.array_equal(one, other))

    def test_two_threads_at_one_render_are_told(self):
        render = afterimage.render(afterimage.load(COURT), **LONG)
        waiting = threading.Thread(target=lambda: self.assertRaises(afterimage.Cancelled, next, render))
        waiting.start()
        time.sleep(0.5)
        with self.assertRaisesRegex(afterimage.Error, "another thread waits"):
            next(render)
        render.cancel()
        waiting.join()

    def test_renders_that_are_dropped_free_their_memory(self):
        def resident():
            with open("/proc/self/statm", encoding="ascii") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

        scene = afterimage.load(COURT)

        def tasks():
            return len(os.listdir("/proc/self/task"))

        def one():
            render = afterimage.render(scene, frames="1-9", size=(640, 360), paths=0, threads=1)
            next(render)

        one()
        time.sleep(1)
        # Embree's own threads stay
        threads, first = tasks(), resident()
        for _ in range(8):
            one()
            # one that ends while the next begins has its memory still
            deadline = time.monotonic() + 5
            while time.monotonic() < deadline and tasks() > threads:
                time.sleep(0.02)
        gc.collect()
        self.assertLessEqual(tasks(), threads, "threads are left")
        # eight renders of a megapixel's samples would be more
        self.assertLess(resident() - first, 150 << 20)

    def test_a_program_may_end_in_the_middle_of_a_frame(self):
        text = f"""
import afterimage, threading, time
render = afterimage.render(afterimage.load({str(COURT)!r}), frames=1, size=(1280, 720), samples=4, paths=16)
threading.Thread(target=lambda: next(render), daemon=True).start()
time.sleep(0.7)
"""
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        start = time.monotonic()
        ended = subprocess.run([sys.executable, "-c", text], env=environment, timeout=60, check=False,
                               capture_output=True)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertLess(time.monotonic() - start, 20)

    def test_one_version_and_one_set_of_crates(self):
        with open(ROOT / "Cargo.toml", encoding="utf-8") as file:
            self.assertIn(f'\nversion = "{afterimage.__version__}"\n', file.read())

        def packages(path):
            with open(path, encoding="utf-8") as file:
                parts = file.read().split("[[package]]\n")[1:]
            return {tuple(line.split(" = ")[1] for line in part.splitlines()[:2]) for part in parts}

        renderer, module = packages(ROOT / "Cargo.lock"), packages(ROOT / "python" / "Cargo.lock")
        names = {name for name, _ in renderer}
        self.assertEqual({package for package in module - renderer if package[0] in names}, set(),
                         "copy Cargo.lock to python/Cargo.lock, and build the module: it must have the renderer's crates")


if __name__ == "__main__":
    unittest.main()
