"""Russian roulette: which paths and walks go on, by what they are worth beside what going on costs."""

from __future__ import annotations

from typing import Any

import drjit as dr

AFTER_LIGHT = 0.5  # of the paths that come by where lights have been connected to go on
SHARE = 0.5  # of a walk's light, below which its roulette begins
ORDER = 16.0  # reduced order of scattering, above which walks are thinned out


def entering(worth: Any, of_camera: Any, depth: Any) -> Any:
    """Return how likely a path that enters a medium begins a walk, for its throughput and what it began with.

    A walk has dozens of rays, where all that led to it had a few: after a bounce that keeps little light, few walks
    tell as much. Paths that come from the camera all begin one.
    """
    return dr.select(depth > 0, dr.minimum(worth / dr.maximum(of_camera, 1e-30), 1), 1)


def lit(worth: Any, of_camera: Any) -> Any:
    """Return how likely a path goes on from where lights have been connected to, in scenes where light jumps.

    What it may still find is mostly dim, and costs as much as all before: there a jump is a few rays, where a walk has
    dozens, of which the path would have had its share for nothing.
    """
    return dr.minimum(AFTER_LIGHT * worth / dr.maximum(of_camera, 1e-30), 1)


def walking(worth: Any, entered: Any, order: Any) -> Any:
    """Return how likely a walk goes on, for its throughput now and where it entered; may exceed 1.

    Of walks in a half-space as many are left after n events as 1 / √n says, and each goes on for about as many again.
    So if they are thinned out by √n as well, walks of all lengths share alike in the cost, and in the variance too.
    """
    least = SHARE * entered * dr.maximum(dr.sqrt(order / ORDER), 1)
    return worth / dr.maximum(least, 1e-30)
