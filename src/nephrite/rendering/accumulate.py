"""Mean and variance of a picture from independent passes of different numbers of samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nephrite.errors import ParameterError

FLOOR = 0.05
"""Share of the median radiance that is added to a pixel's when its relative noise is taken."""


@dataclass(frozen=True)
class Accumulator:
    """Weighted running mean and sum of squares (West 1979); never changed in place, so always consistent.

    Attributes:
        mean: (height, width, 3) float32.
        squares: (height, width, 3) float32, sum over passes of spp (pixel - mean)^2.
        weight: (height, width, 1) float32, samples that count, per pixel.
        count: (height, width, 1) int32, passes that count, per pixel.
        spp: Samples per pixel rendered, dropped ones included.
        passes: Passes added.
        dropped: Pixel values left out because they were NaN or infinite.
    """

    mean: NDArray[np.float32]
    squares: NDArray[np.float32]
    weight: NDArray[np.float32]
    count: NDArray[np.int32]
    spp: int = 0
    passes: int = 0
    dropped: int = 0

    @classmethod
    def empty(cls, height: int, width: int) -> Accumulator:
        """Start with nothing."""
        colour, one = (height, width, 3), (height, width, 1)
        zeros = np.zeros(colour, np.float32)
        return cls(zeros, zeros, np.zeros(one, np.float32), np.zeros(one, np.int32))

    def add(self, pixels: NDArray, spp: int) -> Accumulator:
        """Return the statistics with one more pass, a mean of `spp` samples per pixel.

        A pixel with NaN or infinity in any channel is left out of this pass, as if it had not been sampled.
        """
        if pixels.shape != self.mean.shape:
            raise ParameterError(f"a pass has the shape {pixels.shape}, earlier ones {self.mean.shape}.")
        finite = np.isfinite(pixels).all(axis=2, keepdims=True)
        share = np.where(finite, np.float32(spp), np.float32(0))
        weight = self.weight + share
        kept = np.where(finite, pixels, self.mean).astype(np.float32)
        with np.errstate(over="ignore"):
            delta = kept - self.mean
            mean = self.mean + delta * (share / np.maximum(weight, 1))
            squares = self.squares + share * delta * (kept - mean)
        return Accumulator(
            mean.astype(np.float32),
            squares.astype(np.float32),
            weight,
            self.count + finite.astype(np.int32),
            self.spp + spp,
            self.passes + 1,
            self.dropped + int(finite.size - np.count_nonzero(finite)),
        )

    def variance(self) -> NDArray[np.float32]:
        """Return the (height, width, 3) variance of the mean; infinite where fewer than two passes count.

        A pass of n samples has the variance s^2 / n, so the weighted squares estimate (passes - 1) s^2.
        """
        known = self.count > 1
        divisor = np.where(known, np.maximum(self.count - 1, 1) * np.maximum(self.weight, 1), 1)
        return np.where(known, self.squares / divisor, np.inf).astype(np.float32)

    def noise(self) -> float:
        """Return the relative noise that `Result.noise` defines; infinite while it is unknown."""
        grey = self.mean.mean(axis=2)
        lit = (grey > 0) & (self.count[..., 0] > 1)
        if not lit.any():
            return float("inf")
        radiance = grey[lit]
        squared = self.variance().mean(axis=2)[lit] / (radiance + FLOOR * np.median(radiance)) ** 2
        return float(np.sqrt(squared.mean(dtype=np.float64)))
