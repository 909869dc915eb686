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
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.plugins import gathered, walked
from nephrite.plugins.layout import at_nodes, free_paths, lay
from nephrite.plugins.lookup import Lookup
from nephrite.plugins.seen import seen
from nephrite.plugins.settings import NO_LIMIT
from nephrite.transport.counted import Walks, joined
from nephrite.transport.grids import Grids
from nephrite.transport.limit import limit
from nephrite.transport.pyramid import Pyramid

CONNECTIONS = 64  # to lights, per node
ROUNDS, PATHS_IN_TURN = 4, 2  # of light between surfaces, after the first; paths per node
PATHS, MOST_PATHS = 8, 64  # of the last round, which is finer: for a million walks, and at most
_AT_ONCE = 1 << 20  # walks
_UNSEEN = 0.3  # of the mean share of walks: what begins where no camera looks
_SEEDS = 1 << 10  # that a render has for itself: more than walks are made in turns


@dataclass
class Surface:
    """One translucent shape: its nodes, outward normals and their spacing, and what walks carry between the nodes.

    `lost`: share of the light that other objects inside took; `counting`: what is carried, or will be.
    """

    points: NDArray
    normals: NDArray
    spacing: float
    lost: float
    counting: Future[Pyramid]

    @property
    def operator(self) -> Pyramid:
        """What is carried, once that has been counted."""
        return self.counting.result()


def shared(walks: int, shown: NDArray) -> NDArray:
    """Return how many of about `walks` walks begin at each node, if so much of a picture is `shown` there.

    By the root of it, for the least noise in the picture, and some everywhere: light comes from all sides, and cameras
    move.
    """
    share = np.sqrt(shown)
    share += _UNSEEN * np.mean(share) or 1.0
    return np.maximum(np.rint(walks * share / np.sum(share)), 1).astype(np.int64)


class Transport:
    """All surfaces of a scene whose transport is precomputed: T is found at once, V by `relight`."""

    def __init__(
        self,
        scene: Any,
        members: list[tuple[Any, Any]],
        walks: int,
        seed: int = 0,
        sensor: Any = None,
        relative: bool = True,
    ) -> None:
        """Lay nodes on `members`, pairs of `entry.Entry` and shape, and start about `walks` walks on each shape.

        More of them where `sensor` looks, if there is one. `relative`: the operators find V / P, otherwise V alone.
        """
        self.walks, self._seed, self._relative = walks, _SEEDS * seed % 2**32, relative
        layouts = [lay(entry, shape, scene) for entry, shape in members]
        self.lookup = Lookup(members, layouts)
        shown = np.zeros(len(self.lookup.points))
        if sensor is not None:
            shown = seen(scene, sensor, self.lookup, seed)
        self.surfaces: list[Surface] = []
        beside = ThreadPoolExecutor(1)  # NumPy works there while kernels run, or are compiled
        for number, ((entry, shape), (*_, spacing)) in enumerate(zip(members, layouts, strict=True)):
            begun = shared(walks, shown[self.lookup.own(number)])
            self.surfaces.append(self._walk(scene, entry, shape, number, spacing, begun, beside))
        beside.shutdown(wait=False)
        self._values = dr.zeros(mi.Float, 12 * len(self.lookup.points))

    def _walk(
        self, scene: Any, entry: Any, shape: Any, number: int, spacing: float, begun: NDArray, beside: Executor
    ) -> Surface:  # fmt: skip
        own = self.lookup.own(number)
        points, normals = self.lookup.points[own], self.lookup.normals[own]
        grids = beside.submit(Grids.over, points, normals, spacing)
        at = at_nodes(points, normals)
        starts = np.repeat(np.arange(len(points), dtype=np.uint32), begun)
        parts: list[Walks] = []
        second, lost = np.zeros((len(points), 1)), 0.0
        for turn, start in enumerate(np.array_split(starts, -(-len(starts) // _AT_ONCE))):
            ends = walked.walk(scene, self._seed + turn, entry, at, shape, mi.UInt32(start))
            parts.append(self._between_nodes(ends, number, start))
            twice = [np.bincount(start, channel, len(points)) for channel in np.array(ends.twice)]
            second = second + np.stack(twice, axis=1) / begun[:, None]
            lost += float(np.sum(np.array(dr.max(ends.lost)) / begun[start])) / len(points)
        free, shares = float(free_paths(entry).min()), second if self._relative else None
        counting = beside.submit(lambda: Pyramid.of(grids.result(), free, joined(parts), begun, shares))
        return Surface(points, normals, spacing, lost, counting)

    def _between_nodes(self, ends: walked.Ends, number: int, start: NDArray) -> Walks:
        """Return the walks that brought something, from node to node of a surface; they began at `start`."""
        own = self.lookup.own(number)
        used: Any = dr.compress(dr.max(ends.weight) > 0)
        begun = dr.gather(mi.UInt32, mi.UInt32(start), used)
        columns: list[Any] = [ends.p, ends.n, ends.weight, ends.back, ends.out]
        p, n, weight, back, out = (dr.gather(type(values), values, used) for values in columns)
        everywhere = dr.full(mi.Bool, True, dr.width(used))
        end = self.lookup.nearby.nearest(mi.UInt32(number), p, n, everywhere) - own.start
        length = dr.norm(p - dr.gather(mi.Point3f, self.lookup.at.p, begun + own.start))
        dr.eval(begun, end, length, weight, back, out)
        return Walks(*(np.array(values) for values in (begun, end, length, weight, back, out)))

    def relight(self, settings: Any, scene: Any, media: Any) -> None:
        """Find what arrives from the present lights, and what comes of it; `media` looks it up here."""
        s = copy.copy(settings)
        s.hide_emitters = s.reduced = s.single = s.multiple = True
        s.max_depth = s.max_depth if s.max_depth == NO_LIMIT else s.max_depth - 1
        at, sensitivity = self.lookup.at, self.lookup.sensitivity
        connected = gathered.direct(scene, at, sensitivity, CONNECTIONS, self._seed)

        def next_round(before: NDArray, paths: int, seed: int) -> NDArray:
            self._put(before)
            found = gathered.indirect(s, scene, media, at, sensitivity, paths, seed)
            return self._carry([a + b for a, b in zip(connected, found, strict=True)])

        # the same random numbers in each round: what it makes of the one before is linear. The first, of objects that
        # are still dark, is traced while walks are counted
        rounds = [next_round(np.zeros((len(self.lookup.points), 4, 3)), PATHS_IN_TURN, self._seed + 1)]
        for _ in range(ROUNDS):
            rounds.append(next_round(rounds[-1], PATHS_IN_TURN, self._seed + 1))
        paths = min(max(PATHS * self.walks // 1_000_000, PATHS), MOST_PATHS)
        self._put(next_round(limit(rounds), paths, self._seed + 2))

    def _carry(self, arriving: list[Any]) -> NDArray:
        """Return V / P at all nodes, [nodes, 4, channels], for what arrives there."""
        given = np.stack([np.array(one).T for one in arriving], axis=1)
        return np.concatenate(
            [surface.operator.apply(given[self.lookup.own(i)]) for i, surface in enumerate(self.surfaces)]
        )

    def _put(self, values: NDArray) -> None:
        three = np.broadcast_to(values, (*values.shape[:2], 3))  # a monochromatic variant has one channel
        self._values = mi.Float(three.astype(np.float32).ravel())

    def radiance(self, si: Any, normal: Any, direction: Any, u: Any, active: Any) -> tuple[Any, Any]:
        """Return V / P at entries `si`, with outward `normal`, of paths that came from `direction`.

        In the mean over two uniform numbers `u`. And what a half-space keeps of it after one event, per albedo.
        """
        which = self.lookup.number(si.shape, active)
        node = self.lookup.nearby.beside(which, si.p, normal, u, active)
        brought, *moments = (dr.gather(mi.Vector3f, self._values, 4 * node + i, active) for i in range(4))
        tangential = direction - normal * dr.dot(direction, normal)
        for moment, component in zip(moments, tangential, strict=True):
            brought += component * moment
        return mi.Spectrum(brought.x if mi.is_monochromatic else brought), self.lookup.kept(
            which, dr.dot(direction, normal)
        )
