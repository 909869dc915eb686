"""What similarity is off, and how much time it saves: the walks that `transport` is made of, in B1's dragon.

    .venv/bin/python benchmarks/similarity.py [--walks 1048576]

Walks begin everywhere on the dragon, in skim milk with another g and the same sigma_s (1 - g), and go on by similarity
once they have forgotten their direction (`nephrite.plugins.walked`); or never. *Light*: how much more of it leaves
again after two events or more. *Worst distance*: the largest difference among the light that leaves at six ranges of
distances, over all of it. Both with a standard error, in per cent; all channels together.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

import nephrite
from nephrite import materials
from nephrite.plugins import walked
from nephrite.plugins.media import Media
from nephrite.plugins.shapes import start
from nephrite.scene import build, named

GS, SIZES = (0.5, 0.9), (10.0, 100.0)
RANGES = 6  # of distances, each holding as much light


def dragon(size: float, g: float) -> Any:
    """Return B1, `size` mm long, with another g."""
    medium = materials.find("skim milk").medium
    bsdf = {
        "type": "translucent", "int_ior": medium.eta, "ext_ior": 1.0, "g": g,
        "sigma_a": {"type": "rgb", "value": list(medium.sigma_a)},
        "sigma_s": {"type": "rgb", "value": [s / (1.0 - g) for s in medium.sigma_s_prime]},
    }  # fmt: skip
    return mi.load_dict(build.scene_dict(named.find("dragon"), bsdf, size, light="benchmark"), optimize=False)


def ends(scene: Any, count: int, seed: int) -> tuple[NDArray, NDArray, float]:
    """Return how far walks get, what light each brings, and the seconds they take."""
    media = Media.of(scene)
    (entry,) = media.entries
    sampler: Any = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    begun = start(scene, media.winding, entry.shapes[0], sampler)
    dr.eval(begun.si)
    before = time.perf_counter()
    found = walked.walk(scene, seed, entry, begun.si, entry.shapes[0], dr.arange(mi.UInt32, count))
    dr.sync_thread()
    seconds = time.perf_counter() - before
    return np.array(dr.norm(found.p - begun.si.p)), np.array(found.weight).mean(axis=0), seconds


def row(size: float, g: float, count: int) -> str:
    """Return a line of the table."""
    scene, found = dragon(size, g), []
    for order in (walked._SIMILAR, float("inf")):
        walked._SIMILAR, kept = order, walked._SIMILAR
        ends(scene, 1 << 12, 0)  # compiles
        found.append(ends(scene, count, len(found) + 1))
        walked._SIMILAR = kept
    (far, light, seconds), (own_far, own, own_seconds) = found
    edges = np.quantile(own_far[own > 0], np.linspace(0.0, 1.0, RANGES + 1))[1:-1]
    a, b = (np.bincount(np.digitize(x, edges), w, RANGES) / count for x, w in ((far, light), (own_far, own)))
    squares = sum(
        np.bincount(np.digitize(x, edges), w * w, RANGES) for x, w in ((far, light), (own_far, own))
    )
    error = np.sqrt(squares) / count
    total = float(b.sum())
    at = int(np.abs(a - b).argmax())
    noise = np.hypot(light.std(), own.std()) / count**0.5
    values = (a.sum() / total - 1, noise / total, (a - b)[at] / total, error[at] / total)
    percent = "{:+.2f} ± {:.2f} | {:+.2f} ± {:.2f}".format(*(100 * x for x in values))
    return f"| {size:g} | {g:g} | {percent} | {own_seconds / seconds:.1f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--walks", type=int, default=1 << 20)
    count = parser.parse_args().walks
    mi.set_variant("llvm_ad_rgb")
    print(f"Nephrite {nephrite.__version__}, {mi.variant()}, {count:,} walks each")
    print("| size, mm | g | light % | worst distance % | times faster |\n| --- | --- | --- | --- | --- |")
    for size in SIZES:
        for g in GS:
            print(row(size, g, count), flush=True)


if __name__ == "__main__":
    main()
