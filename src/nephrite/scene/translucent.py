"""Which shapes of a scene are translucent, and where they are in the picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import mitsuba as mi


def translucent_shapes(scene: mi.Scene) -> list[mi.Shape]:
    """Return the shapes that light enters: `translucent` ones, and glass with a medium inside."""
    return [shape for shape in scene.shapes() if _is_translucent(shape)]


def object_mask(scene: mi.Scene) -> NDArray[np.bool_]:
    """Return the pixels, (height, width), whose centres show a translucent shape first."""
    import drjit as dr
    import mitsuba as mi

    sensor = scene.sensors()[0]
    width, height = (int(side) for side in sensor.film().crop_size())
    index = dr.arange(mi.UInt32, width * height)
    spot = mi.Point2f((mi.Float(index % width) + 0.5) / width, (mi.Float(index // width) + 0.5) / height)
    ray: Any = sensor.sample_ray(mi.Float(0), mi.Float(0.5), spot, mi.Point2f(0.5))[0]
    seen = scene.ray_intersect(ray).shape
    inside = mi.Bool(False)
    for shape in translucent_shapes(scene):
        inside |= seen == mi.ShapePtr(shape)
    return np.broadcast_to(np.array(inside), width * height).reshape(height, width)


def _is_translucent(shape: mi.Shape) -> bool:
    bsdf = shape.bsdf()
    if bsdf is None:
        return False
    kind = f"{type(bsdf).__name__} {bsdf.class_name()}".lower()
    return "translucent" in kind or ("dielectric" in kind and shape.interior_medium() is not None)
