"""Make the table of `nephrite.profiles.tabulated`: `python -m nephrite.profiles.tabulate` (16 minutes of CPU time).

For each index of refraction and mean cosine, light that enters diffusely or straight is simulated
(`nephrite.physics.searchlight`), which serves every albedo. What is stored is the logarithm of R(r) for light of order
two and more, relative to `shape.reference`, as a cubic spline over log r: the maximum of the likelihood of the counts,
times a weak prior that the spline's differences are small (P-splines; Eilers and Marx 1996). That is all the
smoothing there is: nodes know nothing of each other. Light of order one, which every albedo only scales, is stored
apart. Totals are not stored: `nephrite.physics.halfspace` has them exactly.
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path

import numpy as np

from nephrite.physics import searchlight
from nephrite.physics.searchlight_walk import EXACT_ORDERS
from nephrite.profiles import tabulated_shape as shape

__all__ = ["cases", "fit", "main", "make", "node", "simulate"]

_ETA = (1.0, 1.04, 1.1, 1.2, 1.3, 1.45, 1.6, 1.85)
_G = (0.0, 0.25, 0.5, 0.7, 0.82, 0.9, 0.95)
_PATHS = (3_000_000, 2_000_000, 1_200_000, 800_000, 500_000, 300_000, 200_000)
"""Walks of any length for each `_G`; of walks of up to 128 events, which are cheap, there are more."""
_SHORT_PATHS = (10_000_000, 8_000_000, 7_000_000, 6_000_000, 5_000_000, 4_500_000, 4_000_000)
_PRIOR = {3: 0.03, 2: 0.15, 1: 0.3}
"""Expected size of the logarithm's differences of each order, at seven knots a decade: the third smooths, the others
keep it straight where there is no light to see."""
_EXITS = 200  # by which the mean weight of an exit is known
_FAR = 25.0  # decay lengths beyond which no light comes
_ASYMPTOTIC = 100.0  # reduced mean free paths at which white profiles follow the reference
_SIMULATED = 2
"""The first of `shape.T_NODES` that is simulated: whiter ones need walks of millions of events."""

Searchlights = tuple[searchlight.Searchlight, searchlight.Searchlight]


def cases() -> list[tuple[str, float, float, int]]:
    """Return (incidence, eta, g, seed) of every node of the table."""
    every = [(incidence, eta, g) for incidence in shape.INCIDENCES for eta in _ETA for g in _G]
    return [(*case, 1000 + 2 * place) for place, case in enumerate(every)]


def simulate(incidence: str, eta: float, g: float, seed: int, scale: float = 1.0) -> Searchlights:
    """Return searchlights of short walks and of walks of any length; `scale` multiplies their numbers."""
    effort = _G.index(g)

    def traced(paths: int, seed: int, longest: int) -> searchlight.Searchlight:
        return searchlight.simulate(
            eta, g, incidence=incidence, paths=int(scale * paths), seed=seed, longest=longest,
            radii=(1e-4, 3e5, 190),
        )  # fmt: skip

    short = traced(_SHORT_PATHS[effort], seed, EXACT_ORDERS + 1)
    return short, traced(_PATHS[effort], seed + 1, 2**20 if g < 0.6 else 2**21)


def _rings(
    lights: Searchlights, albedo: float, first: int, last: int | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return light in each ring and its variance; orders up to 128 from both searchlights together."""
    short, full = lights
    n_short, n_full = short.counts.paths, full.counts.paths
    bound = EXACT_ORDERS if last is None else last
    low = [light.profile(albedo, first=first, last=bound) for light in lights]
    share = n_short / (n_short + n_full)
    value = share * low[0].value + (1.0 - share) * low[1].value
    variance = (share * low[0].error) ** 2 + ((1.0 - share) * low[1].error) ** 2
    if last is None:
        everything = full.profile(albedo, first=first)
        value = value + everything.value - low[1].value
        variance = variance + np.maximum(everything.error**2 - low[1].error ** 2, 0.0)
    return value, variance


def fit(
    lights: Searchlights, albedo: float, first: int, last: int | None, decay: float, unit: float
) -> np.ndarray:
    """Return the spline's coefficients [`shape.KNOTS`]: log of the light over `shape.reference`.

    `unit`: mean free paths in the unit of r. Scoring: the counts of a ring are taken as Poisson, times the mean
    weight of an exit there.
    """
    light, variance = _rings(lights, albedo, first, last)
    edges = lights[0].setting.radii * unit
    light, variance = light[1:-1], variance[1:-1]
    inside = (edges[:-1] >= 0.999 * shape.R_MIN) & (edges[1:] <= shape.R_MAX) & (decay * edges[1:] < _FAR)
    light, variance = light[inside], variance[inside]
    lower, upper = np.log(edges[:-1][inside]), np.log(edges[1:][inside])
    nodes, weights = np.polynomial.legendre.leggauss(4)
    x = lower[:, None] + (upper - lower)[:, None] * 0.5 * (nodes + 1.0)
    base = shape.reference(x, decay) * (upper - lower)[:, None] * 0.5 * weights
    basis = shape.basis(x)
    weight_of_exit = _exit_weights(light, variance)
    prior = 1e-6 * np.eye(shape.KNOTS)
    for order, size in _PRIOR.items():
        difference = np.diff(np.eye(shape.KNOTS), n=order, axis=0) / size
        prior += difference.T @ difference
    c = np.full(shape.KNOTS, math.log(max(light.sum(), 1e-30) / base.sum()))
    for _ in range(60):
        parts = base * np.exp(basis @ c)
        model = parts.sum(axis=1)
        slope = np.einsum("kq,kqc->kc", parts, basis)
        information = (slope.T / (model * weight_of_exit)) @ slope + prior
        gradient = slope.T @ ((light / model - 1.0) / weight_of_exit) - prior @ c
        move = np.linalg.solve(information, gradient)
        c = c + move * min(1.0, 1.0 / np.abs(move).max())
        if np.abs(move).max() < 1e-7:
            break
    return c


def _exit_weights(light: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return the mean weight of an exit in each ring, over so many rings around it that some hundred exits count."""
    weights = np.zeros_like(light)
    for width in (15, 31, 61, 121, 2 * light.size + 1):
        first, last = np.arange(light.size) - width // 2, np.arange(light.size) + width // 2 + 1
        first, last = np.maximum(first, 0), np.minimum(last, light.size)
        within = [np.concatenate([[0.0], np.cumsum(sums)]) for sums in (light, variance)]
        total, squares = (sums[last] - sums[first] for sums in within)
        enough = (weights == 0.0) & ((total**2 > _EXITS * squares) | (width > light.size))
        weights[enough] = (squares / np.maximum(total, 1e-300))[enough]
    return weights


def node(lights: Searchlights) -> tuple[np.ndarray, np.ndarray]:
    """Return the splines of all albedos for orders from two [T, knots], and of order one [knots]."""
    eta, g, incidence = lights[0].setting.eta, lights[0].setting.g, lights[0].setting.incidence
    rows = np.empty((shape.T_NODES.size, shape.KNOTS))
    for row, t in enumerate(shape.T_NODES):
        if row < _SIMULATED:
            continue
        reduced = max(1.0 - t**4, shape.LEAST_REDUCED)
        albedo = shape.albedo_of(reduced, g)
        rows[row] = fit(lights, albedo, 2, None, shape.decay(reduced), 1.0 - albedo * g)
        rows[row] -= 2.0 * math.log(albedo)
    # near white, far light is like the reference; what is whiter than the simulations is so everywhere
    white = rows[_SIMULATED]
    far = shape.KNOTS - 3 - np.arange(shape.KNOTS) < np.log(shape.R_MAX / _ASYMPTOTIC) / shape.STEP
    rows[: _SIMULATED + 1] = np.where(far, white[~far][-1], white)
    return rows, fit(lights, 1.0, 1, 1, shape.single_decay(eta, str(incidence)), 1.0)


def make(path: Path, scale: float = 1.0) -> None:
    """Simulate, fit and write the table to `path`; the same every time. `scale` multiplies the number of walks."""
    started = time.perf_counter()
    multiple, single = [], []
    for case in cases():
        rows, once = node(simulate(*case, scale=scale))
        multiple.append(rows)
        single.append(once)
        done = f"{len(single)} of {len(cases())}, {time.perf_counter() - started:.0f} s"
        print(f"\r{done}", end="", file=sys.stderr, flush=True)
    nodes = (len(shape.INCIDENCES), len(_ETA), len(_G))
    shape.write(
        path,
        np.asarray(_ETA),
        np.asarray(_G),
        np.reshape(multiple, (*nodes, shape.T_NODES.size, shape.KNOTS)),
        np.reshape(single, (*nodes, shape.KNOTS)),
    )
    print(f"\n{path}: {path.stat().st_size / 1024:.0f} KiB", file=sys.stderr)


def main() -> None:
    """Write the table that the package ships, or the file that is named."""
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else shape.PACKAGED)


if __name__ == "__main__":
    main()
