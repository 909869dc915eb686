"""Where light between surfaces tends to, from a few rounds of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

_LEAST = 1e-12  # of the squared steps: below it is rounding


def limit(rounds: Sequence[NDArray]) -> NDArray:
    """Return the fixed point of `x -> M x + b` from `x, M x + b, ...`: at least two arrays, [..., channels].

    Each channel by itself is the mean of the `rounds` with weights, of either sign, for which the same mean of their
    steps is shortest: reduced rank extrapolation (Eddy 1979; Smith, Ford & Sidi 1987). With one round more
    than M has dimensions it is exact; before, it finds what decays slowest first, wherever that is: light in a deep gap
    takes many more rounds than that on the outside.
    """
    found = np.empty_like(rounds[-1])
    for channel in range(found.shape[-1]):
        x = np.stack([one[..., channel].ravel() for one in rounds]).astype(np.float64)
        steps = np.diff(x, axis=0)
        products = steps @ steps.T
        products += (_LEAST * np.trace(products) + 1e-100) * np.eye(len(steps))
        weights = np.linalg.solve(products, np.ones(len(steps)))
        found[..., channel] = (weights / weights.sum() @ x[1:]).reshape(found.shape[:-1])
    return found
