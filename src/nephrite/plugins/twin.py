"""The twin of a path: one that makes the same two steps in a half-space, whose mean is known.

What of a path's light scatters twice is a matter of luck. Where a surface is flat and what is below it thick, that of
its twin is the same luck: what the one brings less the other has the same mean without the noise (a control variate).
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.plugins import channels

_LEVEL = 1e-6  # cosine, of directions along the surface


def second(
    β: Any, ratio: Any, channel: Any, sigma_t: Any, sigma_s: Any, eta: Any,
    normal: Any, direction: Any, free: Any, turned: Any,
) -> Any:  # fmt: skip
    """Return what scatters a second time of a path that has entered a half-space, per channel, in expectation.

    `β`, `ratio`, `channel`: the path's (see `channels`); it goes `free` far in `direction`, scatters, and turns to
    `turned`. `normal`: outward. Its mean over paths is `expected` times their light.
    """
    density = dr.exp(-sigma_t * free) * sigma_t
    of_leader = dr.maximum(channels.pick(density, channel), 1e-30)
    albedo = sigma_s / dr.maximum(sigma_t, 1e-30)
    weight = β * albedo * density / of_leader / dr.maximum(dr.sum(ratio * density / of_leader), 1e-30)
    up = dr.dot(turned, normal)
    distance = dr.maximum(-dr.dot(direction, normal), 0) * free / dr.maximum(up, _LEVEL)
    fresnel: Any = mi.fresnel
    reflected = fresnel(-dr.maximum(up, _LEVEL), eta)[0]
    leaves = dr.select(up > 0, dr.exp(-sigma_t * distance) * (1 - reflected), 0)
    return weight * albedo * (1 - leaves)


def expected(sigma_t: Any, sigma_s: Any, kept: Any) -> Any:
    """Return the mean of `second` per light; `kept`: what a half-space keeps after one event (`Lookup.kept`)."""
    return dr.square(sigma_s / dr.maximum(sigma_t, 1e-30)) * kept
