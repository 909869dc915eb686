"""Keeps the dipole from making energy: how much light its jumps bring, on average over an object's surface."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.plugins import jump
from nephrite.plugins.media import JUMP, Media, surface_points
from nephrite.profiles import StandardDipole

_POINTS = 512
_JUMPS = 8  # of each point, in each of two independent halves


def conserve(media: Media, scene: Any) -> None:
    """Set `media.kept`: the factor, at most 1, that keeps each object's jumps from making energy.

    The jump's kernel is symmetric, and one factor for an object keeps it so. What leaves for the light that has
    scattered twice is estimated at random points; its root mean square over the surface, at which folds weigh more than
    in the mean, and in the brightest channel, is brought down to 1 where it is above.
    """
    kept = []
    for entry, model in zip(media.entries, media.models, strict=True):
        kept.append(1.0 / max(1.0, _mean_return(entry, scene)) if model == JUMP else 1.0)
    media.set_kept(kept)


def _mean_return(entry: Any, scene: Any) -> float:
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, 2 * _POINTS * _JUMPS)
    areas = [float(dr.max(shape.surface_area())[0]) for shape in entry.shapes]
    total = [0.0] * dr.size_v(mi.Spectrum)
    for shape, area in zip(entry.shapes, areas, strict=True):
        of_point = dr.arange(mi.UInt32, 2 * _POINTS * _JUMPS) // (2 * _JUMPS)
        first = of_point * (2 * _JUMPS)
        u2, u1 = (
            dr.gather(mi.Point2f, sampler.next_2d(), first),
            dr.gather(mi.Float, sampler.next_1d(), first),
        )
        si = surface_points(shape, u2, u1)
        sigma_a, sigma_s = entry.coefficients(si, True)
        profile = StandardDipole(sigma_a, sigma_s * (1 - entry.g), entry.boundary)
        share = sigma_s / dr.maximum(sigma_a + sigma_s, 1e-30)
        β = mi.Spectrum(jump.conditional_scale(profile, share, entry.single_share))
        weight = β * _land(scene, sampler, profile, si, shape, β)
        for i, channel in enumerate(weight):
            half = dr.block_sum(channel, _JUMPS) / _JUMPS
            pair = 2 * dr.arange(mi.UInt32, _POINTS)
            # the product of two independent estimates: their square would count the noise as light
            square = dr.gather(mi.Float, half, pair) * dr.gather(mi.Float, half, pair + 1)
            total[i] += dr.mean(square)[0] * (area / sum(areas))
    return math.sqrt(max(*total, 0.0))


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
