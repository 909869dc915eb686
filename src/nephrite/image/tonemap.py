"""From linear light to the eight bits of a screen: exposure, an optional shoulder, the sRGB curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SHOULDER_START = 0.8
"""Exposed value up to which the shoulder leaves a picture as it is."""


def to_srgb8(pixels: NDArray, exposure: float = 0.0, shoulder: bool = False) -> NDArray[np.uint8]:
    """Tone map a linear picture for a screen: expose, clip, apply the sRGB curve, round.

    Args:
        pixels: Linear light, any shape; NaN and negative values become black, infinity the brightest value.
        exposure: In stops: +1 doubles the light. The default, 0, shows a linear 1.0 as white.
        shoulder: Instead of clipping at 1, bend values above 0.8 smoothly towards 1, so that highlights
            keep some shape. Off by default: a plain sRGB picture has the same numbers in every viewer.

    Returns:
        uint8 array of the same shape.
    """
    linear = np.nan_to_num(np.asarray(pixels, np.float32), nan=0.0, posinf=np.inf, neginf=0.0)
    linear = np.maximum(linear, 0.0) * np.float32(2.0**exposure)
    if shoulder:
        linear = soft_clip(linear)
    return np.rint(srgb_encode(np.minimum(linear, 1.0)) * 255.0).astype(np.uint8)


def from_srgb8(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the linear light, in [0, 1], of an sRGB picture of eight bits; undoes `to_srgb8`."""
    return srgb_decode(np.asarray(pixels, np.float32) / 255.0)


def soft_clip(linear: NDArray, start: float = SHOULDER_START) -> NDArray:
    """Bend [start, infinity] onto [start, 1] by an exponential of slope 1 at `start`; below, the identity."""
    room = 1.0 - start
    above = np.maximum(linear - start, 0.0)
    return np.minimum(linear, start) - room * np.expm1(-above / room)


def srgb_encode(linear: NDArray) -> NDArray:
    """Apply the opto-electronic transfer function of IEC 61966-2-1 to values in [0, 1]."""
    return np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(np.maximum(linear, 1e-8), 1 / 2.4) - 0.055
    )


def srgb_decode(encoded: NDArray) -> NDArray:
    """Undo `srgb_encode`: from encoded values in [0, 1] to linear light."""
    encoded = np.asarray(encoded)
    return np.where(encoded <= 0.04045, encoded / 12.92, np.power((encoded + 0.055) / 1.055, 2.4))
