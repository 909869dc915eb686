"""The light from all around, as a function of direction: every renderer gets it as a picture in its own projection."""

from __future__ import annotations

from pathlib import Path
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


def write_hdr(path: Path, picture: NDArray) -> None:
    """Write (height, width, 3) as a Radiance picture: 8 bits a channel and a common exponent."""
    height, width, _ = picture.shape
    largest = np.maximum(picture.max(axis=2), 1e-30)
    exponent = np.floor(np.log2(largest)) + 1.0
    scaled = np.clip(np.rint(picture * (256.0 / 2.0**exponent)[..., None]), 0, 255)
    rows = np.concatenate([scaled, (exponent + 128.0)[..., None]], axis=2).astype(np.uint8)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    path.write_bytes(head.encode("ascii") + rows.tobytes())
