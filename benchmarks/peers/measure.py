"""What every renderer's process does: warm up, render with ever more samples, and write pictures, times and memory.

A peer is a module with a function `prepare(scene, method)` that returns a `Renderer`. It runs in a process of its own,

    python -m benchmarks.peers.NAME JOB.json

where JOB.json holds `scene` (see benchmarks/scenes.py), `method` (the peer's own settings), `seed`, `seconds` and
`folder`. It needs only NumPy here, as some peers live in an environment without Nephrite.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_MOST_SAMPLES = 1 << 16


@dataclass
class Renderer:
    """A loaded scene. `call(spp, seed)` returns (height, width, 3) linear radiance.

    `version`: the renderer's. `startup`: whether a call prepares the scene again, writes files and so on, which other
    renderers do beforehand: then the time of a call with one sample is taken off.
    """

    call: Callable[[int, int], NDArray[np.float32]]
    version: str
    startup: bool = False


def main(prepare: Callable[[dict[str, Any], dict[str, Any]], Renderer]) -> None:
    """Do the job that the command line names; writes `pictures.npz` and `told.json` into its folder."""
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    start = time.perf_counter()
    renderer = prepare(job["scene"], job["method"])
    loaded = time.perf_counter() - start
    levels, pictures = climb(renderer, job["seed"], job["seconds"])
    told = {"version": renderer.version, "loaded": loaded, "levels": levels, "peak": peak_memory()}
    folder = Path(job["folder"])
    np.savez(folder / "pictures.npz", **pictures)
    (folder / "told.json").write_text(json.dumps(told), encoding="utf-8")


def climb(
    renderer: Renderer, seed: int, seconds: float, clock: Callable[[], float] = time.perf_counter
) -> tuple[list[dict[str, Any]], dict[str, NDArray[np.float32]]]:
    """Render pairs of pictures with 1, 2, 4, ... samples a pixel until `seconds` would be exceeded.

    Returns:
        For each level `spp` and the `seconds` of one picture; and the pictures, `a0`, `b0`, `a1`, ..., two a level.
    """

    def timed(spp: int, number: int) -> tuple[NDArray[np.float32], float]:
        before = clock()
        picture = renderer.call(spp, seed + number)
        return np.asarray(picture, np.float32), clock() - before

    timed(1, 0)  # compiles, and loads what is loaded lazily
    start = clock()
    once = min(timed(1, i)[1] for i in (1, 2)) if renderer.startup else 0.0
    levels: list[dict[str, Any]] = []
    pictures: dict[str, NDArray[np.float32]] = {}
    spp, number = (2 if renderer.startup else 1), 3
    while spp <= _MOST_SAMPLES:
        (a, first), (b, second) = timed(spp, number), timed(spp, number + 1)
        call = (first + second) / 2
        # a call with one sample has rendered one: n - 1 are left in the difference
        each = max(call - once, 1e-3) * spp / (spp - 1) if renderer.startup else call
        pictures |= {f"a{len(levels)}": a, f"b{len(levels)}": b}
        levels.append({"spp": spp, "seconds": each, "call": call})
        if clock() - start + 4 * call > seconds:
            break
        spp, number = 2 * spp, number + 2
    return levels, pictures


def peak_memory() -> int:
    """Return the largest resident size of this process so far, in bytes."""
    try:
        # what getrusage says starts with the size of the process that started this one
        status = Path("/proc/self/status").read_text(encoding="ascii")
        return 1024 * int(status.partition("VmHWM:")[2].split()[0])
    except (OSError, IndexError):
        unit = 1 if sys.platform == "darwin" else 1024
        return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def cores() -> int:
    """Return how many processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
