"""How far the tabulated profile is from fresh simulations, over the atlas' grid of albedo', eta and g.

    .venv/bin/python benchmarks/tabulated.py [--paths 19] [--normal]

For each eta and g, one simulation of 2^paths paths serves all albedos. The total is compared with the exact solution
(`nephrite.physics.halfspace`); the profile, by its L1 distance, with the simulation's light in rings, three a decade.
Both in percent of the light that leaves, the worst over the albedos; *noise* is what that distance would be of a
perfect profile. Without `--normal`, light enters evenly and scatters twice at least, as in renders; with it, it is a
pencil beam, and all of it counts.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from nephrite.atlas.plan import FULL
from nephrite.physics import halfspace, searchlight
from nephrite.profiles.tabulated import TabulatedProfile
from nephrite.profiles.tabulated_shape import albedo_of

RADII = (0.01, 100.0, 12)  # first and last edge, in mean free paths, and number of the rings
LONGEST = 2**16  # events; what goes on is a share of the light that is below the noise


def compared(
    eta: float, g: float, reduced: float, light: searchlight.Searchlight, normal: bool
) -> list[float]:
    """Return errors of total and profile, and the noise in the latter, in percent."""
    albedo = albedo_of(reduced, g)
    incidence, orders = ("normal", "all") if normal else ("diffuse", "multiple")
    rings = light.profile(albedo, first=1 if normal else 2)
    profile = TabulatedProfile(1.0 - reduced, reduced, eta, g, incidence, orders)
    exact = halfspace.total_reflectance(albedo, eta, g, incidence, not normal)
    # the simulation's lengths are in mean free paths, the profile's in reduced ones
    within = np.array([*profile.cdf(rings.edges[:-1] * (1.0 - albedo * g)), 1.0])
    expected = profile.albedo() * np.diff(within)
    noise = rings.error.sum() * math.sqrt(2.0 / math.pi)
    errors = profile.albedo() - exact, np.abs(rings.value - expected).sum(), noise
    return [100.0 * float(error) / exact for error in errors]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--paths", type=int, default=19)
    parser.add_argument("--normal", action="store_true")
    given = parser.parse_args()
    print("| eta | g | total % | profile % | at albedo' | noise % |\n| --- | --- | --- | --- | --- | --- |")
    for eta in FULL.etas:
        for g in FULL.gs:
            light = searchlight.simulate(
                eta,
                g,
                incidence="normal" if given.normal else "diffuse",
                paths=2**given.paths,
                seed=2026,
                longest=LONGEST,
                radii=RADII,
            )
            rows = [compared(eta, g, reduced, light, given.normal) for reduced in FULL.albedos]
            total = max((row[0] for row in rows), key=abs)
            worst = max(range(len(rows)), key=lambda i: rows[i][1])
            print(
                f"| {eta:g} | {g:g} | {total:+.3f} | {rows[worst][1]:.2f} | {FULL.albedos[worst]:g} | "
                f"{rows[worst][2]:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
