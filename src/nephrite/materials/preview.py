"""What a material looks like, in two colours, without rendering: lit from the front, and seen through."""

from __future__ import annotations

import math

from nephrite.physics.medium import RGB, Medium

__all__ = ["seen_through"]


def seen_through(medium: Medium, thickness: float) -> RGB:
    """Share of diffuse light that passes a slab `thickness` mm thick, RGB in [0, 1]; its surface is left out.

    Two streams (Kubelka and Munk) with K = 2 sigma_a and S = (3 sigma_s' - sigma_a) / 4, so that a thick slab
    decays with sigma_tr as diffusion says (Star, Marijnissen and van Gemert 1988). A preview: no angles, no
    interface.
    """
    channels = []
    for absorbed, scattered in zip(medium.sigma_a, medium.sigma_s_prime, strict=True):
        k, s = 2.0 * absorbed, max(0.75 * scattered - 0.25 * absorbed, 0.0)
        decay = math.sqrt(k * (k + 2.0 * s))
        # T = decay / ((k + s) sinh(decay d) + decay cosh(decay d)), times e^(-decay d) / e^(-decay d)
        fall = math.exp(-2.0 * decay * thickness)
        spread = -math.expm1(-2.0 * decay * thickness) / decay if decay > 0.0 else 2.0 * thickness
        channels.append(2.0 * math.exp(-decay * thickness) / ((k + s) * spread + 1.0 + fall))
    red, green, blue = channels
    return red, green, blue
