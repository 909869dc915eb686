"""The light from all around, as a function of direction: every renderer gets it as a picture in its own projection."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def radiance(sky: dict[str, Any], directions: NDArray) -> NDArray[np.float32]:
    """Return (..., 3) radiance from `directions` (..., 3), unit vectors away from the scene.

    `sky` has `ambient`, and `lobes` of `radiance` e^(sharpness (cos - 1)) around their `direction`.
    """
    total = np.zeros(directions.shape) + np.array(sky["ambient"], np.float64)
    for lobe in sky["lobes"]:
        axis = np.array(lobe["direction"], np.float64)
        cosine = directions @ (axis / np.linalg.norm(axis))
        total += np.exp(lobe["sharpness"] * (cosine - 1.0))[..., None] * np.array(lobe["radiance"])
    return total.astype(np.float32)
