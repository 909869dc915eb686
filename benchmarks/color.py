"""How far rendered colours are from those asked for, over colour, index, g and roughness, for each map.

    python benchmarks/color.py [--eta 1 1.3 1.6] [--g 0 .5 .9] [--alpha 0 .2 .5] [--colors ...] [--error .25]

`exact` is `nephrite.physics.color`, rendered by the exact walk on a thick plate (tests/support/plate.py); each cell is
rendered until its standard error is about `--error` percent. The maps below it are those that other renderers ship:
errors in percent of the colour that their media show, by the exact map. A dash: no medium under a surface so rough is
that light.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from pathlib import Path

import numpy as np

import nephrite  # noqa: F401 (before Mitsuba)
from nephrite.physics import color, inversion

import mitsuba as mi  # isort: skip

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

PASSES = 8
MAPS = {
    "chiang": lambda asked, g: inversion.chiang_albedo(asked),
    "van de hulst": lambda asked, g: _reduced(inversion.van_de_hulst_albedo(asked, g), g),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--eta", type=float, nargs="*", default=[1.0, 1.3, 1.6])
    parser.add_argument("--g", type=float, nargs="*", default=[0.0, 0.5, 0.9])
    parser.add_argument("--alpha", type=float, nargs="*", default=[0.0, 0.2, 0.5])
    parser.add_argument("--colors", type=float, nargs="*", default=[0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98])
    parser.add_argument("--error", type=float, default=0.25, help="standard error of a cell, in percent")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    options = parser.parse_args()
    mi.set_variant(options.variant)

    start = time.perf_counter()
    asked = np.array(options.colors)
    print(f"{'eta':>4} {'g':>5} {'alpha':>5} {'map':>13} " + " ".join(f"{c:>14g}" for c in asked))
    worst, cells, scores = 0.0, 0, []
    for eta, g, alpha in itertools.product(options.eta, options.g, options.alpha):
        if eta == 1.0 and alpha > 0.0:
            continue  # a matched surface is none
        of = color.color_map(eta, g, alpha)
        row = []
        for one in asked:
            if one > of.reach:
                row.append(f"{'-':>14}")
                continue
            error, spread = rendered(one, eta, g, alpha, options.error)
            row.append(f"{error:+7.2f} +-{spread:5.2f}")
            worst, cells = max(worst, abs(error)), cells + 1
            scores.append(error / spread)
        print(f"{eta:4g} {g:5g} {alpha:5g} {'exact':>13} " + " ".join(row), flush=True)
        for name, map_ in MAPS.items():
            off = 100 * (of.color(map_(asked, g)) / asked - 1)
            print(f"{'':16} {name:>13} " + " ".join(f"{value:+14.1f}" for value in off))
    print(
        f"{cells} cells in {time.perf_counter() - start:.0f} s: largest error {worst:.2f} %; in standard errors, "
        f"mean {np.mean(scores):+.2f}, root mean square {np.sqrt(np.mean(np.square(scores))):.2f}"
    )


def rendered(asked: float, eta: float, g: float, alpha: float, percent: float) -> tuple[float, float]:
    """Return the error of the rendered colour, and its standard error, in percent."""
    from support import plate

    paths = (0.36 * (1 - asked) / asked + 0.15) / (0.01 * percent) ** 2
    scene = plate.scene(color.from_color_and_radius(asked, 1.0, g, eta, alpha), alpha)
    found = plate.shown(
        scene, int(paths / PASSES) + 1, PASSES, seed=round(1e4 * (eta + asked + g) + 1e3 * alpha)
    )
    shown = found[:, 0] / color.color_map(eta, g, alpha).entering
    return 100 * (shown.mean() / asked - 1), 100 * shown.std(ddof=1) / np.sqrt(PASSES) / asked


def _reduced(albedo: np.ndarray, g: float) -> np.ndarray:
    return albedo * (1 - g) / (1 - albedo * g)


if __name__ == "__main__":
    main()
