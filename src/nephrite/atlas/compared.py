"""How far one noisy picture is from another: errors with their standard errors, noise taken out where it can be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["BLOCK", "MAP_BLOCK", "WORST_BLOCK", "Difference", "Estimate", "block_map", "difference", "sums"]

BLOCK = 8
"""Side, in pixels, of the blocks whose errors are averaged."""

WORST_BLOCK = 16
"""Side of the blocks among which the worst is looked for."""

MAP_BLOCK = 4
"""Side of the blocks of error maps."""

_COVERAGE = 0.5  # of a block must be the object's

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A picture with the standard error of each of its values: (height, width, channels)."""

    mean: Floats
    error: Floats

    def noise_of_blocks(self, block: int) -> Floats:
        """Return the standard error of the mean over each block of pixels, at each of its pixels."""
        variance = _blocks(self.error**2, block) / block**4
        return _spread(np.sqrt(variance), block, self.mean.shape)


@dataclass(frozen=True)
class Difference:
    """A picture less the truth, relative to it; each with its standard error, which has both pictures' noise.

    `bias`: of the object's whole light. `error`: root mean square of the difference over the blocks of `BLOCK` pixels,
    by the truth's, and that over the channels; less what noise adds to it, so that a perfect model has 0 but for
    chance, and a black picture has 1. `channels`: the same of each channel. `worst`: the block of `WORST_BLOCK` pixels
    that is farthest off, all channels together, relative to its own light.
    """

    bias: float
    bias_error: float
    error: float
    error_error: float
    channels: tuple[float, ...]
    channels_error: tuple[float, ...]
    worst: float
    worst_error: float


def difference(picture: Estimate, truth: Estimate, mask: NDArray[np.bool_]) -> Difference:
    """Compare over the object's pixels, `mask` (height, width)."""
    a, b, va, vb = sums(picture, truth, mask, None)
    whole_a, whole_b = a.sum(), b.sum()
    bias = whole_a / whole_b - 1.0
    bias_error = np.sqrt(va.sum() / whole_b**2 + vb.sum() * whole_a**2 / whole_b**4)

    a, b, va, vb = sums(picture, truth, mask, BLOCK)
    scale = np.maximum((b**2 - vb).mean(axis=0), 1e-30)
    noise = va + vb
    squares = ((a - b) ** 2 - noise).mean(axis=0) / scale
    spread = np.sqrt((4.0 * np.maximum((a - b) ** 2 - noise, 0.0) * noise + 2.0 * noise**2).sum(axis=0))
    spread = spread / len(a) / scale
    error, error_error = _root(squares.mean(), np.sqrt((spread**2).sum()) / len(spread))
    each = [_root(square, width) for square, width in zip(squares, spread, strict=True)]

    a, b, va, vb = (x.sum(axis=1) for x in sums(picture, truth, mask, WORST_BLOCK))
    relative = a / b - 1.0
    at = int(np.abs(relative).argmax())
    worst_error = np.sqrt(va[at] / b[at] ** 2 + vb[at] * a[at] ** 2 / b[at] ** 4)
    return Difference(
        float(bias), float(bias_error), error, error_error,
        tuple(value for value, _ in each), tuple(width for _, width in each),
        float(relative[at]), float(worst_error),
    )  # fmt: skip


def sums(
    picture: Estimate, truth: Estimate, mask: NDArray[np.bool_], block: int | None
) -> tuple[Floats, Floats, Floats, Floats]:
    """Sum light and variance, picture and truth, over the blocks that count: each (blocks, channels).

    `block`: the side in pixels, None for the object as a whole. Half of a block must be the object's.
    """
    inside = mask[..., None].astype(np.float64)
    values = [x * inside for x in (picture.mean, truth.mean, picture.error**2, truth.error**2)]
    if block is None:
        found = [x.sum(axis=(0, 1))[None] for x in values]
    else:
        keep = _blocks(inside, block)[..., 0] >= _COVERAGE * block * block
        if not keep.any():
            keep[...] = True
        found = [_blocks(x, block)[keep] for x in values]
    return found[0], found[1], found[2], found[3]


def block_map(picture: Estimate, truth: Estimate, mask: NDArray[np.bool_], block: int = MAP_BLOCK) -> Floats:
    """Return relative differences of the channels' mean, (height, width), one value a block; NaN off the object.

    Dark blocks are divided by 5 % of the object's mean, so that they show 0 and not noise.
    """
    inside = mask[..., None].astype(np.float64)
    a, b, count = (
        _blocks(x, block).mean(axis=2) for x in (picture.mean * inside, truth.mean * inside, inside)
    )
    floor = 0.05 * b.sum() / count.sum()
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = (a - b) / np.maximum(b, floor * count)
    return np.where(mask, _spread(relative[..., None], block, (*mask.shape, 1))[..., 0], np.nan)


def _root(square: float, width: float) -> tuple[float, float]:
    """Return the root of a mean square, 0 if noise has made it negative, and its standard error."""
    root = float(np.sqrt(max(square, 0.0)))
    # near 0 the root is no straight line: there, what its square's standard error is the square of
    return root, float(min(width / max(2.0 * root, 1e-30), np.sqrt(width)))


def _spread(blocks: Floats, block: int, shape: tuple[int, ...]) -> Floats:
    """Give every pixel its block's value; NaN where rows and columns fill no block."""
    found = np.full(shape, np.nan)
    whole = np.repeat(np.repeat(blocks, block, axis=0), block, axis=1)
    found[: whole.shape[0], : whole.shape[1]] = whole
    return found


def _blocks(x: Floats, block: int) -> Floats:
    rows, columns = x.shape[0] // block, x.shape[1] // block
    whole = x[: rows * block, : columns * block].reshape(rows, block, columns, block, -1)
    return whole.sum(axis=(1, 3))
