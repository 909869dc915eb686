"""The surface colour of `nephrite.physics.color`, rendered: a thick flat piece in uniform light, by the exact walk."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.physics import Medium
from support import scenes

DEEP = 15.0
"""Half the side of the piece, in diffuse mean free paths: e^-15 of the light gets to its end."""

WALK = scenes.ours(model="walk", exit="exact", terms="single+multiple", max_steps=2**31 - 1)
"""The exact walk, without what the surface reflects before light enters.

Not cut short: at a colour of .98 and g = .9 a walk has some 10,000 events on average, and far more at its end.
"""


def scene(medium: Medium, alpha: float = 0.0) -> Any:
    """Load a cube whose upper face is at z = 0, of a medium in 1/(scene unit), under a sky of radiance 1."""
    half = DEEP * max(medium.dmfp)
    to_world = mi.ScalarTransform4f().translate([0, 0, -half]).scale(half)
    piece = {"type": "cube", "to_world": to_world}
    piece |= scenes.translucent(medium.sigma_a, medium.sigma_s, medium.g, medium.eta, alpha)
    return mi.load_dict({"type": "scene", "piece": piece, "sky": scenes.environment(1.0)})


def shown(scene: Any, paths: int, passes: int, seed: int = 0) -> NDArray[np.float64]:
    """Return the radiance that the face shows, averaged as diffuse light is: (passes, 3).

    Looks at one point, which is off the diagonal where two triangles meet, from cosine-distributed directions.
    """
    integrator: Any = mi.load_dict(WALK)
    sampler: Any = mi.load_dict({"type": "independent"})
    means = []
    for i in range(passes):
        sampler.seed(seed + i, paths)
        toward = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        ray = mi.Ray3f(mi.Point3f(0.3, 0.1, 0.0) + 0.01 * toward, -toward)
        radiance = integrator.sample(scene, sampler, ray)[0]
        means.append([float(dr.mean(channel)[0]) for channel in radiance])
    return np.array(means)
