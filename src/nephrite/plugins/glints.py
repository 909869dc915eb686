"""Glints: lamps that a smooth surface mirrors, looked at from where they are mirrored.

Fresnel reflection sends few paths to a lamp, and each brings all of its light: noise that covers all else.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

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


def lamp(scene: Any, ray: Any, active: Any) -> Any:
    """Return the light of the lamp's surface that the ray meets first; 0 if it meets none."""
    si = scene.ray_intersect(ray, active)
    return dr.select(si.is_valid(), si.emitter(scene, active).eval(si, active & si.is_valid()), 0)
