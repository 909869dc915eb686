"""Probe rays: find the surface around a point, with a density that can be evaluated afterwards.

A radius is drawn from the profile of one colour channel and projected onto the surface along one of three axes: the
normal, more often, or one of two tangents. Every hit on the object counts that lies on the chord of a sphere
(`half_chord`). The density of a point, per area, is that of the balance heuristic over axes and channels (King et al.
2013; Pharr et al. 2016, section 15.4).
"""

from __future__ import annotations

import math
from typing import Any

import drjit as dr

__all__ = ["AXES", "axis", "chord", "density", "half_chord", "truncation_radius"]

AXES = (0.6, 0.2, 0.2)
"""Probability of the normal and of the two tangents."""


def truncation_radius(profile: Any, longest: Any) -> Any:
    """Radius r_max beyond which the profile is not searched: its reach, `longest` at the most."""
    return dr.minimum(profile.reach(), longest)


def axis(frame: Any, u: Any) -> tuple[Any, Any, Any]:
    """Choose the axis of projection for a uniform number; return it and the two that span its plane."""
    s, t, n = frame.s, frame.t, frame.n
    first, second = u < AXES[0], u < AXES[0] + AXES[1]
    along = dr.select(first, n, dr.select(second, s, t))
    across = dr.select(first, s, dr.select(second, t, n))
    other = dr.select(first, t, dr.select(second, n, s))
    return along, across, other


def half_chord(r: Any, r_max: Any, z: Any) -> Any:
    """Height above and below the tangent plane, at the radius `r`, within which points are looked for.

    Half the chord of the sphere of radius `r_max`, but `3 r + 2 z` at the most, with `z` the depth of the profile's
    deeper pole: long rays are slow, and what is much farther off along one axis is nearer to another one's plane.
    """
    return dr.minimum(dr.sqrt(dr.maximum(r_max * r_max - r * r, 0.0)), 3.0 * r + 2.0 * z)


def chord(p: Any, axes: tuple[Any, Any, Any], r: Any, half: Any, u: Any) -> tuple[Any, Any, Any]:
    """Return (origin, direction, length) of the probe ray at the radius `r` around `p`, at the angle 2 pi u."""
    along, across, other = axes
    sine, cosine = dr.sincos(2.0 * math.pi * u)
    origin = p + r * (across * cosine + other * sine) + half * along
    return origin, -along, 2.0 * half


def density(profile: Any, frame: Any, offset: Any, normal: Any, r_max: Any) -> Any:
    """Density per area with which the probe finds the point at `offset` with the surface normal `normal`.

    One number for each channel of `profile` as the one that the radius was drawn for; `r_max`: its truncation radius.
    The density of a radius is `pdf(r) / cdf(r_max)`; over the circle, per area of the plane, it is divided by 2 pi r.
    """
    total = 0.0
    within = dr.maximum(profile.cdf(r_max), 1e-20)
    distance2 = dr.squared_norm(offset)
    for along, probability in zip((frame.n, frame.s, frame.t), AXES, strict=True):
        height = dr.dot(offset, along)
        r = dr.sqrt(dr.maximum(distance2 - height * height, 1e-20))
        flat = profile.pdf(r) / (2.0 * math.pi * r * within)
        total += (
            probability
            * dr.abs(dr.dot(normal, along))
            * dr.select(dr.abs(height) <= half_chord(r, r_max, profile.z_virtual), flat, 0.0)
        )
    return total
