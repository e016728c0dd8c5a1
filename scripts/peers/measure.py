"""What is the same for all renderers: turns of timed work, errors, and the time to an error."""

import contextlib
import fcntl
import json
import math
import os
import time

import numpy as np

TARGET = 0.10  # the relative RMSE that the tables ask for


@contextlib.contextmanager
def timed_turn():
    """Timed work goes in here. On a machine that is shared, PEERS_LOCK names a file: who holds its lock is alone.

    The lock is let go for a moment between turns, so that others have theirs.
    """
    path = os.environ.get("PEERS_LOCK")
    if not path:
        yield
        return
    with open(path, "a", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            yield
        finally:
            fcntl.flock(lock, fcntl.LOCK_UN)
    time.sleep(0.5)


def relative_rmse(picture, reference):
    """The root of the mean squared difference over pixels and channels, over the mean of the reference."""
    return float(np.sqrt(np.mean((picture.astype(np.float64) - reference) ** 2)) / reference.mean())


class Reference:
    """A converged picture, as the mean of several that have been made independently of each other."""

    def __init__(self, path):
        self.parts = np.load(path).astype(np.float64)
        self.picture = self.parts.mean(0)

    def own_error(self):
        """Its relative RMSE against the truth, as the spread of its parts tells."""
        variance = self.parts.var(0, ddof=1).mean() / len(self.parts)
        return float(np.sqrt(variance) / self.picture.mean())


def best_settings(rows):
    """Of measured settings, those that no other beats in both time and error; the fastest first."""
    best = []
    for row in sorted(rows, key=lambda row: (row["seconds"], row["error"])):
        if not best or row["error"] < best[-1]["error"]:
            best.append(row)
    return best


def seconds_to(rows, target=TARGET):
    """Seconds to the error `target`, and how that is known: "between", "within" or "beyond" what was measured.

    Interpolated on logarithmic scales between the two of the best settings around it. Where all of them are more
    precise, it is the time of the fastest; where none is precise enough, there is no time.
    """
    best = best_settings(rows)
    if best[0]["error"] <= target:
        return best[0]["seconds"], "within"
    for worse, better in zip(best, best[1:]):
        if better["error"] <= target:
            span = math.log(better["error"] / worse["error"])
            share = math.log(target / worse["error"]) / span
            return worse["seconds"] * (better["seconds"] / worse["seconds"]) ** share, "between"
    return None, "beyond"


def append(path, row):
    """Adds a measured row to a file of JSON lines."""
    with open(path, "a", encoding="utf-8") as out:
        out.write(json.dumps(row) + "\n")


def read_rows(path):
    with open(path, encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]
