"""How far each way to render is from the truth, on the small scenes of the tests, with standard errors.

    python benchmarks/accuracy.py [--spp 4096] [--passes 8] [--models walk dipole brdf] [--only milk]

The truth is `walk` with exact exits, which `tests/plugins/test_truth.py` compares with Mitsuba's `volpathmis`. The
noise of the table is the square root of the two variances of the means. The tests state the same with limits.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import nephrite  # noqa: F401 (before Mitsuba)

import mitsuba as mi  # isort: skip

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--spp", type=int, default=4096, help="samples a pixel and pass of the truth")
    parser.add_argument("--passes", type=int, default=8)
    parser.add_argument("--resolution", type=int, default=16)
    parser.add_argument("--light", type=float, default=24.0, help="half the side of the light, in mm")
    parser.add_argument("--models", nargs="*", default=["walk", "dipole", "brdf"])
    parser.add_argument("--only", default="", help="only scenes whose name contains this")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    options = parser.parse_args()
    mi.set_variant(options.variant)
    from nephrite.scene.translucent import object_mask
    from support import measure, scenes

    for trial in scenes.TRIALS:
        if options.only not in trial.name:
            continue
        start = time.perf_counter()
        scene = mi.load_dict(scenes.trial(trial, resolution=options.resolution, half=options.light))
        mask = object_mask(scene)
        exact = scenes.ours(model="walk", exit="exact")
        truth = measure.passes(scene, exact, options.spp, options.passes, 1000)
        print(f"{trial.name} (truth in {time.perf_counter() - start:.0f} s)")
        for model in options.models:
            start = time.perf_counter()
            integrator = scenes.ours(model=model, exit="lobe")
            own = measure.passes(scene, integrator, max(options.spp // 4, 1), options.passes, 5000)
            table = measure.bias(own, truth, mask)
            print(f"  {model:8s} {table} | {time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
