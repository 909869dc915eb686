"""What a medium itself sends along a segment of a path."""

from __future__ import annotations

from typing import Any

import drjit as dr


def along(
    length: Any, u: Any, β: Any, ratio: Any, sigma_t: Any, emitted: Any, eta: Any, through: Any
) -> Any:  # fmt: skip
    """Return the light that a segment's emission brings to the path's start; one point stands for all.

    `u`: uniform, where it is; `β`, `ratio`: the path's at the segment's start (see `channels`); `emitted`: per scene
    unit; `through`: whether the path goes through to the surface by all means. 1 / eta^2 of it leaves per solid angle.
    """
    to_point = dr.exp(-sigma_t * u * length)
    chance = dr.sum(ratio * dr.select(through, 1, to_point))
    return β * to_point * emitted * length / (dr.maximum(chance, 1e-30) * dr.square(eta))
