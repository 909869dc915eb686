"""The Henyey-Greenstein phase function as the triple eval / sample / pdf; isotropic at g = 0.

`cos_theta` is between the direction in which light travels before the event and the one after it: g > 0
scatters forward and <cos_theta> = g. All arguments are floats, NumPy or Dr.Jit arrays. Source: Henyey and
Greenstein (1941); inversion of the distribution as in Witt (1977).
"""

from __future__ import annotations

import math
from typing import Any

from nephrite.errors import ParameterError
from nephrite.physics._arrays import namespace, plain

__all__ = ["check_g", "eval", "pdf", "sample", "sample_cosine"]

_ISOTROPIC = 1e-3  # below, the closed inversion loses digits to cancellation; a series takes over


def check_g(g: float) -> float:
    """Return the mean cosine `g` as a float; raise `ParameterError` unless it is inside (-1, 1)."""
    try:
        value = float(g)
    except (TypeError, ValueError):
        value = math.nan
    if not -1.0 < value < 1.0:
        raise ParameterError(
            f"g is {g!r}, but the mean cosine of scattering lies strictly between -1 and 1: "
            "use 0 for isotropic, 0.8 for forward scattering."
        )
    return value


def eval(cos_theta: Any, g: Any) -> Any:
    """Value p(cos_theta) per solid angle (1/sr); its integral over the sphere is 1."""
    xp = namespace(cos_theta, g)
    # 1 + g^2 - 2 g cos, written so that it does not cancel when g is near +-1 and the cosine near the peak
    spread = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_theta)
    spread = xp.maximum(spread, 1e-12)
    return plain((1.0 - g * g) / (4.0 * math.pi * spread * xp.sqrt(spread)))


def pdf(cos_theta: Any, g: Any) -> Any:
    """Density per solid angle (1/sr) with which `sample` chooses a direction: equal to `eval`."""
    return eval(cos_theta, g)


def sample_cosine(u: Any, g: Any) -> Any:
    """Map a uniform number in [0, 1) to cos_theta in [-1, 1]; density `2 pi pdf` in the cosine."""
    xp = namespace(u, g)
    signed = 1.0 - 2.0 * u  # u = 0 is straight on, u = 1 straight back
    small = xp.abs(g) < _ISOTROPIC
    safe = xp.select(small, 1.0, g)
    fraction = (1.0 - safe * safe) / xp.select(small, 1.0, 1.0 + safe * signed)
    closed = (1.0 + safe * safe - fraction * fraction) / (2.0 * safe)
    series = signed + 1.5 * g * (1.0 - signed * signed)
    return plain(xp.minimum(xp.maximum(xp.select(small, series, closed), -1.0), 1.0))


def sample(u1: Any, u2: Any, g: Any) -> tuple[Any, Any, Any]:
    """Map two uniform numbers to a unit direction (x, y, z); z is the direction of travel before the event.

    Distributed as `pdf(z, g)` per solid angle.
    """
    xp = namespace(u1, u2, g)
    z = sample_cosine(u1, g)
    radius = xp.sqrt(xp.maximum(1.0 - z * z, 0.0))
    sine, cosine = xp.sincos(2.0 * math.pi * u2)
    return plain(radius * cosine), plain(radius * sine), z
