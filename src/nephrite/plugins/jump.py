"""The dipole's share of a path: from the second event of a walk straight to another point of the surface.

Up to its second event a path is a walk, so that the reduced and the single-scattered light are what they are. What
scatters a second time is the multiple scattering that the dipole stands for: the path jumps to a point of the surface
around its entry, drawn by probe rays. On a half-space the three terms add up to the dipole's published reflectance:
the jump's profile is `R(r) (Rd - a h) / (Rd a^2 (1 - h))`, with Rd the dipole's albedo, a the single-scattering albedo,
and `a h`, `a^2 (1 - h)` the light that leaves after one event and that reaches a second one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import probe
from nephrite.plugins.channels import pick
from nephrite.profiles import StandardDipole


@dataclass
class Landing:
    """Where a jump landed: `si`, the outward `normal` there, and the `weight` per channel (0: nowhere)."""

    si: Any
    normal: Any
    weight: Any


def conditional_scale(profile: Any, albedo: Any, share: Any) -> Any:
    """Factor on the profile that makes it the response to light that has scattered twice; >= 0."""
    total = dr.maximum(profile.albedo(), 1e-12)
    left = dr.maximum(total - albedo * share, 0.0)
    return left / (total * dr.maximum(albedo * albedo * (1.0 - share), 1e-12))


@dr.syntax
def jump(
    scene: Any, sampler: Any, profile: StandardDipole, origin: Any, outward: Any, side: Any, shape: Any, β: Any,
    longest: Any, active: Any,
) -> Landing:  # fmt: skip
    """Probe the surface of `shape` around `origin`; weights are R over the density, for all channels.

    `outward`: normal at `origin`; `side`: +1 if the shape's normals point outward, -1 if inward; `β`: what the
    channels are drawn by; `longest`: bound of r_max.
    """
    frame = mi.Frame3f(outward)
    r_max = probe.truncation_radius(profile, longest)
    total = dr.maximum(dr.sum(β), 1e-30)
    q = β / total
    target, below, channel = sampler.next_1d(active), mi.Float(0.0), mi.UInt32(0)
    for i in range(len(β) - 1):
        below += q[i]
        channel = dr.select(target >= below, i + 1, channel)
    limit = pick(r_max, channel)
    scaled = sampler.next_1d(active)
    u2 = sampler.next_2d(active)
    radius = pick(profile.sample(scaled * profile.cdf(r_max), u2.x), channel)
    axes = probe.frame_axis(frame, sampler.next_1d(active))
    start, direction, length = probe.chord(origin, axes, radius, limit, u2.y)
    searching = mi.Bool(active & (radius < limit))
    ray = mi.Ray3f(start, direction)
    left = mi.Float(length)
    hits = mi.UInt32(0)
    chosen = dr.zeros(mi.SurfaceInteraction3f)
    while searching:
        ray.maxt = left
        si = scene.ray_intersect(ray, mi.RayFlags.All, False, searching)
        searching &= si.is_valid()
        counts = searching & (dr.reinterpret_array(mi.UInt32, si.shape) == shape)
        hits[counts] = hits + 1
        take = counts & (sampler.next_1d(searching) * mi.Float(hits) < 1.0)
        chosen[take] = si
        following = si.spawn_ray(direction)
        left[searching] = left - dr.norm(following.o - ray.o)
        ray.o[searching] = following.o
        searching &= (left > 0) & (hits < 1000)
    offset = chosen.p - origin
    density = dr.sum(probe.density(profile, frame, offset, chosen.n, r_max, q))
    distance = dr.norm(offset)
    found = active & (hits > 0) & (density > 0)
    value = profile.eval(distance)
    weight = dr.select(found & (distance < longest), value * mi.Float(hits) / dr.maximum(density, 1e-30), 0.0)
    normal = dr.mulsign(chosen.n, side)
    shading = mi.Vector3f(dr.mulsign(chosen.sh_frame.n, dr.dot(chosen.sh_frame.n, normal)))
    return Landing(chosen, shading, weight)
