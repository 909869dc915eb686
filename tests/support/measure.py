"""Pictures as random numbers: passes with their spread, z-scores of blocks, and the chance of a false alarm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy import stats

from nephrite.image.errors import z_limit

FALSE_ALARM = 1e-3
"""Probability with which a right program fails one of the statistical tests, were its seeds drawn anew."""


@dataclass(frozen=True)
class Passes:
    """Independent pictures, (passes, height, width, channels)."""

    pictures: NDArray[np.float64]

    @property
    def mean(self) -> NDArray[np.float64]:
        return self.pictures.mean(0)

    def blocks(self, block: int, mask: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
        """Return (passes, blocks, channels): sums over square blocks, those that the mask fills to a half."""
        height, width = self.pictures.shape[1:3]
        inside = np.ones((height, width)) if mask is None else mask.astype(float)
        inside = inside[None, ..., None]
        keep = _block_sums(inside, block)[0, :, 0] >= block * block / 2
        return _block_sums(self.pictures * inside, block)[:, keep]

    def total(self, mask: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
        """Return (passes, channels): means over the mask."""
        chosen = self.pictures.mean((1, 2)) if mask is None else self.pictures[:, mask].mean(1)
        return chosen


def _block_sums(x: NDArray, block: int) -> NDArray[np.float64]:
    n, height, width, channels = x.shape
    rows, columns = height // block, width // block
    whole = x[:, : rows * block, : columns * block].reshape(n, rows, block, columns, block, channels)
    return whole.sum((2, 4)).reshape(n, rows * columns, channels)


def passes(scene: Any, integrator: Any, spp: int, count: int, seed: int) -> Passes:
    """Render `count` pictures with the seeds from `seed` on; scene and integrator may be dictionaries."""
    loaded = mi.load_dict(scene) if isinstance(scene, dict) else scene
    method = mi.load_dict(integrator) if isinstance(integrator, dict) else integrator
    pictures = [np.array(mi.render(loaded, integrator=method, spp=spp, seed=seed + i)) for i in range(count)]
    return Passes(np.array(pictures, dtype=np.float64))


def picture(scene: Any, integrator: dict[str, Any], spp: int = 64, seed: int = 1) -> NDArray[np.float64]:
    """Render one picture."""
    return passes(scene, integrator, spp, 1, seed).pictures[0]


def scores(a: NDArray, b: NDArray) -> NDArray[np.float64]:
    """Return z-scores of mean(a) - mean(b) over the first axis, by Welch's t-test.

    Student's t is mapped to the normal deviate of the same probability, so that few passes make no heavy tails.
    Differences below float32's precision count as none.
    """
    va, vb = a.var(0, ddof=1) / len(a), b.var(0, ddof=1) / len(b)
    spread = np.sqrt(va + vb)
    difference = a.mean(0) - b.mean(0)
    difference = np.where(np.abs(difference) <= 2e-6 * np.abs(b.mean(0)), 0.0, difference)
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = (va + vb) ** 2 / (va**2 / (len(a) - 1) + vb**2 / (len(b) - 1))
        t = np.where(difference == 0, 0.0, difference / spread)
        z = stats.norm.isf(stats.t.sf(np.abs(t), np.where(np.isfinite(freedom), freedom, 1.0)))
    return np.where(np.isinf(t), np.inf, np.where(t == 0, 0.0, z)) * np.sign(t)


@dataclass(frozen=True)
class Bias:
    """Relative differences to a reference with their standard errors: of the object, and of its blocks.

    `mean`, `mean_error`: (channels,); `blocks`, `blocks_error`: (blocks, channels).
    """

    mean: NDArray[np.float64]
    mean_error: NDArray[np.float64]
    blocks: NDArray[np.float64]
    blocks_error: NDArray[np.float64]

    @property
    def worst(self) -> tuple[float, float]:
        """The largest difference of a block, and its standard error."""
        at = np.unravel_index(np.abs(self.blocks).argmax(), self.blocks.shape)
        return float(self.blocks[at]), float(self.blocks_error[at])

    @property
    def rms(self) -> float:
        """Root mean square of the blocks' differences, less what noise explains; 0 if that is more."""
        return float(np.sqrt(max(float((self.blocks**2 - self.blocks_error**2).mean()), 0.0)))

    def __str__(self) -> str:
        means = "  ".join(
            f"{100 * m:+5.2f} +- {100 * e:4.2f}" for m, e in zip(self.mean, self.mean_error, strict=True)
        )
        worst, error = self.worst
        blocks = f"worst block % {100 * worst:+5.2f} +- {100 * error:4.2f} | rms % {100 * self.rms:4.2f}"
        return f"object % {means} | {blocks}"


def bias(picture: Passes, reference: Passes, mask: NDArray[np.bool_], block: int = 4) -> Bias:
    """Compare over the object's pixels, and over the square blocks that it fills to a half or more."""
    mean, mean_error = _ratio(picture.total(mask), reference.total(mask))
    blocks, blocks_error = _ratio(picture.blocks(block, mask), reference.blocks(block, mask))
    return Bias(mean, mean_error, blocks, blocks_error)


def _ratio(a: NDArray, b: NDArray) -> tuple[NDArray, NDArray]:
    ma, mb = a.mean(0), b.mean(0)
    relative = np.sqrt(a.var(0, ddof=1) / len(a) / ma**2 + b.var(0, ddof=1) / len(b) / mb**2)
    return ma / mb - 1, relative * ma / mb


def assert_same(a: Passes, b: Passes, block: int = 4, label: str = "") -> None:
    """Assert equal expectations, of the whole picture and of its blocks, with the chance `FALSE_ALARM` to err."""
    whole, parts = scores(a.total(), b.total()), scores(a.blocks(block), b.blocks(block))
    every = np.concatenate([whole.ravel(), parts.ravel()])
    limit = z_limit(every.size, FALSE_ALARM)
    relative = a.mean.mean() / b.mean.mean() - 1
    error = np.sqrt(
        a.total().mean(1).var(ddof=1) / len(a.pictures) + b.total().mean(1).var(ddof=1) / len(b.pictures)
    )
    text = (
        f"{label}: means differ by {100 * relative:+.3f} % +- {100 * error / abs(b.mean.mean()):.3f} %, "
        f"z {np.round(whole, 2)}, worst block {np.abs(parts).max():.2f}, limit {limit:.2f}"
    )
    print(text)
    assert np.isfinite(a.pictures).all(), f"{label}: not finite"
    assert np.isfinite(b.pictures).all(), f"{label}: not finite"
    assert np.abs(every).max() < limit, text
