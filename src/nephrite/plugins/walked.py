"""What walks bring of the light that jumps stand for: the truth about an object under an even sky.

Light that falls on points of a shape from all sides enters and walks. Of what scatters a second time, a share leaves
the object in the end. Reflections at its surface are exact, but for roughness; other objects end a walk.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.physics import phase
from nephrite.plugins import channels, interface
from nephrite.plugins.shapes import Start

_ROULETTE_SHARE = 0.05  # of the light, below which roulette begins
_LONGEST = 100_000


@dr.syntax
def walk(scene: Any, sampler: Any, entry: Any, start: Start) -> tuple[Any, Any]:
    """Walk once from each point; return the light that left, and that had scattered twice, per channel.

    `entry`: the `media.Entry` of the shape.
    """
    at, identity = start.si, dr.reinterpret_array(mi.UInt32, mi.ShapePtr(start.shape))
    absorbed, sigma_s = entry.coefficients(at, True)
    sigma_t = absorbed + sigma_s
    falling = -mi.Frame3f(at.n).to_world(mi.warp.square_to_cosine_hemisphere(sampler.next_2d()))
    inward = interface.cross(at, falling, mi.Float(entry.eta))
    channel, β, ratio = channels.lead(mi.Spectrum(1 - inward.reflectance), sampler.next_1d())
    leading = channels.pick(sigma_t, channel)
    ray = at.spawn_ray(inward.refracted)
    events, steps = mi.UInt32(0), mi.UInt32(0)
    left, twice = mi.Spectrum(0), mi.Spectrum(0)
    active = dr.max(sigma_s) > 0
    while active:
        ray.maxt = dr.minimum(-dr.log(1 - sampler.next_1d()) / leading, 1e30)
        hit = scene.ray_intersect_preliminary(ray, coherent=False, active=active)
        stops = hit.is_valid()
        distance = dr.select(stops, hit.t, ray.maxt)
        along = dr.exp(-sigma_t * distance)
        density = along * dr.select(stops, 1, sigma_t)
        of_leader = dr.maximum(channels.pick(density, channel), 1e-30)
        β *= along * dr.select(stops, 1, sigma_s) / of_leader
        ratio *= density / of_leader
        weight = β / dr.sum(ratio)
        u = sampler.next_2d()
        if stops:
            si = hit.compute_surface_interaction(ray, mi.RayFlags.All, active & stops)
            x = interface.cross(si, ray.d, mi.Float(1 / entry.eta))
            own = dr.reinterpret_array(mi.UInt32, si.shape) == identity
            leaves = u.x >= x.reflectance
            left = dr.select(own & leaves & (events > 1), weight, left)
            ray = si.spawn_ray(x.reflected)
            active &= own & ~leaves
        else:
            events += 1
            twice = dr.select(events == 2, weight, twice)
            ray.o += ray.d * distance
            ray.d = mi.Frame3f(ray.d).to_world(mi.Vector3f(*phase.sample(u.x, u.y, mi.Float(entry.g))))
        steps += 1
        survival = dr.minimum(dr.max(weight) / _ROULETTE_SHARE, 1)
        active &= (sampler.next_1d() < survival) & (steps < _LONGEST)
        β /= survival
    return left, twice
