"""The dipole's share of a path: from the second event of a walk straight to another point of the surface.

Up to its second event a path is a walk, so that the reduced and the single-scattered light are what they are. What
scatters a second time is the multiple scattering that the dipole stands for: the path jumps to a point of the surface
around its entry. On a half-space the three terms add up to the dipole's published reflectance: the jump's profile is
`R(r) (Rd - a h) / (Rd a^2 (1 - h))`, with Rd the dipole's albedo, a the single-scattering albedo, and `a h`,
`a^2 (1 - h)` the light that leaves after one event and that reaches a second one.

Every point on a probe's chord takes part with its share, and one is chosen in proportion to it. Where folds and thin
parts put more surface around a point than a half-space has, the shares add up to more light than there is:
`Media.conserve` scales an object's jumps down so that, over its surface, they make no energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import probe
from nephrite.plugins.channels import pick
from nephrite.profiles import StandardDipole

MAX_HITS = 256


@dataclass
class Search:
    """A probe on its way along its chord, one ray a turn; part of the state of the integrator's loop.

    `active`: still searching; `left`: length of the chord ahead; `β`: throughput before the jump; `r_max`, `within`:
    truncation radius of each channel's profile, and the share of the profile inside it; `hits`, `total`: points found
    and the sum of their worths; `share`: per worth, what the chosen point brings; `p`, `n`, `shading`: the point, its
    normals.
    """

    active: Any
    left: Any
    β: Any
    r_max: Any
    within: Any
    hits: Any
    total: Any
    share: Any
    p: Any
    n: Any
    shading: Any


def idle() -> Search:
    """Return a search that has not begun."""
    zero, up = mi.Point3f(0), mi.Vector3f(0, 0, 1)
    return Search(
        mi.Bool(False), mi.Float(0), mi.Spectrum(0), mi.Spectrum(0), mi.Spectrum(0), mi.UInt32(0), mi.Float(0),
        mi.Spectrum(0), zero, mi.Vector3f(up), mi.Vector3f(up),
    )  # fmt: skip


def conditional_scale(profile: Any, albedo: Any, share: Any) -> Any:
    """Factor on the profile that makes it the response to light that has scattered twice; >= 0."""
    total = dr.maximum(profile.albedo(), 1e-12)
    left = dr.maximum(total - albedo * share, 0.0)
    return left / (total * dr.maximum(albedo * albedo * (1.0 - share), 1e-12))


def begin(
    profile: StandardDipole, origin: Any, outward: Any, β: Any, longest: Any, sampler: Any, active: Any
) -> tuple[Search, Any, Any]:
    """Start to search the surface around `origin`; return the search, and origin and direction of its ray.

    `outward`: normal at `origin`; `β`: throughput, by which the channel that draws the radius is chosen; `longest`:
    bound of r_max.
    """
    q = β / dr.maximum(dr.sum(β), 1e-30)
    target, below, channel = sampler.next_1d(active), mi.Float(0.0), mi.UInt32(0)
    for i in range(len(β) - 1):
        below += q[i]
        channel = dr.select(target >= below, i + 1, channel)
    r_max = probe.truncation_radius(profile, longest)
    within = profile.cdf(r_max)
    u, v = sampler.next_2d(active), sampler.next_1d(active)
    leading = profile.map(lambda value: pick(value, channel))
    limit = pick(r_max, channel)
    radius = leading.sample(u.x, v, limit)
    half = probe.half_chord(radius, limit, leading.z_virtual)
    axes = probe.axis(mi.Frame3f(outward), sampler.next_1d(active))
    start, direction, left = probe.chord(origin, axes, radius, half, u.y)
    search = idle()
    search.active, search.left = mi.Bool(active & (radius < limit)), left
    search.β, search.r_max, search.within = mi.Spectrum(β), mi.Spectrum(r_max), mi.Spectrum(within)
    return search, start, direction


def visit(
    search: Search, profile: StandardDipole, si: Any, origin: Any, outward: Any, u: Any, active: Any
) -> Search:
    """Count a point that the probe has hit; it is chosen with probability worth / total so far."""
    offset = si.p - origin
    q = search.β / dr.maximum(dr.sum(search.β), 1e-30)
    density = dr.sum(q * probe.density(profile, mi.Frame3f(outward), offset, si.n, search.r_max))
    part = dr.select(
        density > 0, profile.eval(dr.norm(offset)) / dr.maximum(search.within * density, 1e-30), 0
    )
    worth = dr.select(active, dr.sum(search.β * part), 0)
    total = search.total + worth
    take = active & (worth > 0) & (u * total <= worth)
    return Search(
        search.active,
        search.left,
        search.β,
        search.r_max,
        search.within,
        dr.select(active, search.hits + 1, search.hits),
        total,
        mi.Spectrum(dr.select(take, part / dr.maximum(worth, 1e-30), search.share)),
        dr.select(take, si.p, search.p),
        dr.select(take, mi.Vector3f(si.n), search.n),
        dr.select(take, mi.Vector3f(si.sh_frame.n), search.shading),
    )


def advance(search: Search, si: Any, ray: Any, active: Any) -> Any:
    """Shorten the chord by what the ray has gone; return where it goes on from. The search ends with the chord."""
    following = si.spawn_ray(ray.d).o
    left = search.left - dr.norm(following - ray.o)
    search.left = dr.select(active, left, search.left)
    search.active &= ~active | ((left > 0) & (search.hits < MAX_HITS))
    return following
