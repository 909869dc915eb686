"""From a plane without end to a body: how a profile changes where two points do not face the same way.

Diffusion carries light from a source just under one surface to a sink just under another: a derivative along each of
the two normals of the Green's function `G(d) = exp(-k d) / d`, k = sigma_tr. Along `w`, the unit vector from x to y,

    d/dn_x d/dn_y G  =  G (1 + k d) / d^2  [n_x . n_y  +  q (-n_x . w) (n_y . w)],   q = 3 + (k d)^2 / (1 + k d).

On a plane the bracket is 1, and the factor before it falls off as profiles do. Two points of a sphere have the bracket
`1 + (q - 2) m m`, where m is the cosine of w to either normal's axis, and so have points that face each other through
a slab. That is the factor here. It is 1 on planes, reciprocal, and twice and more as bright straight through a body as
a profile says, which has never left its plane. (Between points of a thin slab that are far apart `n_x . n_y` = -1 would
make the bracket negative; light goes back and forth there, both sides are alike, and the factor is 1.)
"""

from __future__ import annotations

from typing import Any

import drjit as dr

__all__ = ["facing"]


def facing(offset: Any, n_o: Any, n_i: Any, sigma_tr: Any) -> Any:
    """Return the light between two points of a body over that between points of a plane as far apart.

    `offset`: from the first point to the second; `n_o`, `n_i`: unit normals there, outward; `sigma_tr`: one or more
    channels, per the same length. Where the straight line leaves the body at once, the factor is 1.
    """
    d = dr.norm(offset)
    w = offset / dr.maximum(d, 1e-20)
    through = dr.maximum(-dr.dot(n_o, w), 0.0) * dr.maximum(dr.dot(n_i, w), 0.0)
    kd = sigma_tr * d
    return 1.0 + (1.0 + kd * kd / (1.0 + kd)) * through
