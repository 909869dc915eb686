"""How much of a picture each node of precomputed transport makes up."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from nephrite.plugins.lookup import Lookup

_RAYS = 1 << 18
_AROUND = 16  # nodes


def seen(scene: Any, sensor: Any, lookup: Lookup, seed: int) -> NDArray:
    """Return how many of `_RAYS` rays of the sensor end near each node, as a mean over `_AROUND` nodes.

    A node alone would have the more the larger its part of the surface is, and that is no reason to prefer it.
    """
    sampler: Any = mi.load_dict({"type": "independent"})
    sampler.seed(seed, _RAYS)
    ray, _ = sensor.sample_ray(sensor.shutter_open(), sampler.next_1d(), sampler.next_2d(), sampler.next_2d())
    si = scene.ray_intersect(ray, mi.RayFlags.Minimal, coherent=False)
    dr.eval(ray.d, si)
    hit: Any = dr.compress(si.is_valid() & lookup.known(si.shape))
    if not len(hit):
        return np.zeros(len(lookup.points))
    si, toward = dr.gather(type(si), si, hit), -dr.gather(mi.Vector3f, ray.d, hit)
    outward = dr.mulsign(mi.Vector3f(si.n), dr.dot(si.n, toward))
    everywhere = dr.full(mi.Bool, True, len(hit))
    node = lookup.nearby.nearest(lookup.number(si.shape, everywhere), si.p, outward, everywhere)
    count = np.bincount(np.array(node), minlength=len(lookup.points))
    parts = [lookup.own(number) for number in range(len(lookup.firsts) - 1)]
    return np.concatenate([_mean(lookup.points[own], count[own]) for own in parts])


def _mean(points: NDArray, values: NDArray) -> NDArray:
    _, near = KDTree(points).query(points, k=min(_AROUND, len(points)), workers=-1)
    return values[near.reshape(len(points), -1)].mean(axis=1)
