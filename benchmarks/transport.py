"""How far precomputed transport is from the walk on B1, by blocks of 16 x 16 pixels, and how noisy its walks leave it.

    .venv/bin/python benchmarks/transport.py [--spp 1024] [--pictures 4] [--samples 128] [--walks N] [--truth FILE]

Of what scatters at least twice: all else both compute alike. `--spp`: samples of the walk, exit lobe, whose picture is
kept in FILE, if one is named. Each picture of `transport` has `--samples` a pixel and walks of its own, as many as a
render of so many samples makes unless `--walks` says so: the noise that they leave is common to the pixels of a block,
and told by how the pictures differ.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from efficiency import scene
from numpy.typing import NDArray

import nephrite
from nephrite.atlas.compared import WORST_BLOCK, Estimate, sums
from nephrite.scene.translucent import object_mask

PASSES = 16  # of the walk


def render(b1: Any, spp: int, seed: int, **settings: Any) -> NDArray[np.float64]:
    """Return a picture of what scatters at least twice, by an integrator of its own."""
    integrator: Any = mi.load_dict({"type": "translucent_path", "terms": "multiple", **settings})
    return mi.render(b1, integrator=integrator, spp=spp, seed=seed).numpy()[..., :3].astype(np.float64)  # type: ignore[arg-type]


def walked(b1: Any, spp: int, file: Path | None) -> Estimate:
    """Return the walk's picture, from the file if it is there."""
    if file is not None and file.exists():
        with np.load(file) as kept:
            return Estimate(kept["mean"], kept["error"])
    each = max(spp // PASSES, 1)
    passes = [render(b1, each, 1000 + i, model="walk") for i in range(PASSES)]
    found = Estimate(np.mean(passes, axis=0), np.std(passes, axis=0, ddof=1) / PASSES**0.5)
    if file is not None:
        np.savez(file, mean=found.mean, error=found.error)
    return found


def report(pictures: list[NDArray], truth: Estimate, mask: NDArray[np.bool_]) -> str:
    """Return bias, error of blocks and the worst of them in words, and the noise of one picture."""
    exact = np.zeros_like(truth.error)
    whole = [sums(Estimate(picture, exact), truth, mask, None) for picture in pictures]
    parts = [sums(Estimate(picture, exact), truth, mask, WORST_BLOCK) for picture in pictures]
    bias = np.mean([a[0] / b[0] - 1.0 for a, b, *_ in whole], axis=0)
    b, vb = (parts[0][i].sum(axis=1) for i in (1, 3))
    blocks = np.array([a.sum(axis=1) / b - 1.0 for a, *_ in parts])
    own = blocks.var(axis=0, ddof=1) / len(blocks)
    mean, noise = blocks.mean(axis=0), own + vb / b**2
    rms = np.sqrt(max(float((mean**2 - noise).mean()), 0.0))
    at = int(np.abs(mean).argmax())
    inside = np.array([picture[mask] for picture in pictures])
    variance = inside.var(axis=0, ddof=1).mean() / inside.mean() ** 2
    return "\n".join(
        (
            "bias, red green blue: " + " ".join(f"{100 * x:+.2f}" for x in bias) + " %",
            f"blocks: error {100 * rms:.2f} % (noise taken out), "
            f"worst {100 * mean[at]:+.1f} +- {100 * noise[at] ** 0.5:.1f} %",
            f"one picture: relative variance of a pixel {variance:.5f}, "
            f"standard deviation of a block {100 * np.sqrt(blocks.var(axis=0, ddof=1).mean()):.2f} %",
        )
    )


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spp", type=int, default=1024)
    parser.add_argument("--pictures", type=int, default=4)
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("--walks", type=int)
    parser.add_argument("--truth", type=Path)
    given = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    b1 = scene()
    truth = walked(b1, given.spp, given.truth)
    settings = {"model": "transport"} | ({"walks": given.walks} if given.walks else {})
    pictures = [render(b1, given.samples, 1 + i, **settings) for i in range(given.pictures)]
    print(f"Nephrite {nephrite.__version__}, {mi.variant()}, scene B1, {given.pictures} pictures")
    print(report(pictures, truth, object_mask(b1)))


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
