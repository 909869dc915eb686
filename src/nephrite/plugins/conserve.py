"""Keeps the dipole from making energy: how much light its jumps bring, on average over an object's surface."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.plugins import jump
from nephrite.plugins.media import JUMP, Media, surface_points
from nephrite.profiles import StandardDipole

_POINTS = 512
_GROUPS = 4
_MOST = 0.97  # of the light there is: what is left covers the estimate's noise
_JUMPS = 8  # of each point, in each of the independent groups


def conserve(media: Media, scene: Any) -> None:
    """Set `media.kept`: the factor, at most 1, that keeps each object's jumps from making energy.

    The jump's kernel is symmetric, and one factor for an object keeps it so. What leaves for the light that has
    scattered twice is estimated at random points; its fourth-power mean over the surface, in which folds and thin parts
    weigh most, and in the brightest channel, is brought down to .97 where it is above.
    """
    kept = []
    for entry, model in zip(media.entries, media.models, strict=True):
        kept.append(min(1.0, _MOST / max(_mean_return(entry, scene), 1e-9)) if model == JUMP else 1.0)
    media.set_kept(kept)


def _mean_return(entry: Any, scene: Any) -> float:
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, _POINTS * _GROUPS * _JUMPS)
    areas = [float(dr.max(shape.surface_area())[0]) for shape in entry.shapes]
    total = [0.0] * dr.size_v(mi.Spectrum)
    for shape, area in zip(entry.shapes, areas, strict=True):
        of_point = dr.arange(mi.UInt32, _POINTS * _GROUPS * _JUMPS) // (_GROUPS * _JUMPS)
        first = of_point * (_GROUPS * _JUMPS)
        u2 = dr.gather(mi.Point2f, sampler.next_2d(), first)
        u1 = dr.gather(mi.Float, sampler.next_1d(), first)
        si = surface_points(shape, u2, u1)
        sigma_a, sigma_s = entry.coefficients(si, True)
        profile = StandardDipole(sigma_a, sigma_s * (1 - entry.g), entry.boundary)
        share = sigma_s / dr.maximum(sigma_a + sigma_s, 1e-30)
        β = mi.Spectrum(jump.conditional_scale(profile, share, entry.single_share))
        weight = β * _land(scene, sampler, profile, si, shape, β)
        for i, channel in enumerate(weight):
            means = dr.block_sum(channel, _JUMPS) / _JUMPS
            index = _GROUPS * dr.arange(mi.UInt32, _POINTS)
            # the product of independent estimates: a power of one would count the noise as light
            power = mi.Float(1.0)
            for group in range(_GROUPS):
                power *= dr.gather(mi.Float, means, index + group)
            total[i] += dr.mean(power)[0] * (area / sum(areas))
    return max(*total, 0.0) ** (1.0 / _GROUPS)


@dr.syntax
def _land(scene: Any, sampler: Any, profile: StandardDipole, at: Any, shape: Any, β: Any) -> Any:
    """Jump once from every point of `at`; return the weights."""
    identity = dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))
    longest = dr.norm(scene.bbox().extents())
    outward = mi.Vector3f(at.n)
    search, start, direction = jump.begin(profile, at.p, outward, β, longest, sampler, mi.Bool(True))
    ray = mi.Ray3f(start, direction)
    active = mi.Bool(search.active)
    while active:
        ray.maxt = search.left
        si = scene.ray_intersect(ray, mi.RayFlags.All, False, active)
        counts = active & si.is_valid() & (dr.reinterpret_array(mi.UInt32, si.shape) == identity)
        search = jump.visit(search, profile, si, at.p, outward, sampler.next_1d(active), counts)
        ray.o = jump.advance(search, si, ray, active)
        active = search.active & si.is_valid()
        search.active = mi.Bool(active)
    return search.share * search.total
