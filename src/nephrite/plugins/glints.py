"""Glints: lamps that a smooth surface mirrors, looked at from where they are mirrored.

Fresnel reflection sends few paths to a lamp, and each brings all of its light: noise that covers all else.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

_MOST = 4  # lamps that are looked for


def lamps(scene: Any) -> list[tuple[Any, Any]]:
    """Return centers and radii of spheres around the lamps that have a surface; none if there are too many."""
    boxes = [light.get_shape().bbox() for light in scene.emitters() if light.get_shape() is not None]
    if len(boxes) > _MOST:
        return []
    spheres = [(mi.Point3f(box.center()), mi.Float(dr.norm(box.extents()) / 2)) for box in boxes]
    dr.make_opaque(spheres)  # lamps that move compile nothing anew
    return spheres


def may_meet(spheres: list[tuple[Any, Any]], p: Any, direction: Any) -> Any:
    """Return whether what leaves `p` in a direction meets one of the spheres of `lamps`."""
    meets = mi.Bool(False)
    for center, radius in spheres:
        offset = center - p
        along = dr.dot(offset, direction)
        meets |= (along + radius > 0) & (dr.squared_norm(offset - along * direction) < dr.square(radius))
    return meets


def lamp(scene: Any, ray: Any, active: Any) -> Any:
    """Return the light of the lamp's surface that the ray meets first; 0 if it meets none."""
    si = scene.ray_intersect(ray, active)
    return dr.select(si.is_valid(), si.emitter(scene, active).eval(si, active & si.is_valid()), 0)
