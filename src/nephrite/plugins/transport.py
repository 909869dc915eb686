"""Precomputed transport: what walks carry through the objects of a scene, kept, and looked up where paths enter.

A path that enters at x and scatters at least twice brings on average `V(x) = sum_y T(x, y) Λ(y)`: Λ(y) is what arrives
at y from outside, as the exit lobe sees it; T what walks carry from x to y. T does not depend on the lights, so that
it is kept when they move. Both Λ and V have first moments in direction besides their means, which bring the linear part
of the lobe's memory (see `nephrite.bssrdf.lobe`) to the light and to the eye.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.plugins import gathered, walked
from nephrite.plugins.layout import at_nodes, free_paths, lay
from nephrite.plugins.lookup import Lookup
from nephrite.plugins.settings import NO_LIMIT
from nephrite.transport.carried import Carried, Walks

CONNECTIONS, PATHS = 64, 8  # per node
ROUNDS = 4  # of light between translucent surfaces
_LANES = 1 << 20


@dataclass
class Surface:
    """One translucent shape: the index of the first of its nodes, their spacing, and what walks carry between them.

    `lost`: share of the light that other objects inside took.
    """

    first: int
    spacing: float
    carried: Carried
    lost: float


class Transport:
    """All surfaces of a scene whose transport is precomputed: T is found at once, V by `relight`."""

    def __init__(self, scene: Any, members: list[tuple[Any, Any]], walks: int) -> None:
        """Lay nodes on `members`, pairs of `media.Entry` and shape, and start about `walks` walks on each shape."""
        layouts = [lay(entry, shape, scene) for entry, shape in members]
        self.lookup = Lookup(members, layouts)
        self.surfaces: list[Surface] = []
        for number, ((entry, shape), (*_, spacing)) in enumerate(zip(members, layouts, strict=True)):
            self.surfaces.append(self._walk(scene, entry, shape, number, spacing, walks))
        self._values = dr.zeros(mi.Float, 12 * len(self.lookup.points))

    def _walk(
        self, scene: Any, entry: Any, shape: Any, number: int, spacing: float, walks: int
    ) -> Surface:  # fmt: skip
        own = self.lookup.own(number)
        first, nodes = own.start, own.stop - own.start
        points, normals = self.lookup.points[own], self.lookup.normals[own]
        each = max(1, walks // nodes)
        found = Carried(points, normals, spacing, float(free_paths(entry).min()), each)
        at, lost = at_nodes(points, normals), 0.0
        sampler = mi.load_dict({"type": "independent"})
        for turn, begun in enumerate(range(0, each, max(1, _LANES // nodes))):
            count = min(max(1, _LANES // nodes), each - begun)
            sampler.seed(turn, nodes * count)
            start = dr.arange(mi.UInt32, nodes * count) // count
            here = dr.gather(type(at), at, start)
            ends = walked.walk(scene, sampler, entry, here, shape)
            dr.eval(ends)
            used = dr.max(ends.weight) > 0
            end = self.lookup.nearby.nearest(mi.UInt32(number), ends.p, ends.n, used) - first
            found.add(Walks(start, end, dr.norm(ends.p - here.p), ends.weight, ends.out, ends.back))
            lost += float(dr.sum(dr.max(ends.lost))[0]) / (nodes * each)
        found.finish()
        return Surface(first, spacing, found, lost)

    def relight(self, settings: Any, scene: Any, media: Any) -> None:
        """Find what arrives from the present lights, and what comes of it; `media` looks it up here."""
        s = copy.copy(settings)
        s.hide_emitters = s.reduced = s.single = s.multiple = True
        s.max_depth = s.max_depth if s.max_depth == NO_LIMIT else s.max_depth - 1
        self._values = dr.zeros(mi.Float, dr.width(self._values))
        connected = gathered.direct(scene, self.lookup.at, self.lookup.sensitivity, CONNECTIONS)
        seen = np.zeros((len(self.lookup.points), 4, 1))
        before = last = np.zeros(())
        for _ in range(ROUNDS):
            found = gathered.indirect(s, scene, media, self.lookup.at, self.lookup.sensitivity, PATHS)
            now = self._carry([a + b for a, b in zip(connected, found, strict=True)])
            before, last, seen = last, now - seen, now
            self._put(seen)
        # the same random numbers in each round make it a geometric series, nearly: here is the rest of it
        ratio = np.abs(last).mean(axis=(0, 1)) / np.maximum(np.abs(before).mean(axis=(0, 1)), 1e-30)
        ratio = np.minimum(ratio, 0.5)
        self._put(seen + last * ratio / (1.0 - ratio))

    def _carry(self, arriving: list[Any]) -> NDArray:
        """Return V at all nodes, [nodes, 4, channels], for what arrives there."""
        found = []
        for surface in self.surfaces:
            own = dr.arange(mi.UInt32, surface.carried.nodes) + surface.first
            found.append(surface.carried.apply([dr.gather(mi.Spectrum, one, own) for one in arriving]))
        return np.concatenate(found)

    def _put(self, values: NDArray) -> None:
        three = np.broadcast_to(values, (*values.shape[:2], 3))  # a monochromatic variant has one channel
        self._values = mi.Float(three.astype(np.float32).ravel())

    def radiance(self, si: Any, normal: Any, direction: Any, active: Any) -> Any:
        """Return V at entries `si`, with outward `normal`, of paths that came from `direction`."""
        which = self.lookup.number(si.shape, active)
        mean, *moments = self.lookup.nearby.mean(which, si.p, normal, self._values, active)
        tangential = direction - normal * dr.dot(direction, normal)
        for moment, component in zip(moments, tangential, strict=True):
            mean += component * moment
        mean = dr.maximum(mean, 0) * self.lookup.depth(which, dr.dot(direction, normal))
        return mi.Spectrum(mean.x) if mi.is_monochromatic else mi.Spectrum(mean)
