"""The truth of a scene: the exact walk, rendered in passes of their own process until it is quiet or time is spent.

    python -m benchmarks.reference JOB.json

JOB.json holds `scene`, `integrator`, `variant`, `noise` (see `analysis.Truth`), `seconds` and `folder`. Writes `mean`,
its standard `error`, and the object's pixels, `mask`, into `truth.npz`.
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

from benchmarks.analysis import Truth
from benchmarks.peers.mitsuba import load
from nephrite.atlas.compared import Estimate
from nephrite.scene.translucent import object_mask

_LEAST_PASSES = 8
_SEED = 1_000_000  # far from the seeds of what is compared with it


def render(scene: Any, integrator: Any, noise: float, seconds: float) -> dict[str, Any]:
    """Return the mean of equal passes, and its standard error from their scatter; at most `seconds` of them."""
    spp, passes, start = 1, 0, time.perf_counter()
    mi.render(scene, integrator=integrator, spp=1, seed=_SEED)
    while True:  # passes of about 1 / 128 of the time
        before = time.perf_counter()
        mi.render(scene, integrator=integrator, spp=spp, seed=_SEED + spp).numpy()
        if 256 * (time.perf_counter() - before) > seconds:
            break
        spp *= 2
    mask, quiet = object_mask(scene), False
    total: Any = 0.0
    squares: Any = 0.0
    mean: Any = 0.0
    error: Any = 0.0
    while passes < _LEAST_PASSES or (not quiet and time.perf_counter() - start < seconds):
        seed: Any = 2 * _SEED + passes
        picture = np.array(mi.render(scene, integrator=integrator, spp=spp, seed=seed), np.float64)[..., :3]
        total, squares, passes = total + picture, squares + picture**2, passes + 1
        mean = total / passes
        error = np.sqrt(np.maximum(squares / passes - mean**2, 0.0) / max(passes - 1, 1))
        quiet = Truth(Estimate(mean, error), mask).noise <= noise
    return {
        "mean": mean.astype(np.float32),
        "error": error.astype(np.float32),
        "samples": np.array(spp * passes),
        "mask": mask,
    }


def main() -> None:
    """Do the job that the command line names."""
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    mi.set_variant(job["variant"])
    found = render(load(job["scene"]), mi.load_dict(job["integrator"]), job["noise"], job["seconds"])
    np.savez(Path(job["folder"]) / "truth.npz", **found)


if __name__ == "__main__":
    main()
