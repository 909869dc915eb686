"""The truth of a scene: the exact walk, rendered in passes of their own process until its time is spent.

    python -m benchmarks.reference JOB.json

JOB.json holds `scene`, `integrator`, `variant`, `seconds` and `folder`. Writes `mean`, its standard `error`, and the
object's pixels, `mask`, into `truth.npz`.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import nephrite  # noqa: F401 (before Mitsuba)

import mitsuba as mi  # isort: skip
import numpy as np

from benchmarks.peers.mitsuba import load
from nephrite.scene.translucent import object_mask

_LEAST_PASSES = 8
_SEED = 1_000_000  # far from the seeds of what is compared with it


def render(scene: Any, integrator: Any, seconds: float) -> dict[str, Any]:
    """Return the mean of equal passes, and its standard error from their scatter."""
    spp, passes, start = 1, 0, time.perf_counter()
    mi.render(scene, integrator=integrator, spp=1, seed=_SEED)
    while True:  # passes of about 1 / 32 of the time
        before = time.perf_counter()
        mi.render(scene, integrator=integrator, spp=spp, seed=_SEED + spp).numpy()
        if 64 * (time.perf_counter() - before) > seconds:
            break
        spp *= 2
    total: Any = 0.0
    squares: Any = 0.0
    while passes < _LEAST_PASSES or time.perf_counter() - start < seconds:
        seed: Any = 2 * _SEED + passes
        picture = np.array(mi.render(scene, integrator=integrator, spp=spp, seed=seed), np.float64)[..., :3]
        total, squares, passes = total + picture, squares + picture**2, passes + 1
    mean = total / passes
    variance = np.maximum(squares / passes - mean**2, 0.0) / (passes - 1)
    return {
        "mean": mean.astype(np.float32),
        "error": np.sqrt(variance).astype(np.float32),
        "samples": np.array(spp * passes),
        "mask": object_mask(scene),
    }


def main() -> None:
    """Do the job that the command line names."""
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    mi.set_variant(job["variant"])
    found = render(load(job["scene"]), mi.load_dict(job["integrator"]), job["seconds"])
    np.savez(Path(job["folder"]) / "truth.npz", **found)


if __name__ == "__main__":
    main()
