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
        parts = []
        for part in (self._nodes, self._stations, self._points, self._picture, self._reflected):
            parts.append(part(lamp, turn))
            dr.eval(parts[-1])  # it runs while the next one is being put together
        nodes, *others, reflected = parts
        if reflected is not None:
            nodes[0] += reflected
            nodes[4] += reflected
            dr.eval(nodes)
        mean = [_array(sums) for sums in nodes]
        return Arrived(np.stack(mean[:4], axis=1), mean[4], *(_array(one) for one in others))

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

    def _picture(self, lamp: Lamp, _: int) -> Any:
        return _along(lamp, self._view.open, self._view.pixels)

    def _reflected(self, lamp: Lamp, _: int) -> Any:
        """Return what nodes get by reflections in objects, or None."""
        rays = self._surroundings.open
        return None if rays is None else _along(lamp, rays, len(self._lookup.points))


def _array(channels: Any) -> NDArray:
    """Return an array of channels, [channels, points]."""
    return np.stack([np.broadcast_to(channel.numpy(), dr.width(channels)) for channel in channels])


def _along(lamp: Lamp, rays: Open, count: int) -> Any:
    """Return what comes from a lamp itself along rays, summed over those of each of `count` owners."""
    total = dr.zeros(mi.Spectrum, count)
    dr.scatter_add(total, rays.weight * lamp.seen(rays.ray), rays.owner)
    return total
