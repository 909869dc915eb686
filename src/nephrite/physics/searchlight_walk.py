"""The walks of `nephrite.physics.searchlight`: one loop in which each lane starts its next walk as one ends.

Lengths are mean free paths 1/sigma_t; z points into the medium. Nothing absorbs here: an exit is counted by its order
of scattering, and the albedo comes in afterwards. Each walk exits once at the most, so that the sums of weights and of
their squares give the exact variance. Long walks play Russian roulette with weights that are powers of two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from nephrite.physics import fresnel, phase

__all__ = ["EXACT_ORDERS", "Counts", "Setting", "order_bins", "representative_orders", "trace"]

EXACT_ORDERS = 128
"""Orders up to this one have a bin each; beyond, bins widen by `_WIDENING`."""

_WIDENING = 1.02
_QUANTILES = 4096
_ROULETTE = 16  # reduced order at which it begins; once more each time that the order has grown fourfold
_LANES = 1024


@dataclass(frozen=True)
class Setting:
    """What is simulated; checked by `searchlight.simulate`, whose parameters these are."""

    eta: float
    g: float
    thickness: float
    incidence: str | float
    beam_radius: float
    longest: int
    radii: np.ndarray  # edges of the rings, evenly spaced in log r
    directions: int  # bins of the squared sine outside


@dataclass(frozen=True)
class Counts:
    """Sums over `paths` walks of weights `[..., 0, ...]` and of their squares `[..., 1, ...]`.

    `rings`: [2 sides, 2, orders, rings + 2], within the first radius first and beyond the last one last; `sines`: [2,
    2, orders, directions]; `cut`: weight of walks that had `longest` events.
    """

    paths: int
    rings: np.ndarray
    sines: np.ndarray
    cut: float


def order_bins(longest: int) -> int:
    """Return how many bins of order there are if no walk has more than `longest` events."""
    return EXACT_ORDERS + 2 + max(0, math.ceil(math.log(longest / EXACT_ORDERS) / math.log(_WIDENING)))


def representative_orders(bins: int) -> np.ndarray:
    """Return the order that stands for each bin: exact up to `EXACT_ORDERS`, then the bin's geometric mean."""
    index = np.arange(bins, dtype=np.float64)
    return np.where(index <= EXACT_ORDERS, index, EXACT_ORDERS * _WIDENING ** (index - EXACT_ORDERS - 0.5))


def _entering_quantiles(eta: float) -> np.ndarray:
    """Cosine inside of diffuse light that has entered, at evenly spaced values of (share below)^(2/3)."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(0.0, 1.0, 4 * _QUANTILES + 1) ** 2  # of the squared cosine outside
    squared = edges[:-1, None] + np.diff(edges)[:, None] * 0.5 * (nodes + 1.0)
    passing = (1.0 - fresnel.reflectance(np.sqrt(squared), eta)) @ weights * np.diff(edges)
    below = np.concatenate([[0.0], np.cumsum(passing)]) / passing.sum()
    share = np.linspace(0.0, 1.0, _QUANTILES + 1)
    outside = np.interp(share, below ** (2.0 / 3.0), np.sqrt(edges))
    return np.asarray(fresnel.refracted_cosine(outside, eta))


def trace(setting: Setting, paths: int, seed: int) -> Counts:
    """Simulate at least `paths` walks (a whole number a lane) on the CPU's vector units; fixed by `seed`."""
    import drjit as dr
    import drjit.llvm as jit

    eta, g = setting.eta, setting.g
    lanes = min(_LANES, max(16, paths // 16))
    each = -(-paths // lanes)
    bins, rings = order_bins(setting.longest), setting.radii.size + 1
    first_ring = math.log2(setting.radii[0])
    rings_an_octave = (rings - 2) / math.log2(setting.radii[-1] / setting.radii[0])
    bins_an_octave = math.log(2.0) / math.log(_WIDENING)
    roulette = math.ceil(_ROULETTE / (1.0 - max(g, 0.0)))
    sums = [dr.zeros(jit.Float64, 2 * bins * rings) for _ in range(2)]
    lobes = [dr.zeros(jit.Float64, 2 * bins * setting.directions) for _ in range(2)]
    cut = dr.zeros(jit.Float64, 1)
    quantiles = None
    if setting.incidence == "diffuse":
        quantiles = jit.Float(_entering_quantiles(eta).astype(np.float32))
    dr.eval(sums, lobes, cut, quantiles)

    def enter(rng: Any) -> tuple[Any, Any, Any, Any]:
        """Start a walk: its x and y, and its direction's x and z; light enters in the plane of x and z."""
        if quantiles is not None:
            at = jit.Float(dr.power(rng.next_float32(), 2.0 / 3.0)) * _QUANTILES
            index = dr.minimum(jit.UInt32(at), _QUANTILES - 1)
            low, high = dr.gather(jit.Float, quantiles, index), dr.gather(jit.Float, quantiles, index + 1)
            cosine = dr.lerp(low, high, at - jit.Float(index))
        else:
            outside = 1.0 if setting.incidence == "normal" else float(setting.incidence)
            cosine = jit.Float(fresnel.refracted_cosine(outside, eta))
        x, y = jit.Float(0.0), jit.Float(0.0)
        if setting.beam_radius > 0.0:
            spread = 0.5 * setting.beam_radius * dr.sqrt(-2.0 * dr.log(1.0 - rng.next_float32()))
            y, x = dr.sincos(2.0 * math.pi * rng.next_float32())
            x, y = spread * x, spread * y
        return x, y, dr.safe_sqrt(1.0 - cosine * cosine), cosine

    def step(rng, left, x, y, z, wx, wy, wz, weight, order, threshold):
        # fly to the next event, or to the surface if that is nearer
        flight = -dr.log(1.0 - rng.next_float32())
        u1, u2, u3 = rng.next_float32(), rng.next_float32(), rng.next_float32()
        deep = dr.fma(flight, wz, z)
        back, through = deep < 0.0, deep > setting.thickness
        surface = back | through
        length = dr.select(surface, (dr.select(back, 0.0, setting.thickness) - z) / wz, flight)
        x, y = dr.fma(length, wx, x), dr.fma(length, wy, y)
        z = dr.clip(deep, 0.0, setting.thickness)

        # leave, or be reflected back in
        reflected = fresnel.reflectance(-dr.abs(wz), eta)
        leaves = surface & (u1 >= reflected)
        side = dr.select(through, jit.UInt32(bins), jit.UInt32(0))
        beyond = dr.maximum(dr.log2(jit.Float(order) / EXACT_ORDERS), 0.0) * bins_an_octave
        row = side + dr.select(order <= EXACT_ORDERS, order, EXACT_ORDERS + 1 + jit.UInt32(beyond))
        ring = (dr.log2(dr.maximum(dr.sqrt(x * x + y * y), 1e-20)) - first_ring) * rings_an_octave + 1.0
        ring = jit.UInt32(dr.clip(ring, 0.0, rings - 1.0))
        squared_sine = eta * eta * (1.0 - wz * wz)
        sine = jit.UInt32(dr.minimum(squared_sine * setting.directions, setting.directions - 1.0))
        for power in range(2):
            value = jit.Float64(weight * weight if power else weight)
            dr.scatter_add(sums[power], value, row * rings + ring, leaves)
            dr.scatter_add(lobes[power], value, row * setting.directions + sine, leaves)

        # scatter
        event = ~surface
        if g == 0.0:
            px, py, pz = phase.sample(u1, u2, 0.0)
        else:
            px, py, pz = _rotate(dr, wx, wy, wz, *phase.sample(u1, u2, g))
        wx, wy = dr.select(event, px, wx), dr.select(event, py, wy)
        wz = dr.select(event, pz, -wz)
        order = order + dr.select(event, jit.UInt32(1), jit.UInt32(0))

        # roulette
        plays = event & (order >= threshold)
        dies = plays & (u3 < 0.5)
        threshold = dr.select(plays, 4 * threshold, threshold)
        weight = dr.select(plays, 2.0 * weight, weight)
        late = event & (order >= setting.longest) & ~dies
        dr.scatter_add(cut, jit.Float64(weight), jit.UInt32(0), late)

        # start the next walk
        ends = leaves | dies | late
        left = left - dr.select(ends, jit.UInt32(1), jit.UInt32(0))
        start = enter(rng)
        x, y, z = dr.select(ends, start[0], x), dr.select(ends, start[1], y), dr.select(ends, 0.0, z)
        wx, wy, wz = dr.select(ends, start[2], wx), dr.select(ends, 0.0, wy), dr.select(ends, start[3], wz)
        weight, order = dr.select(ends, 1.0, weight), dr.select(ends, jit.UInt32(0), order)
        threshold = dr.select(ends, jit.UInt32(roulette), threshold)
        return rng, left, x, y, z, wx, wy, wz, weight, order, threshold

    rng = jit.PCG32(lanes, jit.UInt64(seed))
    zero = dr.zeros(jit.Float, lanes)
    x, y, wx, wz = (value + zero for value in enter(rng))
    state = (
        *(rng, dr.full(jit.UInt32, each, lanes), x, y, zero, wx, zero, wz, zero + 1.0),
        *(dr.zeros(jit.UInt32, lanes), dr.full(jit.UInt32, roulette, lanes)),
    )
    state = dr.while_loop(state, lambda rng, left, *rest: left > 0, step, mode="symbolic")
    dr.eval(state, sums, lobes, cut)
    shape = (2, bins, -1)
    return Counts(
        paths=each * lanes,
        rings=np.stack([s.numpy().reshape(shape) for s in sums], axis=1),
        sines=np.stack([s.numpy().reshape(shape) for s in lobes], axis=1),
        cut=float(cut[0]),
    )


def _rotate(dr: Any, wx: Any, wy: Any, wz: Any, px: Any, py: Any, pz: Any) -> tuple[Any, Any, Any]:
    """Turn a direction p around the z axis to one around w (frame of Duff et al. 2017), kept at unit length."""
    sign = dr.copysign(1.0, wz)
    a = -1.0 / (sign + wz)
    b = wx * wy * a
    x = px * (1.0 + sign * wx * wx * a) + py * b + pz * wx
    y = px * sign * b + py * (sign + wy * wy * a) + pz * wy
    z = pz * wz - px * sign * wx - py * wy
    length = 1.5 - 0.5 * (x * x + y * y + z * z)
    return length * x, length * y, length * z
