"""What light does at the surface between two media: the smooth dielectric interface, in world space.

Which side a ray is on is the integrator's knowledge, never the winding's: normals are turned to face the ray, so that
a flipped or mixed winding changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi


@dataclass
class Crossing:
    """A ray at a smooth interface.

    `normal`: unit, facing the ray. `reflectance`: exact unpolarised Fresnel. `reflected`, `refracted`: unit
    directions; the latter is void where `reflectance` is 1.
    """

    normal: Any
    reflectance: Any
    reflected: Any
    refracted: Any


def facing_normal(si: Any, direction: Any) -> Any:
    """Shading normal on the side that the ray comes from, or the geometric one where the two disagree."""
    geometric = mi.Vector3f(dr.mulsign(si.n, -dr.dot(si.n, direction)))
    shading = mi.Vector3f(dr.mulsign(si.sh_frame.n, dr.dot(si.sh_frame.n, geometric)))
    return dr.select(dr.dot(shading, direction) < 0, shading, geometric)


@dr.syntax
def cross(si: Any, direction: Any, eta: Any) -> Crossing:
    """Reflect and refract a ray; `eta`: index of the side that it would enter over the one it is on."""
    geometric = mi.Vector3f(dr.mulsign(si.n, -dr.dot(si.n, direction)))
    found = _cross(facing_normal(si, direction), direction, eta)
    # Interpolated normals may send light to the wrong side of a triangle: then the triangle's own normal holds.
    wrong = (dr.dot(found.reflected, geometric) <= 0) | (
        (found.reflectance < 1) & (dr.dot(found.refracted, geometric) >= 0)
    )
    if wrong:
        found = _cross(geometric, direction, eta)
    return found


def bent(si: Any, direction: Any, local: Any) -> tuple[Any, Any]:
    """Return whether a rough surface reflects what it has sent to `local`, in its frame, and that in world space.

    Interpolated normals may send light to the wrong side: then it is mirrored back.
    """
    reflects = local.z * si.wi.z > 0
    sent = si.to_world(local)
    normal = mi.Vector3f(si.n) * dr.sign(dr.select(reflects, -1, 1) * dr.dot(si.n, direction))
    return reflects, sent + normal * dr.maximum(-2 * dr.dot(sent, normal), 0)


def scattered(
    media: Any, number: Any, si: Any, d: Any, sampler: Any, active: Any
) -> tuple[Any, Any, Any, Any, Any]:
    """Sample the rough surface of material `number`, which light meets in the direction `d`.

    Returns whether it reflects, where to, the weight, the density, and whether there is none (Dirac's delta).
    """
    choice, spot = sampler.next_1d(active), sampler.next_2d(active)
    bs, weight = media.sample_surface(number, si, choice, spot, active)
    reflects, direction = bent(si, d, bs.wo)
    return reflects, direction, weight, bs.pdf, mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)


def _cross(normal: Any, direction: Any, eta: Any) -> Crossing:
    cos_i = -dr.dot(direction, normal)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    reflected = dr.fma(normal, 2.0 * cos_i, direction)
    refracted = direction * eta_ti + normal * (cos_i * eta_ti + cos_t)
    return Crossing(normal, reflectance, dr.normalize(reflected), dr.normalize(refracted))
