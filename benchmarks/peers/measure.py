"""What every renderer's process does: warm up, render with ever more samples, and write pictures, times and memory.

A peer is a module with a function `prepare(scene, method)` that returns a `Renderer`. It runs in a process of its own,

    python -m benchmarks.peers.NAME JOB.json

where JOB.json holds `scene` (see benchmarks/scenes.py), `method` (the peer's own settings), `seed`, `seconds` and
`folder`. It needs only NumPy here, as some peers live in an environment without Nephrite.
"""

from __future__ import annotations

import json
import math
import os
import resource
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_MOST_SAMPLES = 1 << 16
_DEAR = 1 / 32  # share of the time: calls with one sample that take longer are looked into
_PROBE = 4  # samples of the first call that is to tell what a sample costs
_FEW = 0.25  # of what goes before them: the time of the fewer samples that such renderers begin with
_TELLING = 1.0  # of a call with one sample: what more of them must take beyond it


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

    A renderer that precomputes much at every call gets two levels, so that its precomputation is told from its
    samples: few, and as many as make a picture of `seconds`; and if these are far apart, one more between them.

    Returns:
        For each level `spp` and the `seconds` of one picture; and the pictures, `a0`, `b0`, `a1`, ..., two a level.
    """
    number = -1

    def timed(spp: int) -> tuple[NDArray[np.float32], float]:
        nonlocal number
        number += 1
        before = clock()
        picture = renderer.call(spp, seed + number)
        return np.asarray(picture, np.float32), clock() - before

    timed(1)  # compiles, and loads what is loaded lazily
    start, once, planned = clock(), 0.0, []
    if renderer.startup:
        once = min(timed(1)[1] for _ in range(2))
    else:
        planned = _dear_levels(timed, seconds)
        start = clock()  # what it took to plan is not taken from the pictures
    levels: list[dict[str, Any]] = []
    pictures: dict[str, NDArray[np.float32]] = {}
    for spp in planned or _doubled(2 if renderer.startup else 1):
        (a, first), (b, second) = timed(spp), timed(spp)
        call = (first + second) / 2
        # a call with one sample has rendered one: n - 1 are left in the difference
        each = max(call - once, 1e-3) * spp / (spp - 1) if renderer.startup else call
        pictures |= {f"a{len(levels)}": a, f"b{len(levels)}": b}
        levels.append({"spp": spp, "seconds": each, "call": call})
        if not planned and clock() - start + 4 * call > seconds:
            break
    return levels, pictures


def _doubled(samples: int) -> Iterator[int]:
    while samples <= _MOST_SAMPLES:
        yield samples
        samples *= 2


def _dear_levels(timed: Callable[[int], tuple[Any, float]], seconds: float) -> list[int]:
    """Return the numbers of samples of a renderer whose calls cost much before their first sample; else none.

    Few: they take a quarter of what goes before them. Many: one picture with them takes `seconds`, as a picture is what
    a precomputation is paid for; they get as much time as what goes before them at least, even where there is less.
    What is precomputed may grow with the samples, so that a time cannot be read off between numbers that are far apart:
    more than 4 times the few have another pair halfway.
    """
    one = timed(1)[1]
    if one < _DEAR * seconds:
        return []
    probe, more = _PROBE, timed(_PROBE)[1] - one
    while more < _TELLING * one and probe < _MOST_SAMPLES // 4:
        probe *= 4
        more = timed(probe)[1] - one
    sample = max(more / (probe - 1), one / _MOST_SAMPLES)
    fixed = one - sample
    if fixed < one / 2:
        return []
    few = _power_of_two(_FEW * fixed / sample)
    many = max(_power_of_two(max(seconds - fixed, fixed) / sample), 2 * few)
    # the power of two next to their geometric mean, or below it
    between = few << ((many // few).bit_length() - 1) // 2
    return [few, many] if many <= 4 * few else [few, between, many]


def _power_of_two(samples: float) -> int:
    """Return the nearest power of two, so that most rounds have the same."""
    return 1 << round(math.log2(min(max(samples, 1.0), _MOST_SAMPLES / 2)))


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
