"""How far a picture is from a reference, and how fast it gets there."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from nephrite.errors import ParameterError


def relmse(image: NDArray, reference: NDArray, mask: NDArray | None = None, epsilon: float = 1e-2) -> float:
    """Relative mean squared error: the mean of (image - reference)^2 / (reference^2 + epsilon).

    Args:
        image: (height, width, 3) linear light.
        reference: The same shape.
        mask: (height, width) boolean; only these pixels count. Default: all.
        epsilon: In squared radiance; keeps black pixels from deciding (Rousselle et al. 2011 use 0.01).
    """
    a, b = _masked(mask, image, reference)
    return float(np.mean((a - b) ** 2 / (b**2 + epsilon)))


def mean_bias(image: NDArray, reference: NDArray, mask: NDArray | None = None) -> NDArray[np.float64]:
    """Relative error of the mean over the mask, signed, one a channel: +0.02 is 2 % too bright.

    Returns:
        (3,) array; NaN where both means are 0, infinite where only the reference's is.
    """
    a, b = _masked(mask, image, reference)
    return _relative(a.mean(axis=0), b.mean(axis=0))


def block_errors(
    image: NDArray,
    reference: NDArray,
    mask: NDArray | None = None,
    block: int = 16,
    coverage: float = 0.5,
) -> NDArray[np.float64]:
    """Signed relative errors of the means of square blocks of pixels: bias that a whole mean may hide.

    In each block only pixels of the mask count. Rows and columns that do not fill a last block are left out.

    Args:
        image: (height, width, 3) linear light.
        reference: The same shape, converged.
        mask: (height, width) boolean, the object's pixels. Default: all.
        block: Side of a block in pixels.
        coverage: Least share of a block that the mask must fill for the block to count.

    Returns:
        (rows, columns, 3) array, NaN for the blocks that do not count; `worst` gives its extreme.
    """
    a, b, inside = _pictures(image, reference, mask)
    count = _block_sums(inside[..., None].astype(np.float64), block)
    sums = [_block_sums(np.where(inside[..., None], x, 0.0), block) for x in (a, b)]
    errors = _relative(*sums)
    counts = count >= max(coverage * block * block, 1)
    return np.where(counts, errors, np.nan)


def worst(errors: NDArray) -> float:
    """Return the entry of `errors` that is largest in size, with its sign; NaN if there is none."""
    present = errors[~np.isnan(errors)]
    return float(present[np.argmax(np.abs(present))]) if present.size else float("nan")


def efficiency(a: NDArray, b: NDArray, seconds: float, mask: NDArray | None = None) -> float:
    """Efficiency mean^2 / (variance x seconds), in 1/s: twice as much is half the time to the same noise.

    Args:
        a: (height, width, 3) picture.
        b: The same picture with another seed, of the same number of samples.
        seconds: Time of one of the two, whole render call.
        mask: (height, width) boolean. Default: all pixels.

    Returns:
        The efficiency; infinite when the two are equal.

    Raises:
        ParameterError: `seconds` is not positive, or shapes differ.
    """
    if not seconds > 0:
        raise ParameterError(f"seconds must be positive, not {seconds}.")
    a, b = _masked(mask, a, b)
    variance = float(np.mean((a - b) ** 2) / 2)
    mean = float((a.mean() + b.mean()) / 2)
    return mean**2 / (variance * seconds) if variance > 0 else float("inf")


def z_scores(
    a: NDArray,
    b: NDArray,
    variance_a: NDArray,
    variance_b: NDArray,
    mask: NDArray | None = None,
    block: int = 1,
) -> NDArray[np.float64]:
    """Differences of two noisy pictures in standard deviations, a pixel or a block of pixels at a time.

    Where both estimate the same picture, the scores are standard normal, if pixels are independent (a box
    reconstruction filter) and variances are well known: those from few passes make heavier tails, which
    blocks of several pixels lessen.

    Args:
        a: (height, width, 3) mean.
        b: The other mean.
        variance_a: Variance of that mean (not of one sample), per pixel and channel.
        variance_b: The same for `b`.
        mask: (height, width) boolean; pixels outside do not count. Default: all.
        block: Side of the blocks over which to average first.

    Returns:
        (rows, columns, 3) array; NaN where nothing is inside the mask; 0 where equal, infinite
        where different without any variance.
    """
    a, b, inside = _pictures(a, b, mask)
    va, vb, _ = _pictures(variance_a, variance_b, mask)
    keep = inside[..., None]
    difference = _block_sums(np.where(keep, a - b, 0.0), block)
    deviation = np.sqrt(_block_sums(np.where(keep, va + vb, 0.0), block))
    with np.errstate(divide="ignore", invalid="ignore"):
        scores = np.where(difference == 0, 0.0, difference / deviation)
    return np.where(_block_sums(keep.astype(np.float64), block) > 0, scores, np.nan)


def z_limit(count: int, significance: float = 0.01) -> float:
    """Return the |z| that the largest of `count` independent scores exceeds with probability `significance`.

    Šidák's correction of the two-sided test.
    """
    if count < 1 or not 0 < significance < 1:
        raise ParameterError(f"need count > 0 and 0 < significance < 1, not {count} and {significance}.")
    single = -np.expm1(np.log1p(-significance) / count)
    return NormalDist().inv_cdf(1.0 - single / 2)


def difference(image: NDArray, reference: NDArray, mask: NDArray | None = None) -> NDArray[np.float64]:
    """Return a map of signed relative differences, of the mean of the channels, for `figure.heat_map`.

    The reference in the denominator is raised by 2 % of its mean, so that black pixels show 0 and not noise.

    Returns:
        (height, width) array; +0.1 is 10 % too bright; NaN outside the mask.
    """
    a, b, inside = _pictures(image, reference, mask)
    grey_a, grey_b = a.mean(axis=2), b.mean(axis=2)
    floor = 0.02 * abs(float(grey_b[inside].mean())) or 1.0
    return np.where(inside, (grey_a - grey_b) / (np.abs(grey_b) + floor), np.nan)


def _pictures(a: NDArray, b: NDArray, mask: NDArray | None) -> tuple[NDArray, NDArray, NDArray]:
    """Check shapes; return both as float64 and the mask as booleans."""
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if a.shape != b.shape or a.ndim != 3:
        raise ParameterError(f"pictures need one shape (height, width, 3), not {a.shape} and {b.shape}.")
    inside = np.ones(a.shape[:2], bool) if mask is None else np.asarray(mask, bool)
    if inside.shape != a.shape[:2]:
        raise ParameterError(f"the mask has the shape {inside.shape}, the picture {a.shape[:2]}.")
    if not inside.any():
        raise ParameterError("the mask is empty: no pixel to compare.")
    return a, b, inside


def _masked(mask: NDArray | None, a: NDArray, b: NDArray) -> tuple[NDArray, NDArray]:
    """Return the (n, 3) pixels of both pictures inside the mask."""
    a, b, inside = _pictures(a, b, mask)
    return a[inside], b[inside]


def _relative(a: NDArray, b: NDArray) -> NDArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return a / b - 1.0


def _block_sums(pixels: NDArray, block: int) -> NDArray:
    rows, columns = pixels.shape[0] // block, pixels.shape[1] // block
    if block < 1 or rows == 0 or columns == 0:
        raise ParameterError(f"blocks of {block} x {block} do not fit a picture of {pixels.shape[:2]}.")
    whole = pixels[: rows * block, : columns * block]
    return whole.reshape(rows, block, columns, block, -1).sum(axis=(1, 3))
