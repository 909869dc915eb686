"""A process that renders B1 with all levers or without one of them, and tells what that costs.

    python -m benchmarks.levers.job JOB.json

JOB.json holds `scene` (see benchmarks/scenes.py), `model`, `lever` (its name; "" for all of them), `spp` and `folder`.
Writes into `told.json`: `efficiency`, of a pair of pictures, whatever is precomputed for each of them included; and
with all levers `where` its time goes, and where its `noise` comes from.
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

from benchmarks.levers import noise
from benchmarks.levers.patches import LEVERS
from benchmarks.levers.where import where
from benchmarks.peers.mitsuba import load
from nephrite.image import errors
from nephrite.scene.translucent import object_mask


def main() -> None:
    """Do the job that the command line names."""
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    mi.set_variant("llvm_ad_rgb")
    scene, settings = load(job["scene"]), {"type": "translucent_path", "model": job["model"]}
    for lever in LEVERS[job["model"]]:
        if lever.name == job["lever"]:
            lever.take_away()
            settings |= dict(lever.settings)

    def picture(seed: int, spp: int = job["spp"], **more: Any) -> np.ndarray:
        # a new integrator each time: what it precomputes is a part of the picture
        integrator: Any = mi.load_dict(settings | more)
        return mi.render(scene, integrator=integrator, spp=spp, seed=seed).numpy()[..., :3]

    told: dict[str, Any] = {}
    if not job["lever"]:
        width, height = job["scene"]["resolution"]
        told["where"] = where(picture, job["spp"] * width * height)
    picture(0, 1)
    start = time.perf_counter()
    a, b = picture(1), picture(2)
    seconds = (time.perf_counter() - start) / 2
    mask = object_mask(scene)
    told["efficiency"] = errors.efficiency(a, b, seconds, mask)
    if not job["lever"]:
        told["noise"] = noise.of_terms(lambda seed, terms: picture(seed, terms=terms), mask)
        told["noise"]["place on the lamp"] = noise.of_lamps(scene) / job["spp"]
    (Path(job["folder"]) / "told.json").write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    main()
