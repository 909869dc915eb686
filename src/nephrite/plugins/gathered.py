"""Light that arrives at points of translucent surfaces from outside: its mean under their exit lobe.

Connections to lights bring what comes straight from there; paths, whose first segment sees no lights, bring what
surfaces send.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.plugins import camera, path, sequence
from nephrite.plugins.exits import unblocked

_STEPS = sequence.steps(2)


def direct(scene: Any, at: Any, sensitivity: Any, count: int, seed: int) -> list[Any]:
    """Return what `count` connections to lights bring to every point of `at`: see `_arrived`.

    `sensitivity(i, cosine)`: how much light at that angle counts at point i, a density over the projected solid angle.
    Each point follows the same sequence of low discrepancy, shifted at random.
    """
    width = dr.width(at.p)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, width)
    shift = sampler.next_2d()
    lane, each = dr.arange(mi.UInt32, width * count), dr.opaque(mi.UInt32, count)
    node = lane // each
    turn = mi.Float(lane - node * each)
    moved = mi.Point2f(*(dr.gather(mi.Float, a, node) + turn * b for a, b in zip(shift, _STEPS, strict=True)))
    here = dr.gather(type(at), at, node)
    ds, light = scene.sample_emitter_direction(here, moved - dr.floor(moved), False, mi.Bool(True))
    cosine = dr.maximum(dr.dot(ds.d, here.n), 0)
    value = unblocked(scene, here, ds, sensitivity(node, cosine) * cosine * light, cosine > 0)
    return _arrived(value, ds.d, here.n, node, width, count)


def indirect(
    s: Any, scene: Any, media: Any, at: Any, sensitivity: Any, count: int, seed: int
) -> list[Any]:  # fmt: skip
    """Return what `count` paths from every point of `at` find that no connection does; `s` hides the emitters."""
    width = dr.width(at.p)
    node = dr.arange(mi.UInt32, width * count) // dr.opaque(mi.UInt32, count)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, width * count)
    here = dr.gather(type(at), at, node)
    local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
    ray = here.spawn_ray(mi.Frame3f(here.n).to_world(local))
    found = path.trace(s, scene, media, sampler, camera.OneRay(ray, True)).L
    found = dr.select(dr.all(dr.isfinite(found)), found, 0)
    return _arrived(dr.pi * sensitivity(node, local.z) * found, ray.d, here.n, node, width, count)


def _arrived(values: Any, direction: Any, normal: Any, node: Any, width: int, count: int) -> list[Any]:
    """Return the means of `values`, and of their products with the tangential directions."""
    tangential = direction - normal * dr.dot(direction, normal)
    share = dr.opaque(mi.Float, 1 / count)
    sums = []
    for factor in (mi.Float(1), *tangential):
        total = dr.zeros(mi.Spectrum, width)
        dr.scatter_add(total, values * factor * share, node)
        sums.append(total)
    dr.eval(sums)
    return sums
