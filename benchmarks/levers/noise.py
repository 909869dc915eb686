"""Where the noise of a picture comes from: by terms, and by the place on a lamp that is connected to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

TERMS = ("reduced", "single", "multiple")
_SAMPLES = 16  # a pixel


def of_terms(picture: Callable[[int, str], NDArray], mask: NDArray[np.bool_]) -> dict[str, float]:
    """Return the variance of a picture of each term over the squared mean of all, over the pixels of `mask`.

    `picture`: renders terms with a seed.
    """
    pairs = {term: [picture(seed, term)[mask].astype(np.float64) for seed in (3, 4)] for term in TERMS}
    mean = sum(pair[0] + pair[1] for pair in pairs.values()).mean() / 2
    return {term: float(np.mean((a - b) ** 2) / 2 / mean**2) for term, (a, b) in pairs.items()}


def of_lamps(scene: Any) -> float:
    """Return the relative variance, at what the camera sees, of what a place on a lamp brings, as places are drawn.

    Were they drawn by solid angle, each would bring as much. What is in the way is left out, and how the surface is
    turned. The largest of all lamps.
    """
    sensor = scene.sensors()[0]
    width, height = sensor.film().crop_size()
    sampler: Any = mi.load_dict({"type": "independent"})
    sampler.seed(0, width * height * _SAMPLES)
    ray, _ = sensor.sample_ray(0.0, 0.0, sampler.next_2d(), mi.Point2f(0.5))
    seen = scene.ray_intersect(ray)
    found = []
    for emitter in scene.emitters():
        if not mi.has_flag(emitter.flags(), mi.EmitterFlags.Surface):
            continue
        a, b = (mi.luminance(emitter.sample_direction(seen, sampler.next_2d())[1]) for _ in range(2))
        lit = seen.is_valid() & (a > 0) & (b > 0)
        square = dr.sum(dr.select(lit, dr.square(a - b), 0)) / 2
        found.append(square / dr.sum(dr.select(lit, a * b, 0)))
    return float(dr.max(dr.concat(found))[0]) if found else 0.0
