"""The first two events of a walk at once, where a jump is to follow and no surface is in the way.

A diffusion model takes over at a walk's second event. In most media that is next to where the path has entered: all
that a turn of the loop would look for on the way to it is whether it meets a surface, and that is told by a shadow
ray, in the turn in which the path enters. Where a surface is near, the walk goes on as walks do, by the distance that
has been drawn already: what is found, and how often, is the same.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.plugins import channels, glints, guide
from nephrite.plugins.media import Media

_THIN = 3.0  # mean free paths to the far side: in thinner parts the first turn is guided


def hurry(
    scene: Any, media: Media, lamps: list[tuple[Any, Any]], number: Any, ray: Any, β: Any, ratio: Any, channel: Any,
    sigma_t: Any, sigma_s: Any, g: Any, u: list[Any], active: Any,
) -> tuple[Any, Any, Any, Any, Any, Any]:  # fmt: skip
    """Take a path that has just entered material `number` by `ray` to its second event, or as far as nothing is near.

    `u`: uniform numbers, for the first free path, two for the turn, and for the second free path. Returns `β` and
    `ratio` (see `channels`); where it goes on; how far it is from there to its next event, if it has not come to its
    second; its events, and its way, so far.
    """
    leading = channels.pick(sigma_t, channel)
    active = active & (leading > 0)
    first, second = (dr.minimum(-dr.log(1 - x) / dr.maximum(leading, 1e-30), 1e30) for x in (u[0], u[3]))
    # a walk that is as far away has left by a hole; and lamps behind thin parts are for walks to look for
    clear = first
    if lamps:
        eta = media.lookup(media.eta, number)
        clear = dr.maximum(clear, glints.horizon(lamps, ray, β / dr.sum(ratio), sigma_t, eta))
        clear = dr.maximum(clear, _THIN / leading)
    one = active & (first <= media.lookup(media.reach, number)) & _open(scene, ray, clear, active)
    turned, _ = guide.turn([], ray.o, ray.d, g, u[1:3], None, one)
    following = mi.Ray3f(ray)
    following.o, following.d = ray(first), turned
    two = one & _open(scene, following, second, one)
    β, ratio = _scattered(β, ratio, channel, sigma_t, sigma_s, first, one)
    β, ratio = _scattered(β, ratio, channel, sigma_t, sigma_s, second, two)
    planned = dr.select(active & ~two, dr.select(one, second, first), 0)
    events = dr.select(one, dr.select(two, mi.UInt32(2), mi.UInt32(1)), mi.UInt32(0))
    return β, ratio, dr.select(one, following, ray), planned, events, dr.select(one, first, 0)


def _open(scene: Any, ray: Any, distance: Any, active: Any) -> Any:
    """Return whether nothing is in the ray's way for the distance."""
    along = mi.Ray3f(ray)
    along.maxt = distance
    return ~scene.ray_test(along, active)


def _scattered(
    β: Any, ratio: Any, channel: Any, sigma_t: Any, sigma_s: Any, distance: Any, active: Any
) -> tuple[Any, Any]:
    """Return throughput and ratios after an event at the distance."""
    along = dr.exp(-sigma_t * distance)
    of_leader = dr.maximum(channels.pick(along * sigma_t, channel), 1e-30)
    return (
        dr.select(active, β * along * sigma_s / of_leader, β),
        dr.select(active, ratio * along * sigma_t / of_leader, ratio),
    )
