"""What a sample of the dipole costs beside one of the walk, on benchmark scene B1: with all of it, and without parts.

    .venv/bin/python -m benchmarks.dipole [--spp 16] [--rounds 8]

Samples a second, over those of `walk` in the same round: median, and its standard error. A picture without a part is
wrong; its rate tells what the part costs, and what would have to go for a dipole that is as fast as some figure asks.
Where fewer paths go on after lights, the picture is right, but noisier: efficiency, over that of `walk`, tells what the
rate is worth (mean^2 / (variance x seconds) over the body's pixels; fireflies make it uncertain by some 10 %).
"""

from __future__ import annotations

import argparse
import math
import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any
from unittest import mock

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

import nephrite
from benchmarks.efficiency import BODY, RESOLUTION, scene
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

FEWER: dict[str, tuple[Any, str, Any]] = {
    f"1 in {n} paths after lights": (roulette, "AFTER_LIGHT", 1 / n) for n in (4, 8, 16)
}
"""Of a dipole: what it may have less of, where it has 1 in 2 such paths; the rest of them counts the more."""


def changed(parts: list[str]) -> ExitStack:
    """Return a context in which parts are changed in what is recorded."""
    stack = ExitStack()
    for name in parts:
        stack.enter_context(mock.patch.object(*(PARTS | FEWER)[name]))
    return stack


def cases() -> dict[str, tuple[str, list[str]]]:
    """Return what is measured: a model, and its parts that are changed."""
    rays = list(PARTS)[:3]
    return {
        WALK: (WALK, []),
        "brdf": ("brdf", []),
        "dipole": ("dipole", []),
        **{f"dipole with {name}": ("dipole", [name]) for name in FEWER},
        **{f"dipole without {name}": ("dipole", [name]) for name in PARTS},
        "dipole without the first three": ("dipole", rays),
        "dipole without all four": ("dipole", list(PARTS)),
    }


@dataclass
class Found:
    """A case's seconds and pictures, round by round."""

    seconds: list[float] = field(default_factory=list)
    pictures: list[NDArray] = field(default_factory=list)

    @property
    def efficiency(self) -> float:
        """Of one picture, over the body's pixels, by how the rounds differ."""
        pictures = np.array(self.pictures, np.float64)
        return float(pictures.mean() ** 2 / (pictures.var(axis=0, ddof=1).mean() * np.median(self.seconds)))


def measure(spp: int, rounds: int) -> dict[str, Found]:
    """Render each case once a round; a round before them compiles."""
    b1 = scene()
    integrators: dict[str, Any] = {
        name: mi.load_dict({"type": "translucent_path", "model": model})
        for name, (model, _) in cases().items()
    }
    found = {name: Found() for name in cases()}
    for number in range(rounds + 1):
        for name, (_, parts) in cases().items():
            with changed(parts):
                start = time.perf_counter()
                picture = mi.render(b1, integrator=integrators[name], spp=spp, seed=number).numpy()
                if number > 0:
                    found[name].seconds.append(time.perf_counter() - start)
                    found[name].pictures.append(picture[BODY][..., :3])
    return found


def line(name: str, own: Found, walk: Found, samples: int) -> str:
    """Return a line of the table."""
    ratios = np.array(walk.seconds) / own.seconds
    error = 1.25 * ratios.std() / math.sqrt(len(ratios))  # of a median
    right = not set(cases()[name][1]) & set(PARTS)
    efficiency = f"{own.efficiency / walk.efficiency:.2f}" if right else "-"
    rate = samples / np.median(own.seconds) / 1e6
    return f"| {name} | {rate:.2f} | {np.median(ratios):.2f} ± {error:.2f} | {efficiency} |"


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
    print("| model | Msamples/s | / walk | efficiency / walk |\n| --- | --- | --- | --- |")
    width, height = RESOLUTION
    for name, own in found.items():
        print(line(name, own, found[WALK], width * height * given.spp))


if __name__ == "__main__":
    main()
