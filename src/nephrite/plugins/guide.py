"""Guiding: some of a walk's first turns are drawn toward the lamps or the way out, and weigh less for it.

Light from behind comes through thin parts by few events, and what turns toward it brings most of it. Of what is to
leave after one event, total reflection keeps all in that doesn't turn into a narrow cone around the surface's normal.
The density of a turn is that of the phase function, of lobes around the lamps and of that cone together (multiple
importance sampling of one sample), so that none weighs more than 1 / (1 - `SHARE` - `OUT`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.physics import phase
from nephrite.plugins.media import Media

EVENTS = 4  # that are guided: after more of them, what is gained in thin parts is lost again
THIN = 8.0  # mean free paths from the entry to the far side: in thicker parts walks gain nothing
SHARE = 0.2  # of the turns: toward lamps
OUT = 0.15  # of the turns: into the cone, where single scattering is all that walks are for
_LOBE = 0.5  # mean cosine, as surfaces bend what lamps send


@dataclass
class Cone:
    """Directions that a flat surface lets out: those nearer to its outward `normal` than the `cosine` says.

    `active`: whose turns may be drawn from it.
    """

    normal: Any
    cosine: Any
    active: Any

    @staticmethod
    def of(normal: Any, eta: Any, active: Any) -> Cone:
        """Return the cone for the index of refraction of the inside over the outside."""
        return Cone(normal, dr.sqrt(1 - dr.rcp(dr.square(dr.maximum(eta, 1)))), active)

    def sample(self, u: list[Any]) -> Any:
        """Map two uniform numbers evenly to the directions in it."""
        z = dr.lerp(1, self.cosine, u[0])
        sine, cosine = dr.sincos(dr.two_pi * u[1])
        radius = dr.safe_sqrt(1 - dr.square(z))
        return mi.Frame3f(self.normal).to_world(mi.Vector3f(radius * cosine, radius * sine, z))

    def pdf(self, direction: Any) -> Any:
        """Return the density per solid angle (1/sr) of `sample`."""
        inside = dr.dot(direction, self.normal) >= self.cosine
        return dr.select(inside, dr.inv_two_pi / dr.maximum(1 - self.cosine, 1e-6), 0)


def way_out(media: Media, number: Any, normal: Any, active: Any) -> Cone | None:
    """Return the cone of material `number` at a surface, for those whose walks are to scatter once; None without any.

    `normal`: outward.
    """
    if not media.any_low:
        return None
    return Cone.of(normal, media.lookup(media.eta, number), active & media.low(number))


def turn(
    lamps: list[tuple[Any, Any]], p: Any, d: Any, g: Any, u: list[Any], sampler: Any, active: Any,
    out: Cone | None = None,
) -> tuple[Any, Any]:  # fmt: skip
    """Return where a path goes on that scatters at `p` on its way in the direction `d`, and what that is worth.

    `lamps`: spheres around them (`glints.lamps`); `u`: two uniform numbers. Only what is `active` is guided.
    """
    turned = _around(d, u, g)
    if not lamps and out is None:
        return turned, mi.Float(1)
    lot = sampler.next_1d(active)
    towards = [dr.normalize(centre - dr.select(active, p, 0)) for centre, _ in lamps]
    if lamps:
        chosen = towards[0]
        for i, toward in enumerate(towards[1:], start=1):
            chosen = dr.select(lot * len(lamps) >= i * SHARE, toward, chosen)
        turned = dr.select(active & (lot < SHARE), _around(chosen, u, mi.Float(_LOBE)), turned)
    if out is not None:
        turned = dr.select(out.active & (lot >= 1 - OUT), out.sample(u), turned)
    by_phase = phase.eval(dr.dot(d, turned), g)
    density = mi.Float(by_phase)
    if lamps:
        by_lamps = sum(phase.eval(dr.dot(toward, turned), mi.Float(_LOBE)) for toward in towards) / len(lamps)
        density += SHARE * (by_lamps - by_phase)
    if out is not None:
        density += dr.select(out.active, OUT * (out.pdf(turned) - by_phase), 0)
    return turned, dr.select(active, by_phase / density, 1)


def _around(direction: Any, u: list[Any], g: Any) -> Any:
    x, y, z = phase.sample(u[0], u[1], g)
    return mi.Frame3f(direction).to_world(mi.Vector3f(x, y, z))
