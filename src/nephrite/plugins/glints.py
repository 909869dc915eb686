"""Glints: lamps that a smooth surface mirrors, or an object lets through, looked at from there.

Fresnel reflection sends few paths to a lamp, and so does a thin rim to a lamp behind it; each brings all of the lamp's
light: noise that covers all else.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.plugins import interface
from nephrite.plugins.media import Media

_LEAST = 1e-3  # throughput: where less gets through, lamps are left to chance
_MOST = 4  # lamps that are looked for


def lamps(scene: Any) -> list[tuple[Any, Any]]:
    """Return centres and radii of spheres around the lamps that have a surface; none if there are too many."""
    shapes = [light.get_shape() for light in scene.emitters()]
    found = [shape.bbox().bounding_sphere() for shape in shapes if shape is not None]
    if len(found) > _MOST:
        return []
    spheres = [(mi.Point3f(sphere.center), mi.Float(sphere.radius)) for sphere in found]
    dr.make_opaque(spheres)  # lamps that move compile nothing anew
    return spheres


def may_meet(spheres: list[tuple[Any, Any]], p: Any, direction: Any) -> Any:
    """Return whether what leaves `p` in a direction meets one of the spheres of `lamps`."""
    meets = mi.Bool(False)
    for centre, radius in spheres:
        offset = centre - p
        along = dr.dot(offset, direction)
        meets |= (along + radius > 0) & (dr.squared_norm(offset - along * direction) < dr.square(radius))
    return meets


def horizon(spheres: list[tuple[Any, Any]], ray: Any, weight: Any, sigma_t: Any, eta: Any) -> Any:
    """Return a distance behind which `straight_through` finds no lamp, for a ray inside with light of a `weight`.

    A surface bends what it lets out by 90 degrees less the critical angle, or less: mostly no lamp is that way.
    """
    left = dr.max(dr.log(dr.maximum(weight, _LEAST) / _LEAST) / dr.maximum(sigma_t, 1e-30))
    bent = dr.select(eta > 1, 0.5 * dr.pi - dr.safe_asin(dr.rcp(eta)), 0.5 * dr.pi)
    result = mi.Float(0)
    for centre, radius in spheres:
        offset = centre - ray.o
        distance = dr.norm(offset)
        # as wide as it is seen from anywhere on that way
        wide = dr.safe_asin((radius + left) / distance)
        wide = dr.select(radius + left < distance, wide, dr.pi)
        away = dr.safe_acos(dr.dot(offset, ray.d) / distance)
        result = dr.select(away < bent + wide, left, result)
    return result


def lamp(scene: Any, ray: Any, active: Any) -> Any:
    """Return the light of the lamp's surface that the ray meets first; 0 if it meets none."""
    si = scene.ray_intersect(ray, active)
    return dr.select(si.is_valid(), si.emitter(scene, active).eval(si, active & si.is_valid()), 0)


@dr.syntax
def straight_through(
    scene: Any, media: Media, spheres: list[tuple[Any, Any]], hit: Any, ray: Any, within: Any, shape: Any,
    weight: Any, sigma_t: Any, active: Any,
) -> tuple[Any, Any]:  # fmt: skip
    """Return the light of a lamp that a ray meets straight behind an object, and whether it has been looked for.

    `hit`: where a ray inside the smooth `shape`, of the material `within`, gets to; `weight`: of its light so far.
    """
    light = mi.Spectrum(0)
    left = weight * dr.exp(-sigma_t * hit.t)
    looks = active & hit.is_valid() & (dr.max(left) > _LEAST) & (media.lookup(media.rough, within) == 0)
    if looks:
        si = hit.compute_surface_interaction(ray, mi.RayFlags.All, looks)
        x = interface.cross(si, ray.d, dr.rcp(media.lookup(media.eta, within)))
        looks &= (dr.reinterpret_array(mi.UInt32, si.shape) == shape) & (x.reflectance < 1)
        looks &= may_meet(spheres, si.p, x.refracted)
        if looks:
            light = left * (1 - x.reflectance) * lamp(scene, si.spawn_ray(x.refracted), looks)
    return light, looks
