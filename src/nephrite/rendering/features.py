"""Pictures of albedo and normal: they tell a denoiser what is an edge and what is noise."""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.errors import ParameterError
from nephrite.rendering import schedule


def albedo_normal(
    scene: Any, sensor: int | Any = 0, spp: int = 16, seed: int = 0
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Render albedo and shading normal of the first surface, with Mitsuba's `aov` integrator.

    Args:
        scene: A loaded Mitsuba scene.
        sensor: Index of a sensor of the scene, or a Mitsuba sensor.
        spp: Samples per pixel, for smooth edges.
        seed: Any integer from 0.

    Returns:
        Two (height, width, 3) arrays, finite: albedo in [0, 1] (linear sRGB, as in the film), and normals
        in world space, within the unit ball, 0 where nothing is hit.

    Raises:
        ParameterError: `spp` is not positive.
    """
    if spp < 1:
        raise ParameterError(f"spp must be a whole number from 1, not {spp!r}.")
    camera = scene.sensors()[sensor] if isinstance(sensor, int) else sensor
    integrator: Any = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,normal:sh_normal"})
    largest = schedule.largest_pass(math.prod(camera.film().crop_size()), schedule.MAX_SAMPLES)
    total, done, base = np.float32(0), 0, schedule.first_seed(seed)
    while done < spp:
        size = min(largest, spp - done)
        start: Any = (base + done) % 2**32
        picture = mi.render(scene, sensor=camera, integrator=integrator, seed=start, spp=size)
        total = total + size * np.nan_to_num(np.array(picture, np.float32), posinf=0, neginf=0)
        done += size
    channels = np.asarray(total / np.float32(done), np.float32)
    albedo, normal = channels[..., :3], channels[..., 3:6]
    return np.clip(albedo, 0.0, 1.0), np.clip(normal, -1.0, 1.0)
