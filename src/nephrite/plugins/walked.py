"""Walks from points of a surface to where they leave it: what the volume carries from there to here.

Transport keeps where they go; diffusion models learn from them how much there is (see `balance`).

Light that falls from all sides enters, walks and leaves. By reciprocity the share that goes from x to y is the share
of the light entering at y that is seen at x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import lobe
from nephrite.physics import phase
from nephrite.plugins import channels, interface

_ROULETTE_SHARE = 0.05  # of the light, below which roulette begins
_LONGEST = 100_000


@dataclass
class Ends:
    """Where walks left a shape: points and outward normals.

    `weight`: per channel and per light that has entered, 0 for walks of fewer than two events; `twice`: the light that
    scattered a second time; `lost`: what other objects in the shape took; `out`, `back`: tangential directions outside
    at the end and at the start, times what makes their products with other directions the linear part of the lobe's
    kernel (see `nephrite.bssrdf.lobe`).
    """

    p: Any
    n: Any
    weight: Any
    twice: Any
    lost: Any
    out: Any
    back: Any


@dr.syntax
def walk(scene: Any, sampler: Any, entry: Any, at: Any, shape: Any) -> Ends:
    """Walk once from every point of `at`, whose normals point outward; `entry`: the `media.Entry` of the shape."""
    identity = dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))
    eta = dr.opaque(mi.Float, entry.eta)
    g = dr.opaque(mi.Float, entry.g)
    reach = dr.opaque(mi.Float, entry.reach())
    absorbed, sigma_s = entry.coefficients(at, True)
    sigma_t = absorbed + sigma_s
    falling = -mi.Frame3f(at.n).to_world(mi.warp.square_to_cosine_hemisphere(sampler.next_2d()))
    inward = interface.cross(at, falling, eta)
    normalization = dr.opaque(mi.Float, lobe.exit_lobe(entry.eta).normalization)
    entered = (1 - inward.reflectance) / normalization
    channel, β, ratio = channels.lead(mi.Spectrum(entered), sigma_t, sampler.next_1d())
    leading = channels.pick(sigma_t, channel)
    ray = at.spawn_ray(inward.refracted)
    events, steps = mi.UInt32(0), mi.UInt32(0)
    p, n, out = mi.Point3f(at.p), mi.Vector3f(at.n), mi.Vector3f(at.n)
    left, twice, lost = mi.Spectrum(0), mi.Spectrum(0), mi.Spectrum(0)
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
            x = interface.cross(si, ray.d, dr.rcp(eta))
            own = dr.reinterpret_array(mi.UInt32, si.shape) == identity
            leaves = u.x >= x.reflectance
            gone = own & leaves & (events > 1)
            p, n, out = (
                dr.select(gone, si.p, p),
                dr.select(gone, -x.normal, n),
                dr.select(gone, x.refracted, out),
            )
            left = dr.select(gone, weight, left)
            lost = dr.select(own, lost, weight)
            ray = si.spawn_ray(x.reflected)
            active &= own & ~leaves
        else:
            events += 1
            twice = dr.select(events == 2, weight, twice)
            ray.o += ray.d * distance
            ray.d = mi.Frame3f(ray.d).to_world(mi.Vector3f(*phase.sample(u.x, u.y, g)))
        active &= dr.squared_norm(ray.o - at.p) < dr.square(reach)  # or it has found a hole in the shape
        steps += 1
        survival = dr.minimum(dr.max(weight) / _ROULETTE_SHARE, 1)
        active &= (sampler.next_1d() < survival) & (steps < _LONGEST)
        β /= survival
    memory = lobe.memory(mi.Float(events), g)[0] * (2 / lobe.exit_lobe(entry.eta).m2)
    return Ends(p, n, left, twice, lost, memory * _tangential(out, n), memory * _tangential(-falling, at.n))


def _tangential(v: Any, n: Any) -> Any:
    return v - n * dr.dot(v, n)
