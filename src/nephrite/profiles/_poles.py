"""What a point source at the depth z, and its image, send through the plane: the parts that dipoles share."""

from __future__ import annotations

from typing import Any

from nephrite.physics._arrays import namespace

LEAST_EXTINCTION = 1e-9  # stands for none: its lengths, to the power that they occur in, fit single precision


def distance(r: Any, z: Any) -> Any:
    """Distance from a pole at the depth z to the surface point at r; above 0."""
    xp = namespace(r, z)
    return xp.sqrt(xp.maximum(r * r + z * z, 1e-30))


def flux(r: Any, z: Any, falloff: Any) -> Any:
    """Flux `z (1 + s d) e^(-s d) / d^3`, s = `falloff`, of a pole at z > 0; its integral is `2 pi e^(-s z)`."""
    d = distance(r, z)
    x = falloff * d
    return z / d * (1.0 + x) * namespace(x).exp(-x) / (d * d)


def flux_beyond(r: Any, z: Any, falloff: Any) -> Any:
    """Integral of `flux` from r outwards, without 2 pi: `z e^(-s d) / d`."""
    d = distance(r, z)
    return z / d * namespace(d, falloff).exp(-falloff * d)


def fluence(r: Any, near: Any, far: Any, falloff: Any) -> Any:
    """Fluence `e^(-s d)/d` of a source at depth `near` less that of an image at height `far` >= `near`.

    By their difference, which does not cancel where r is much longer than both.
    """
    a, b = distance(r, near), distance(r, far)
    gap = (far - near) / (a + b) * (far + near)
    return namespace(a, falloff).exp(-falloff * a) * gap / b * (1.0 / a + falloff * decayed(falloff * gap))


def fluence_beyond(r: Any, near: Any, far: Any, falloff: Any) -> Any:
    """Integral of `fluence` from r outwards, without 2 pi: `(e^(-s a) - e^(-s b)) / s`."""
    a, b = distance(r, near), distance(r, far)
    gap = (far - near) / (a + b) * (far + near)
    return namespace(a, falloff).exp(-falloff * a) * gap * decayed(falloff * gap)


def decayed(x: Any) -> Any:
    """`(1 - e^(-x)) / x` for x >= 0; 1 at 0."""
    xp = namespace(x)
    small = x < 0.5
    series = x * 0.0
    for k in range(11, 1, -1):
        series = (1.0 + series) * (-xp.minimum(x, 0.5) / k)
    safe = xp.select(small, 1.0, x)
    return xp.select(small, 1.0 + series, (1.0 - xp.exp(-safe)) / safe)
