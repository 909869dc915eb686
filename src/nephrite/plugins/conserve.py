"""Keeps diffusion models from making energy: jumps from random points of an object, before anything is rendered."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.bssrdf import lobe
from nephrite.plugins import jump
from nephrite.plugins.kernels import Place
from nephrite.plugins.media import JUMP, Media, surface_points

_POINTS = 1 << 15
_JUMPS = 8  # from each point


def fingerprint(media: Media) -> tuple[Any, ...]:
    """Return what the crowding depends on, as far as it can be told at once: forms, sizes, coefficients, models."""
    found: list[Any] = [mi.variant(), media.diffusion, *media.models]
    for entry in media.entries:
        found += [entry.eta, entry.g]
        for shape in entry.shapes:
            si = surface_points(shape, mi.Point2f(0.3, 0.6), mi.Float(0.5))
            values = [*entry.coefficients(si, True), shape.surface_area(), si.p]
            found += [float(x) for value in values for x in np.ravel(np.array(value))]
            found += [float(x) for corner in (shape.bbox().min, shape.bbox().max) for x in corner]
    return tuple(found)


def conserve(media: Media, scene: Any) -> None:
    """Set `media.crowding` for the objects whose light jumps."""
    for number, model in enumerate(media.models, start=1):
        entry = media.entries[number - 1]
        if model != JUMP or entry.least_reach > 0:  # instances are one shape in many places
            continue
        bbox = mi.ScalarBoundingBox3f()
        points, brought = [], []
        for shape in entry.shapes:
            bbox.expand(shape.bbox())
            si, found = _jump(media, number, scene, shape)
            points.append(np.array(si.p).T[::_JUMPS])
            means = [np.array(channel).reshape(-1, _JUMPS).mean(axis=1) for channel in found]
            brought.append(np.stack(means, axis=-1))
        media.crowding.estimate(number, bbox, np.concatenate(points), np.concatenate(brought))


def _jump(media: Media, number: int, scene: Any, shape: Any) -> tuple[Any, Any]:
    """Return random points of a shape, each repeated, and what a jump from it brings of the light that arrives."""
    entry = media.entries[number - 1]
    count = _POINTS * _JUMPS
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, count)
    first = dr.arange(mi.UInt32, count) // _JUMPS * _JUMPS
    u2 = dr.gather(mi.Point2f, sampler.next_2d(), first)
    u1 = dr.gather(mi.Float, sampler.next_1d(), first)
    si = surface_points(shape, u2, u1)
    sigma_a, sigma_s = entry.coefficients(si, True)
    place = media.kernels.place(mi.UInt32(number), sigma_a, sigma_s, entry.g)
    search = _land(scene, sampler, media, mi.UInt32(number), place, si, shape)
    albedo = sigma_s / dr.maximum(sigma_a + sigma_s, 1e-30)
    found = search.share * search.total / jump.arriving(albedo, entry.single_share)
    if media.directional is not None:
        found *= _by_direction(media, number, sampler, sigma_a, sigma_s, si, search)
    return si, found


@dr.syntax
def _land(scene: Any, sampler: Any, media: Media, number: Any, place: Place, at: Any, shape: Any) -> Any:
    """Jump once from every point of `at`; return the searches at their ends."""
    identity = dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))
    outward, β = mi.Vector3f(at.n), mi.Spectrum(1.0)
    search, start, direction = jump.begin(media.kernels, place, at.p, outward, β, sampler, mi.Bool(True))
    ray = mi.Ray3f(start, direction)
    active = mi.Bool(search.active)
    while active:
        ray.maxt = search.left
        si = scene.ray_intersect(ray, mi.RayFlags.All, False, active)
        counts = active & si.is_valid() & (dr.reinterpret_array(mi.UInt32, si.shape) == identity)
        search = jump.visit(
            search, media.kernels, place, media.other_end(number, si, counts),
            media.crowded(number, at.p, si.p), si, at.p, outward, β, sampler.next_1d(active), counts,
        )  # fmt: skip
        ray.o = jump.advance(search, si, ray, active)
        active = search.active & si.is_valid()
        search.active = mi.Bool(active)
    return search


def _by_direction(
    media: Media, number: int, sampler: Any, sigma_a: Any, sigma_s: Any, at: Any, search: Any
) -> Any:
    """Return what a directional model makes of the jumps, for light that comes and goes in all directions."""
    eta = media.entries[number - 1].eta
    constants = lobe.exit_lobe(eta)
    fresnel: Any = mi.fresnel
    directions, share = [], mi.Float(1.0)
    for normal in (mi.Vector3f(at.n), search.n):
        local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        through = 1.0 - fresnel(local.z, eta)[0]
        share *= through / constants.normalization
        directions.append(mi.Frame3f(normal).to_world(local))
    w_o, w_i = directions
    return share * media.directional.ratio(
        mi.UInt32(number), sigma_a, sigma_s, at.p, mi.Vector3f(at.n), w_o, search.p, search.n, w_i
    )
