"""What a sample of the dipole costs beside one of the walk, on benchmark scene B1: with all of it, and without parts.

    .venv/bin/python -m benchmarks.dipole [--spp 16] [--rounds 8]

Samples a second, over those of `walk` in the same round: median, and its standard error. A picture without a part is
wrong; its rate tells what the part costs, and what would have to go for a dipole that is as fast as some figure asks.
"""

from __future__ import annotations

import argparse
import math
import time
from contextlib import ExitStack
from typing import Any
from unittest import mock

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

import nephrite
from benchmarks.efficiency import scene
from nephrite.plugins import glints, path, roulette, shortcut

WALK = "walk"


def _unshadowed(scene: Any, at: Any, ds: Any, value: Any, active: Any) -> Any:
    return dr.select(active & (ds.pdf > 0), value, 0)


def _unlooked(scene: Any, ray: Any, distance: Any, active: Any) -> Any:
    return active


PARTS: dict[str, tuple[Any, str, Any]] = {
    "shadow rays to lights": (path, "unblocked", _unshadowed),
    "shadow rays to the second event": (shortcut, "_open", _unlooked),
    "lamps that are mirrored or straight behind": (glints, "_MOST", 0),
    "paths after their first connection to lights": (roulette, "AFTER_LIGHT", 0.0),
}
"""Of a dipole: where it lives, and what is put there to leave it out."""


def without(parts: list[str]) -> ExitStack:
    """Return a context in which parts are left out of what is recorded."""
    stack = ExitStack()
    for name in parts:
        stack.enter_context(mock.patch.object(*PARTS[name]))
    return stack


def cases() -> dict[str, tuple[str, list[str]]]:
    """Return what is measured: a model, and what it does without."""
    rays = list(PARTS)[:3]
    return {
        WALK: (WALK, []),
        "brdf": ("brdf", []),
        "dipole": ("dipole", []),
        **{f"dipole without {name}": ("dipole", [name]) for name in PARTS},
        "dipole without the first three": ("dipole", rays),
        "dipole without all four": ("dipole", list(PARTS)),
    }


def measure(spp: int, rounds: int) -> dict[str, NDArray]:
    """Return samples a second of each case, round by round; the round before them compiles."""
    b1 = scene()
    pixels = math.prod(b1.sensors()[0].film().crop_size())
    integrators: dict[str, Any] = {
        name: mi.load_dict({"type": "translucent_path", "model": model})
        for name, (model, _) in cases().items()
    }
    rates: dict[str, list[float]] = {name: [] for name in cases()}
    for number in range(rounds + 1):
        for name, (_, parts) in cases().items():
            with without(parts):
                start = time.perf_counter()
                mi.render(b1, integrator=integrators[name], spp=spp, seed=number).numpy()
                rates[name].append(pixels * spp / (time.perf_counter() - start))
    return {name: np.array(found[1:]) for name, found in rates.items()}


def line(name: str, rates: NDArray, walk: NDArray) -> str:
    """Return a line of the table."""
    ratios = rates / walk
    error = 1.25 * ratios.std() / math.sqrt(len(ratios))  # of a median
    return f"| {name} | {np.median(rates) / 1e6:.2f} | {np.median(ratios):.2f} ± {error:.2f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=8)
    given = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    found = measure(given.spp, given.rounds)
    print(
        f"Nephrite {nephrite.__version__}, {mi.variant()}, scene B1, {given.spp} spp, {given.rounds} rounds"
    )
    print("| model | Msamples/s | / walk |\n| --- | --- | --- |")
    for name, rates in found.items():
        print(line(name, rates, found[WALK]))


if __name__ == "__main__":
    main()
