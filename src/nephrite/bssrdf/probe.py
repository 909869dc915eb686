"""Probe rays: find a surface point around another one, with a density that can be evaluated afterwards.

A radius is drawn from the profile of one colour channel, and projected onto the surface along one of three axes: the
normal with probability 1/2, two tangents with 1/4 each. All hits on the object along the chord of the sphere of
radius `r_max` count, and one of them is chosen. The density of the point, per area, is a balance heuristic over axes
and channels (King et al. 2013; Pharr et al. 2016, section 15.4).
"""

from __future__ import annotations

import math
from typing import Any

import drjit as dr

__all__ = ["AXES", "chord", "density", "frame_axis", "truncation_radius"]

AXES = (0.25, 0.25, 0.5)
"""Probability of projecting along the first tangent, the second tangent, the normal."""

_TRUNCATED = 1e-3


def truncation_radius(profile: Any, longest: Any) -> Any:
    """Radius r_max within which all but a thousandth of the profile's light leaves, `longest` at the most.

    By bisection of `profile.cdf` in ln r between `1e-6 longest` and `longest`.
    """
    low, high = dr.log(longest * 1e-6) + 0.0 * profile.z_real, dr.log(longest) + 0.0 * profile.z_real
    for _ in range(16):
        middle = 0.5 * (low + high)
        inside = profile.cdf(dr.exp(middle)) < 1.0 - _TRUNCATED
        low, high = dr.select(inside, middle, low), dr.select(inside, high, middle)
    return dr.exp(high)


def frame_axis(frame: Any, u: Any) -> tuple[Any, Any, Any]:
    """Choose the axis of projection for a uniform number; return (axis, and the two that span its plane)."""
    s, t, n = frame.s, frame.t, frame.n
    first, second = u < AXES[0], u < AXES[0] + AXES[1]
    axis = dr.select(first, s, dr.select(second, t, n))
    across = dr.select(first, t, dr.select(second, n, s))
    along = dr.select(first, n, dr.select(second, s, t))
    return axis, across, along


def chord(p: Any, axes: tuple[Any, Any, Any], r: Any, r_max: Any, u: Any) -> tuple[Any, Any, Any]:
    """Return (origin, direction, length) of the probe ray at the radius `r` around `p`, at the angle 2 pi u."""
    axis, across, along = axes
    sine, cosine = dr.sincos(2.0 * math.pi * u)
    half = dr.sqrt(dr.maximum(r_max * r_max - r * r, 0.0))
    origin = p + r * (across * cosine + along * sine) + half * axis
    return origin, -axis, 2.0 * half


def density(profile: Any, frame: Any, offset: Any, normal: Any, r_max: Any, weights: Any) -> Any:
    """Density per area with which the probe finds the point at `offset` with the surface normal `normal`.

    One number for each channel of `profile`, already weighted: sum them. `r_max`, `weights`: truncation radius and
    probability of each channel. The density of a radius is `pdf(r) / cdf(r_max)`; over the circle, per area of the
    plane, it is divided by 2 pi r.
    """
    total = 0.0
    within = profile.cdf(r_max)
    for axis, probability in zip((frame.s, frame.t, frame.n), AXES, strict=True):
        height = dr.dot(offset, axis)
        r2 = dr.maximum(dr.squared_norm(offset) - height * height, 1e-20)
        r = dr.sqrt(r2)
        flat = profile.pdf(r) / (2.0 * math.pi * r * dr.maximum(within, 1e-20))
        reach = (r < r_max) & (height * height <= r_max * r_max - r2)
        total += probability * dr.abs(dr.dot(normal, axis)) * dr.select(reach, flat, 0.0)
    return total * weights
