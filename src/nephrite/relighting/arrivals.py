"""What one lamp sends to nodes, stations and pixels: sums over samples, taken a few at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.plugins.lookup import Lookup
from nephrite.relighting.samples import Sequence, along
from nephrite.relighting.stage import Lamp
from nephrite.relighting.surroundings import Open, Surroundings
from nephrite.relighting.view import View

FOR_NODE, FOR_STATION = 2, 4  # samples a turn


@dataclass
class Arrived:
    """What has arrived, [channels, points] each, of which `nodes` is [channels, 4, nodes]: see `surroundings`.

    `plain`: at nodes, as the lobe sees it without preference for steep light; `stations`: irradiance / pi; `points`:
    radiance sent to the camera, per albedo; `picture`: lamps seen.
    """

    nodes: NDArray
    plain: NDArray
    stations: NDArray
    points: NDArray
    picture: NDArray

    def __add__(self, other: Arrived) -> Arrived:
        """Return the sum of two lamps, or turns."""
        return Arrived(*(a + b for a, b in zip(vars(self).values(), vars(other).values(), strict=True)))

    def __mul__(self, factor: float) -> Arrived:
        """Return a multiple."""
        return Arrived(*(value * np.float32(factor) for value in vars(self).values()))


class Gather:
    """Collects arrivals at the points of a scene and a view."""

    def __init__(self, solid: Any, lookup: Lookup, surroundings: Surroundings, view: View) -> None:
        """Lay out the samples."""
        self._solid, self._lookup, self._surroundings, self._view = solid, lookup, surroundings, view
        self._on_nodes = along(len(lookup.points))
        self._on_stations: Sequence = along(surroundings.count)
        which = lookup.which
        self._eta = dr.gather(mi.Float, lookup.eta, which)
        self._normalization = dr.gather(mi.Float, lookup.normalization, which)
        dr.eval(self._eta, self._normalization)

    def turn(self, lamp: Lamp, turn: int) -> Arrived:
        """Return what the samples of one turn bring."""
        found = [
            *self._nodes(lamp, turn),
            self._stations(lamp, turn),
            self._points(lamp, turn),
            self._picture(lamp),
        ]
        dr.eval(found)
        arrays = [np.array(one) for one in found]
        if self._surroundings.open is not None:
            reflected = np.array(_along(lamp, self._surroundings.open, len(self._lookup.points)))
            arrays[0], arrays[4] = arrays[0] + reflected, arrays[4] + reflected
        return Arrived(np.stack(arrays[:4], axis=1), *arrays[4:])

    def _nodes(self, lamp: Lamp, turn: int) -> list[Any]:
        """Return `nodes`, as a mean and three moments, and `plain`."""
        at, lookup = self._lookup.at, self._lookup
        node = dr.arange(mi.UInt32, len(lookup.points))
        n = mi.Vector3f(at.n)
        sums = [mi.Spectrum(0) for _ in range(4)]
        plain = mi.Spectrum(0)
        fresnel: Any = mi.fresnel
        for i in range(FOR_NODE):
            d, light = lamp.sent(self._solid, at, self._on_nodes(FOR_NODE * turn + i))
            cosine = dr.maximum(dr.dot(d, n), 0)
            light = light * (cosine / FOR_NODE)
            through = 1 - fresnel(cosine, self._eta)[0]
            deep = lookup.sensitivity(node, cosine) * light
            tangential = d - n * cosine
            for j, factor in enumerate((mi.Float(1), *tangential)):
                sums[j] += deep * factor
            plain += light * (dr.inv_pi * through / self._normalization)
        return [*sums, plain]

    def _stations(self, lamp: Lamp, turn: int) -> Any:
        total = mi.Spectrum(0)
        if self._surroundings.count:
            at = self._surroundings.at
            for i in range(FOR_STATION):
                d, light = lamp.sent(self._solid, at, self._on_stations(FOR_STATION * turn + i))
                total += light * (dr.maximum(dr.dot(d, at.sh_frame.n), 0) * dr.inv_pi / FOR_STATION)
        return total

    def _points(self, lamp: Lamp, turn: int) -> Any:
        view = self._view
        if view.at is None:
            return mi.Spectrum(0)
        d, light = lamp.sent(self._solid, view.at, view.sequence(turn))
        return light * view.at.bsdf().eval(mi.BSDFContext(), view.at, view.at.to_local(d)) * view.inverse

    def _picture(self, lamp: Lamp) -> Any:
        return _along(lamp, self._view.open, self._view.pixels)


def _along(lamp: Lamp, rays: Open, count: int) -> Any:
    """Return what comes from a lamp itself along rays, summed over those of each of `count` owners."""
    total = dr.zeros(mi.Spectrum, count)
    dr.scatter_add(total, rays.weight * lamp.seen(rays.ray), rays.owner)
    return total
