"""Probe rays: find the surface around a point, with a density that can be evaluated afterwards.

A distance is drawn and projected onto the surface along one of three axes: the normal, more often, or one of two
tangents. Every hit on the object counts. The density of a point, per area, is that of the balance heuristic over axes
and over all that the distance may have been drawn from (King et al. 2013; Pharr et al. 2016, section 15.4).

Distances are drawn as the rays from a point at the depth z, a *pole*, meet a plane: with the density
`z / (2 pi d^3)` per area, d^2 = r^2 + z^2, which is what a dipole's terms fall off with (see `kernel`).

Chords are of random length. What lies far off along an axis is dark, so that a long chord is seldom worth its rays;
yet none may be left out, or folds and thin parts would lose their light. The length is drawn such that a point at the
height h is reached with the probability `min(1, (a / h)^2)`; kernels fall off faster than that.
"""

from __future__ import annotations

import math
from typing import Any

import drjit as dr

__all__ = ["AXES", "axis", "chord", "density", "distance", "reached"]

AXES = (0.6, 0.2, 0.2)
"""Probability of the normal and of the two tangents."""


def axis(frame: Any, u: Any) -> tuple[Any, Any, Any]:
    """Choose the axis of projection for a uniform number; return it and the two that span its plane."""
    s, t, n = frame.s, frame.t, frame.n
    first, second = u < AXES[0], u < AXES[0] + AXES[1]
    along = dr.select(first, n, dr.select(second, s, t))
    across = dr.select(first, s, dr.select(second, t, n))
    other = dr.select(first, t, dr.select(second, n, s))
    return along, across, other


def distance(z: Any, u: Any) -> Any:
    """Distance in the plane, for a uniform number, of the ray from a pole at the depth `z`."""
    cosine = 1.0 - u
    return z * dr.sqrt(dr.maximum(1.0 / (cosine * cosine) - 1.0, 0.0))


def reached(height: Any, r: Any, core: Any) -> Any:
    """Probability that the chord at the distance `r` reaches the height: `min(1, (a / h)^2)`, a = r + core.

    `core`: a length of the order of the reduced mean free path, within which kernels are nearly even.
    """
    near = (r + core) / dr.maximum(dr.abs(height), 1e-20)
    return dr.minimum(near * near, 1.0)


def chord(p: Any, axes: tuple[Any, Any, Any], r: Any, core: Any, u: Any, v: Any) -> tuple[Any, Any, Any]:
    """Return (origin, direction, length) of the projection at the distance `r` from `p`.

    Its angle is 2 pi u; its length follows `reached` for the uniform number `v`.
    """
    along, across, other = axes
    sine, cosine = dr.sincos(2.0 * math.pi * u)
    half = (r + core) * dr.rsqrt(1.0 - v)
    origin = p + r * (across * cosine + other * sine) + half * along
    return origin, -along, 2.0 * half


def density(poles: list[tuple[Any, Any]], frame: Any, offset: Any, normal: Any, core: Any) -> Any:
    """Density per area with which the probe finds the point at `offset` with the surface normal `normal`.

    `poles`: (depth, probability) of all that the distance may be drawn from, in all channels.
    """
    total, squared = 0.0, dr.squared_norm(offset)
    for along, share in zip((frame.n, frame.s, frame.t), AXES, strict=True):
        height = dr.dot(offset, along)
        r2 = dr.maximum(squared - height * height, 0.0)
        flat = 0.0
        for z, probability in poles:
            inverse = dr.rsqrt(dr.maximum(r2 + z * z, 1e-20))
            flat += probability * z * (inverse * inverse * inverse)
        total += share * dr.abs(dr.dot(normal, along)) * reached(height, dr.sqrt(r2), core) * flat
    return total * (0.5 / math.pi)
