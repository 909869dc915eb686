"""What jumps bring of the light that they stand for, from random points of a shape."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import lobe
from nephrite.plugins import jump
from nephrite.plugins.kernels import Place
from nephrite.plugins.media import Media
from nephrite.plugins.shapes import Start


def jump_once(media: Media, number: int, scene: Any, sampler: Any, start: Start) -> Any:
    """Jump once from each point; return what that brings of the light that arrives, per channel."""
    entry, si = media.entries[number - 1], start.si
    sigma_a, sigma_s = entry.coefficients(si, True)
    place = media.kernels.place(mi.UInt32(number), sigma_a, sigma_s, entry.g)
    search = _land(scene, sampler, media, mi.UInt32(number), place, start)
    albedo = sigma_s / dr.maximum(sigma_a + sigma_s, 1e-30)
    found = search.share * search.total / jump.arriving(albedo, entry.single_share)
    if media.directional is not None:
        found *= _by_direction(media, number, sampler, sigma_a, sigma_s, si, search)
    return found


@dr.syntax
def _land(scene: Any, sampler: Any, media: Media, number: Any, place: Place, start: Start) -> Any:
    """Return the searches at their ends."""
    at, identity = start.si, dr.reinterpret_array(mi.UInt32, mi.ShapePtr(start.shape))
    outward, β = mi.Vector3f(at.n), mi.Spectrum(1.0)
    search = jump.begin(1.0, True)
    ray = mi.Ray3f(at.p, outward)
    active = mi.Bool(search.active)
    while active:
        starts = search.left == 0
        if starts:
            search, ray.o, ray.d = jump.chord(search, media.kernels, place, at.p, outward, β, sampler, starts)
        ray.maxt = search.left
        si = scene.ray_intersect(ray, mi.RayFlags.All, False, active)
        si.n = media.winding.outward(si)
        counts = active & si.is_valid() & (dr.reinterpret_array(mi.UInt32, si.shape) == identity)
        search = jump.visit(
            search, media.kernels, place, media.other_end(number, si, counts),
            media.balanced(number, at.p, si.p, sampler.next_1d(active)), si, start.side, at.p, outward, β,
            sampler.next_1d(active), counts,
        )  # fmt: skip
        ray.o = jump.advance(search, si, ray, active)
        active = mi.Bool(search.active)
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
