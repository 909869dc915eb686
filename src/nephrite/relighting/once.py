"""Light that has been scattered once under a surface: where what nodes send out comes from.

It comes from nearby, or through thin parts, and depends on the direction more than multiple scattering does. Paths
from the nodes tell how much of it comes from which other nodes.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.physics import phase
from nephrite.plugins import channels, interface
from nephrite.plugins.lookup import Lookup
from nephrite.relighting.matrices import of_entries

PATHS = 48  # from a node
_SEGMENTS = 3  # of a path after the event; reflected inside at their ends


def scattered_once(
    solid: Any, lookup: Lookup, members: list[tuple[Any, Any]], seen: NDArray, toward: NDArray | None = None
) -> list[Any]:
    """Return matrices, one a channel, [nodes, nodes]: what the `seen` nodes send out, of what arrives at nodes.

    Both per transmittance of the surface, and the latter as the exit lobe sees it. `toward`: unit directions outside,
    one a node; without, it is the mean that the exit lobe sends out.
    """
    count = PATHS if toward is not None else PATHS // 3
    width = len(seen) * count
    lane = dr.arange(mi.UInt32, width)
    node = dr.gather(mi.UInt32, mi.UInt32(seen), lane // count)
    here = dr.gather(type(lookup.at), lookup.at, node)
    which = dr.gather(mi.UInt32, lookup.which, node)
    eta = dr.gather(mi.Float, lookup.eta, which)
    coefficients = [entry.mean_coefficients() for entry, _ in members]
    g = dr.gather(mi.Float, mi.Float([float(entry.g) for entry, _ in members]), which)
    sigma_s = _gathered([s for _, s in coefficients], which)
    sigma_t = _gathered([a + s for a, s in coefficients], which)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(4, width)

    entered = mi.Float(1)
    if toward is not None:
        inward = interface.cross(here, -dr.gather(mi.Vector3f, mi.Vector3f(toward.T), node), eta)
    else:
        local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        inward = interface.cross(here, -here.sh_frame.to_world(local), eta)
        entered = (1 - inward.reflectance) / dr.gather(mi.Float, lookup.normalization, which)
    ray = here.spawn_ray(inward.refracted)
    until = dr.minimum(solid.ray_intersect(ray).t, 1e30)
    chance = 1 - dr.exp(-sigma_t * until)
    leader = lane % len(sigma_t)
    distance = -dr.log(1 - sampler.next_1d() * channels.pick(chance, leader)) / channels.pick(sigma_t, leader)
    along = dr.exp(-sigma_t * distance)
    density = dr.mean(sigma_t * along / dr.maximum(chance, 1e-12))
    weight = entered * sigma_s * along / (density * count)
    u = sampler.next_2d()
    ray = mi.Ray3f(ray(distance), mi.Frame3f(ray.d).to_world(mi.Vector3f(*phase.sample(u.x, u.y, g))))
    entries = []
    for _ in range(_SEGMENTS):
        si = solid.ray_intersect(ray)
        inside = si.is_valid() & lookup.known(si.shape) & (lookup.number(si.shape, si.is_valid()) == which)
        x = interface.cross(si, ray.d, dr.rcp(eta))
        weight = dr.select(inside, weight * dr.exp(-sigma_t * si.t), 0)
        there = lookup.nearby.nearest(which, si.p, -x.normal, inside)
        leaves = weight * (1 - x.reflectance)
        weight *= x.reflectance
        ray = si.spawn_ray(x.reflected)
        dr.eval(there, leaves, weight, ray)
        kept = np.flatnonzero(np.array(dr.max(leaves) > 0))
        entries.append((np.array(node)[kept], np.array(there)[kept], np.array(leaves).T[kept]))
    return of_entries(entries, (len(lookup.points), len(lookup.points)))


def _gathered(rows: list[NDArray], which: Any) -> Any:
    """Return a spectrum for each lane, of one for each surface."""
    return mi.Spectrum(
        *[
            dr.gather(mi.Float, mi.Float(list(map(float, column))), which)
            for column in zip(*rows, strict=True)
        ]
    )
