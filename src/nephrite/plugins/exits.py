"""Where light leaves a translucent object: how many lights it is connected to, and what reaches them."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import lobe
from nephrite.plugins.media import Media

_MOST_CONNECTIONS = 4


def connection_count(scene: Any) -> int:
    """Return how many lights each point is connected to.

    With one per emitter it is no matter of luck which emitter is tried.
    """
    return max(1, min(len(scene.emitters()), _MOST_CONNECTIONS))


def toward(
    media: Media, number: Any, normal: Any, direction: Any, to_light: Any, events: Any, g: Any, drift: Any, landed: Any
) -> tuple[Any, Any]:  # fmt: skip
    """Return the lobe that the light which leaves material `number` has in the direction `to_light`, and its density.

    `direction`: where the path leaves; `events`: how often it has scattered, which tells how much of its direction it
    remembers (see `nephrite.bssrdf.lobe`); `drift`: how far it has come over how long it was; `landed`: jumps, which
    remember nothing.
    """
    eta, normalization = media.lookup(media.eta, number), media.lookup(media.normalization, number)
    cosine = dr.dot(to_light, normal)
    fresnel: Any = mi.fresnel
    pdf = lobe.pdf(cosine, fresnel(dr.maximum(cosine, 0), eta)[0], normalization)
    linear, quadratic = lobe.memory(events, g)
    m2, m4 = media.lookup(media.m2, number), media.lookup(media.m4, number)
    usual = lobe.usual(drift, eta, m2)
    remembered = lobe.kernel(direction, to_light, normal, m2, m4, linear, quadratic, usual)
    return mi.Spectrum(pdf * dr.select(landed, 1, remembered)), pdf


def leave(normal: Any, eta: Any, normalization: Any, u: Any) -> tuple[Any, Any]:
    """Choose a direction around `normal` by two uniform numbers; return it, and the lobe over the density there."""
    local = mi.warp.square_to_cosine_hemisphere(u)
    cosine = dr.maximum(local.z, 1e-6)
    fresnel: Any = mi.fresnel
    out = lobe.pdf(cosine, fresnel(cosine, eta)[0], normalization)
    return mi.Frame3f(normal).to_world(local), out / mi.warp.square_to_cosine_hemisphere_pdf(local)


def light_density(scene: Any, p: Any, si: Any, active: Any) -> Any:
    """Density per solid angle at `p` with which one connection finds the emitter that `si` lies on."""
    here: Any = dr.zeros(mi.Interaction3f)
    here.p = p
    return scene.pdf_emitter_direction(here, mi.DirectionSample3f(scene, si, here), active)


def unblocked(scene: Any, at: Any, ds: Any, value: Any, active: Any) -> Any:
    """Return `value`, what the light sampled by `ds` would bring to `at`, or 0 where something is in the way.

    A shadow ray is traced only where there is something to bring: about half of what a sky is sampled by is below the
    horizon.
    """
    wanted = active & (ds.pdf > 0) & dr.any(value != 0)
    lit = wanted & ~scene.ray_test(at.spawn_ray_to(ds.p), wanted)
    return dr.select(lit, value, 0)


def found_by(own: Any, other: Any) -> Any:
    """Weight of a light that one way of two has found, by their densities: the balance heuristic."""
    return dr.select(own > 0, own / (own + other), 0)
