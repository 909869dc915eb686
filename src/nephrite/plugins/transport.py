"""Precomputed transport: what walks carry through the objects of a scene, kept, and looked up where paths enter.

Paths that enter at x and scatter at least twice bring on average `V(x) = sum_y T(x, y) Λ(y)`: Λ(y) is what arrives at y
from outside, as the exit lobe sees it; T what walks carry from x to y. T does not depend on the lights, so that it is
kept when they move. How much scatters twice differs in thin parts from direction to direction, and from one place to
the next. So a pixel's path walks to its first event, and what scatters again brings `V(x) / P(x)`, where P is how much
does so of all that enters at x. Both Λ and V have first moments in direction besides their means, which bring the
linear part of the lobe's memory (see `nephrite.bssrdf.lobe`) to the light and to the eye.
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
from nephrite.transport.counted import Walks, joined
from nephrite.transport.limit import limit
from nephrite.transport.pyramid import Pyramid

CONNECTIONS, PATHS = 128, 8  # per node
ROUNDS = 4  # of light between surfaces, after that of the lamps
_LEAST_SECOND = 0.1  # of what scatters twice in the mean of all nodes: below, noise would be divided by it
_AT_ONCE = 1 << 20  # walks
_SEEDS = 1 << 10  # that a render has for itself: more than walks are made in turns


@dataclass
class Surface:
    """One translucent shape: its nodes, outward normals and their spacing, and what walks carry between the nodes.

    `second`: share of the light that scatters twice, [nodes, channels]; `lost`: that which other objects inside took.
    """

    points: NDArray
    normals: NDArray
    spacing: float
    operator: Pyramid
    second: NDArray
    lost: float


class Transport:
    """All surfaces of a scene whose transport is precomputed: T is found at once, V by `relight`."""

    def __init__(self, scene: Any, members: list[tuple[Any, Any]], walks: int, seed: int = 0) -> None:
        """Lay nodes on `members`, pairs of `media.Entry` and shape, and start about `walks` walks on each shape."""
        self.walks, self._seed = walks, _SEEDS * seed % 2**32
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
        points, normals = self.lookup.points[own], self.lookup.normals[own]
        at, each = at_nodes(points, normals), max(1, walks // len(points))
        most = max(1, _AT_ONCE // len(points))
        parts, second, lost = [], 0.0, 0.0
        for turn, begun in enumerate(range(0, each, most)):
            count = len(points) * min(most, each - begun)
            ends = walked.walk(scene, self._seed + turn, entry, at, shape, count)
            parts.append(self._between_nodes(ends, number))
            twice = np.array(ends.twice)
            second += twice.reshape(len(twice), -1, len(points)).sum(axis=1).T / each
            lost += float(np.array(dr.sum(dr.max(ends.lost)))[0]) / (len(points) * each)
        operator = Pyramid.of(points, normals, spacing, float(free_paths(entry).min()), joined(parts), each)
        least = np.maximum(_LEAST_SECOND * np.mean(second, axis=0), 1e-12)  # a channel may not scatter at all
        second = np.maximum(operator.smooth @ second, least)
        return Surface(points, normals, spacing, operator, second, lost)

    def _between_nodes(self, ends: walked.Ends, number: int) -> Walks:
        """Return the walks that brought something, from node to node of a surface."""
        own = self.lookup.own(number)
        used: Any = dr.compress(dr.max(ends.weight) > 0)
        start = used % (own.stop - own.start)
        columns: list[Any] = [ends.p, ends.n, ends.weight, ends.back, ends.out]
        p, n, weight, back, out = (dr.gather(type(values), values, used) for values in columns)
        everywhere = dr.full(mi.Bool, True, dr.width(used))
        end = self.lookup.nearby.nearest(mi.UInt32(number), p, n, everywhere) - own.start
        length = dr.norm(p - dr.gather(mi.Point3f, self.lookup.at.p, start + own.start))
        dr.eval(start, end, length, weight, back, out)
        return Walks(*(np.array(values) for values in (start, end, length, weight, back, out)))

    def relight(self, settings: Any, scene: Any, media: Any) -> None:
        """Find what arrives from the present lights, and what comes of it; `media` looks it up here."""
        s = copy.copy(settings)
        s.hide_emitters = s.reduced = s.single = s.multiple = True
        s.max_depth = s.max_depth if s.max_depth == NO_LIMIT else s.max_depth - 1
        at, sensitivity = self.lookup.at, self.lookup.sensitivity
        connected = gathered.direct(scene, at, sensitivity, CONNECTIONS, self._seed)
        rounds = [self._carry(connected)]
        for _ in range(ROUNDS):  # the same random numbers in each: what it makes of the one before is linear
            self._put(rounds[-1])
            found = gathered.indirect(s, scene, media, at, sensitivity, PATHS, self._seed + 1)
            rounds.append(self._carry([a + b for a, b in zip(connected, found, strict=True)]))
        self._put(limit(rounds))

    def _carry(self, arriving: list[Any]) -> NDArray:
        """Return V at all nodes, [nodes, 4, channels], for what arrives there."""
        given = np.stack([np.array(one).T for one in arriving], axis=1)
        return np.concatenate(
            [surface.operator.apply(given[self.lookup.own(i)]) for i, surface in enumerate(self.surfaces)]
        )

    def _put(self, values: NDArray) -> None:
        values = values / np.concatenate([surface.second for surface in self.surfaces])[:, None]
        three = np.broadcast_to(values, (*values.shape[:2], 3))  # a monochromatic variant has one channel
        self._values = mi.Float(three.astype(np.float32).ravel())

    def radiance(self, si: Any, normal: Any, direction: Any, active: Any) -> tuple[Any, Any]:
        """Return V / P at entries `si`, with outward `normal`, of paths that came from `direction`.

        And what a half-space keeps of their light after one event, per albedo.
        """
        which = self.lookup.number(si.shape, active)
        mean, *moments = self.lookup.nearby.mean(which, si.p, normal, self._values, active)
        tangential = direction - normal * dr.dot(direction, normal)
        for moment, component in zip(moments, tangential, strict=True):
            mean += component * moment
        mean = dr.maximum(mean, 0)
        brought = mi.Spectrum(mean.x) if mi.is_monochromatic else mi.Spectrum(mean)
        return brought, self.lookup.kept(which, dr.dot(direction, normal))
