"""Guiding: some of a walk's first turns are drawn toward the lamps, and weigh less for it.

Light from behind comes through thin parts by few events, and what turns toward it brings most of it. The density of a
turn is that of the phase function and of lobes around the lamps together (multiple importance sampling of one sample),
so that none weighs more than 1 / (1 - `SHARE`).
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.physics import phase

EVENTS = 4  # that are guided: after more of them, what is gained in thin parts is lost again
THIN = 8.0  # mean free paths from the entry to the far side: in thicker parts walks gain nothing
SHARE = 0.2  # of the turns
_LOBE = 0.5  # mean cosine, as surfaces bend what lamps send


def turn(
    lamps: list[tuple[Any, Any]], p: Any, d: Any, g: Any, u: list[Any], sampler: Any, active: Any
) -> tuple[Any, Any]:  # fmt: skip
    """Return where a path goes on that scatters at `p` on its way in the direction `d`, and what that is worth.

    `lamps`: spheres around them (`glints.lamps`); `u`: two uniform numbers. Only what is `active` is guided.
    """
    turned = _around(d, u, g)
    if not lamps:
        return turned, mi.Float(1)
    lot = sampler.next_1d(active)
    towards = [dr.normalize(centre - dr.select(active, p, 0)) for centre, _ in lamps]
    chosen = towards[0]
    for i, toward in enumerate(towards[1:], start=1):
        chosen = dr.select(lot * len(lamps) >= i * SHARE, toward, chosen)
    turned = dr.select(active & (lot < SHARE), _around(chosen, u, mi.Float(_LOBE)), turned)
    by_phase = phase.eval(dr.dot(d, turned), g)
    by_lamps = sum(phase.eval(dr.dot(toward, turned), mi.Float(_LOBE)) for toward in towards) / len(lamps)
    return turned, dr.select(active, by_phase / ((1 - SHARE) * by_phase + SHARE * by_lamps), 1)


def _around(direction: Any, u: list[Any], g: Any) -> Any:
    x, y, z = phase.sample(u[0], u[1], g)
    return mi.Frame3f(direction).to_world(mi.Vector3f(x, y, z))
