"""A diffusion model's share of a path: from the second event of a walk straight to another point of the surface.

Up to its second event a path is a walk, so that the reduced and the single-scattered light are what they are. What
scatters a second time is the multiple scattering that the model stands for: the path jumps to a point of the surface
around its entry. On a half-space the three terms add up to the model's total. For a model of all scattered light the
jump's kernel (see `nephrite.bssrdf.kernel`) is `R(r) (Rd - a h) / Rd`, with Rd the model's total, a the
single-scattering albedo and `a h` the light that leaves after one event; a model of multiple scattering is its own
kernel. `a^2 (1 - h)`, what reaches a second event, is in the path's throughput already.

Every point on a probe's chord takes part with its share, and one is chosen in proportion to it. Where folds and thin
parts put more surface around a point than a half-space has, the shares would add up to more light than there is:
`balance` sees to it that jumps make no energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import probe
from nephrite.plugins.channels import pick
from nephrite.plugins.kernels import Kernels, Place

MAX_HITS = 256  # a chord, on average
MAX_CHORDS = 32


@dataclass
class Search:
    """A probe on its way along its chords, one ray a turn; part of the state of the integrator's loop.

    `active`: still searching; `chords`, `begun`: how many there are to be, and how many have begun; `left`: length of
    the chord ahead, 0 where one is to begin; `hits`, `total`: points found and the sum of their worths; `share`: per
    worth, what the chosen point brings; `p`, `n`, `shading`: the point, its outward normal, its shading normal.
    """

    active: Any
    chords: Any
    begun: Any
    left: Any
    hits: Any
    total: Any
    share: Any
    p: Any
    n: Any
    shading: Any


def idle() -> Search:
    """Return a search that has not begun."""
    up = mi.Vector3f(0, 0, 1)
    return Search(
        mi.Bool(False), mi.UInt32(1), mi.UInt32(0), mi.Float(0), mi.UInt32(0), mi.Float(0), mi.Spectrum(0),
        mi.Point3f(0), mi.Vector3f(up), mi.Vector3f(up),
    )  # fmt: skip


def arriving(albedo: Any, share: Any) -> Any:
    """Light in a half-space that scatters a second time, per light that has entered: `a^2 (1 - h)`."""
    return dr.maximum(albedo * albedo * (1.0 - share), 1e-12)


def begin(worth: Any, active: Any) -> Search:
    """Start to search the surface; `worth` of the path, relative to its start, is the number of chords, rounded down.

    What one chord finds varies. Paths that get from fold to fold multiply it: with one chord for each jump a
    few become worth hundreds of others, and are seen as fireflies. The more is at stake, the better a jump is sampled.
    Few paths are ever worth 2, and none on a convex body.
    """
    search = idle()
    search.active = mi.Bool(active)
    search.chords = mi.UInt32(dr.clip(worth, 1.0, MAX_CHORDS))
    return search


def take_over(
    media: Any, number: Any, sigma_t: Any, sigma_s: Any, weight: Any, initial: Any, active: Any
) -> tuple[Any, Search]:
    """Begin the jump of a path of a `weight` at its second event; return its throughput, and the search.

    `number`: its material; `initial`: the sum of the throughputs that it began with.
    """
    share = media.lookup(media.single_share, number)
    β = mi.Spectrum(weight / arriving(sigma_s / dr.maximum(sigma_t, 1e-30), share))
    worth = dr.sum(weight) / initial
    return β, begin(worth, active & (worth > 0))


def chord(
    search: Search, kernels: Kernels, place: Place, origin: Any, outward: Any, β: Any, sampler: Any, active: Any
) -> tuple[Search, Any, Any]:  # fmt: skip
    """Begin a chord near `origin`; return the search, and origin and direction of its ray.

    `outward`: normal at `origin`; `β`: throughput, by which the channel that draws the distance is chosen.
    """
    q = _preference(β)
    target, below, channel = sampler.next_1d(active), mi.Float(0.0), mi.UInt32(0)
    for i in range(len(β) - 1):
        below += q[i]
        channel = dr.select(target >= below, i + 1, channel)
    depth, other, share = (pick(values, channel) for values in zip(*kernels.poles(place), strict=True))
    depth = dr.select(sampler.next_1d(active) < share, depth, other)
    u, v = sampler.next_2d(active), sampler.next_2d(active)
    along = probe.axis(mi.Frame3f(outward), v.x)
    radius = probe.distance(depth, u.x)
    start, direction, left = probe.chord(origin, along, radius, kernels.core(place), u.y, v.y)
    search.left = dr.select(active, left, search.left)
    search.begun[active] += 1
    return search, start, direction


def visit(
    search: Search, kernels: Kernels, place: Place, there: Any, balance: Any, si: Any, side: Any, origin: Any,
    outward: Any, β: Any, u: Any, active: Any,
) -> Search:  # fmt: skip
    """Count a point that the probe has hit; it is chosen with probability worth / total so far.

    `place`, `there`: where to look for the kernels at the entry and at the point; None if they are the same.
    `balance`: log2 of what the kernel is divided by. `side`: 1 where the normal of `si` points outward, -1 elsewhere.
    """
    offset, normal = si.p - origin, mi.Vector3f(si.n * side)
    poles = []
    for q, (first, second, share) in zip(_preference(β), kernels.poles(place), strict=True):
        poles += [(first, q * share), (second, q * (1.0 - share))]
    density = probe.density(poles, mi.Frame3f(outward), offset, normal, kernels.core(place))
    value = dr.exp2(kernels.between(place, there, offset, outward, normal) - balance)
    part = dr.select(density > 0, value / dr.maximum(search.chords * density, 1e-30), 0.0)
    worth = dr.select(active, dr.sum(β * part), 0)
    total = search.total + worth
    take = active & (worth > 0) & (u * total <= worth)
    return Search(
        search.active,
        search.chords,
        search.begun,
        search.left,
        dr.select(active, search.hits + 1, search.hits),
        total,
        mi.Spectrum(dr.select(take, part / dr.maximum(worth, 1e-30), search.share)),
        dr.select(take, si.p, search.p),
        dr.select(take, normal, search.n),
        dr.select(take, mi.Vector3f(si.sh_frame.n), search.shading),
    )


def _preference(β: Any) -> Any:
    """Probability of each channel to draw the distance."""
    return β / dr.maximum(dr.sum(β), 1e-30)


def advance(search: Search, si: Any, ray: Any, active: Any) -> Any:
    """Shorten the chord by what the ray has gone; return where it goes on from. The search ends with the last chord."""
    following = si.spawn_ray(ray.d).o
    left = search.left - dr.norm(following - ray.o)
    left = dr.select(si.is_valid() & (search.hits < MAX_HITS * search.chords), dr.maximum(left, 0.0), 0.0)
    search.left = dr.select(active, left, search.left)
    search.active &= ~active | (left > 0) | (search.begun < search.chords)
    return following


def follow(
    search: Search, scene: Any, media: Any, number: Any, sigma_t: Any, sigma_s: Any, g: Any, si: Any, ray: Any,
    side: Any, origin: Any, outward: Any, β: Any, sampler: Any, counts: Any, active: Any,
) -> tuple[Search, Any]:  # fmt: skip
    """Go on from what the probe has met, `si`, and count it where it `counts`; return the search, and where it is.

    Along the rest of most chords nothing lies. A shadow ray tells, and costs less than a turn of the loop.
    """
    place = media.kernels.place(number, sigma_t - sigma_s, sigma_s, g)
    balance = media.balanced(number, origin, si.p, sampler.next_1d(counts))
    search = visit(
        search, media.kernels, place, media.other_end(number, si, counts), balance, si, side, origin, outward, β,
        sampler.next_1d(counts), counts,
    )  # fmt: skip
    following = advance(search, si, ray, active)
    rest = mi.Ray3f(ray)
    rest.o, rest.maxt = following, search.left
    ends = active & (search.left > 0)
    ends &= ~scene.ray_test(rest, ends)
    search.left = dr.select(ends, 0.0, search.left)
    search.active &= ~ends | (search.begun < search.chords)
    return search, following
