"""Which of two models is nearer to the truth in a view: by pairs, so that the truth's noise counts little."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nephrite.atlas.compared import BLOCK, Estimate, sums

__all__ = ["CHAMPION", "RIVALS", "SURE", "Contest", "is_open", "lead"]

CHAMPION = "tabulated"
RIVALS = ("photon_beam", "normalized")
SURE = 3.0
"""Standard errors by which one must lead for the order to be taken as known."""


@dataclass(frozen=True)
class Contest:
    """`lead` of `CHAMPION` before a `rival` in a view, with its standard error; `finer`: times the usual samples."""

    object: str
    size: float
    material: str
    light: str
    rival: str
    lead: float
    lead_error: float
    finer: int


def lead(one: Estimate, other: Estimate, truth: Estimate, mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Return how much less the square of `one`'s error is than that of `other`'s, and the standard error of that.

    Squares of `compared.Difference.error`, over the same blocks, without the share of the noise. With one's value p,
    the other's q and the truth t, `(q - t)^2 - (p - t)^2` has the truth's noise only by `2 (p - q)` and by its product
    with theirs.
    """
    p, t, vp, vt = sums(one, truth, mask, BLOCK)
    q, _, vq, _ = sums(other, truth, mask, BLOCK)
    scale = np.maximum((t**2 - vt).mean(axis=0), 1e-30)
    values = ((q - t) ** 2 - vq) - ((p - t) ** 2 - vp)
    own = np.maximum((p - t) ** 2 - vp - vt, 0.0) * vp + np.maximum((q - t) ** 2 - vq - vt, 0.0) * vq
    shared = np.maximum((p - q) ** 2 - vp - vq, 0.0) * vt
    variance = 4.0 * (own + shared + vt * (vp + vq)) + 2.0 * (vp**2 + vq**2)
    spread = np.sqrt(variance.sum(axis=0)) / len(t) / scale
    return float((values.mean(axis=0) / scale).mean()), float(np.sqrt((spread**2).sum()) / len(spread))


def is_open(pictures: Mapping[str, Estimate], truth: Estimate, mask: NDArray[np.bool_]) -> bool:
    """Whether noise leaves it open if `CHAMPION` or one of `RIVALS` is nearer; False where one is missing."""
    if CHAMPION not in pictures:
        return False
    leads = [lead(pictures[CHAMPION], pictures[rival], truth, mask) for rival in RIVALS if rival in pictures]
    return any(abs(value) < SURE * error for value, error in leads)
