"""Runs that stand in for those of a scene: functions of a point, for workers to import."""

import math
import os
import time
from pathlib import Path

DONE = {"ending": "done", "reason": ""}


def trivial(point):
    return {"y": repr(2 * float(point[0]))} | DONE


def ishigami(point):
    """Ishigami and Homma (1990) with a = 7, b = 0.1."""
    x, y, z = map(float, point)
    return {"y": repr(math.sin(x) + 7 * math.sin(y) ** 2 + 0.1 * z**4 * math.sin(x))} | DONE


def linear(point):
    x, y, z = map(float, point)
    return {"y": repr(3 * x - 2 * y + 0 * z)} | DONE


def slow(point):
    time.sleep(0.15)
    return trivial(point)


def noted(point):
    """A slow run that leaves a mark for each time it is begun, in the folder of the mark."""
    with (Path(os.environ["MARKS"]) / f"{point[0]}.txt").open("a") as file:
        file.write("begun\n")
    return slow(point)


def deadly(point):
    """Ends its worker, at the first attempt or at each."""
    mark = Path(os.environ["MARKS"]) / f"{point[0]}.txt"
    first = not mark.exists()
    mark.touch()
    if point[0] == "1.0" or (point[0] == "2.0" and first):
        time.sleep(0.3)
        os._exit(1)
    return trivial(point)


def wrong(point):
    raise ValueError(f"no run of {point[0]}")
