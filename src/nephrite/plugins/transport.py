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

from nephrite.bssrdf import lobe
from nephrite.physics.single import deep_share
from nephrite.plugins import gathered, walked
from nephrite.plugins.layout import at_nodes, free_paths, lay
from nephrite.plugins.media import identity
from nephrite.plugins.settings import NO_LIMIT
from nephrite.transport.carried import Carried, Walks
from nephrite.transport.nearby import Nearby

REACH = 1.75  # of lookups, in spacings of nodes
CONNECTIONS, PATHS = 64, 8  # per node
ROUNDS = 4  # of light between translucent surfaces
_LANES = 1 << 20
_COSINES = (np.arange(64) + 0.5) / 64


@dataclass
class Surface:
    """One translucent shape: the index of the first of its nodes, and what walks carry between them.

    `lost`: share of the light that other objects inside took.
    """

    first: int
    carried: Carried
    lost: float


class Transport:
    """All surfaces of a scene whose transport is precomputed: T is found at once, V by `relight`."""

    def __init__(self, scene: Any, members: list[tuple[Any, Any]], walks: int) -> None:
        """Lay nodes on `members`, pairs of `media.Entry` and shape, and start about `walks` walks on each shape."""
        layouts = [lay(entry, shape, scene) for entry, shape in members]
        self._nearby = Nearby([(points, normals, REACH * spacing) for points, normals, spacing in layouts])
        self._at = at_nodes(self._nearby.points, self._nearby.normals)
        self.surfaces: list[Surface] = []
        first = 0
        for number, ((entry, shape), (points, _, spacing)) in enumerate(zip(members, layouts, strict=True)):
            self.surfaces.append(self._walk(scene, entry, shape, number, first, len(points), spacing, walks))
            first += len(points)
        counts = [len(points) for points, _, _ in layouts]
        self._which = mi.UInt32(np.repeat(np.arange(len(counts)), counts))
        self._eta = mi.Float([entry.eta for entry, _ in members])
        self._normalization = mi.Float([lobe.exit_lobe(entry.eta).normalization for entry, _ in members])
        self._deep = mi.Float(
            np.concatenate([deep_share(_COSINES, entry.g, entry.eta) for entry, _ in members])
        )
        self._values = dr.zeros(mi.Float, 12 * first)
        self.attach([shape for _, shape in members])

    def attach(self, shapes: list[Any]) -> None:
        """Say which shapes the surfaces are: the same ones have other identities in a scene that is loaded again."""
        ids = [identity(shape) for shape in shapes]
        numbers = np.zeros(max(ids) + 1, np.uint32)
        numbers[ids] = np.arange(len(ids))
        self._number = mi.UInt32(numbers)

    def _walk(
        self, scene: Any, entry: Any, shape: Any, number: int, first: int, nodes: int, spacing: float, walks: int
    ) -> Surface:  # fmt: skip
        own = slice(first, first + nodes)
        points, normals = self._nearby.points[own], self._nearby.normals[own]
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
            end = self._nearby.nearest(mi.UInt32(number), ends.p, ends.n, used) - first
            found.add(Walks(start, end, dr.norm(ends.p - here.p), ends.weight, ends.out, ends.back))
            lost += float(dr.sum(dr.max(ends.lost))[0]) / (nodes * each)
        found.finish()
        return Surface(first, found, lost)

    def relight(self, settings: Any, scene: Any, media: Any) -> None:
        """Find what arrives from the present lights, and what comes of it; `media` looks it up here."""
        s = copy.copy(settings)
        s.hide_emitters = s.reduced = s.single = s.multiple = True
        s.max_depth = s.max_depth if s.max_depth == NO_LIMIT else s.max_depth - 1
        self._values = dr.zeros(mi.Float, dr.width(self._values))
        connected = gathered.direct(scene, self._at, self._sensitivity, CONNECTIONS)
        seen = np.zeros((dr.width(self._at.p), 4, 1))
        before = last = np.zeros(())
        for _ in range(ROUNDS):
            found = gathered.indirect(s, scene, media, self._at, self._sensitivity, PATHS)
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

    def _sensitivity(self, node: Any, cosine: Any) -> Any:
        """How much light at an angle counts for multiple scattering, as a density over the projected solid angle."""
        which = dr.gather(mi.UInt32, self._which, node)
        fresnel: Any = mi.fresnel
        through = 1.0 - fresnel(cosine, dr.gather(mi.Float, self._eta, which))[0]
        return (
            dr.inv_pi * through / dr.gather(mi.Float, self._normalization, which) * self._depth(which, cosine)
        )

    def _depth(self, which: Any, cosine: Any) -> Any:
        """Light at this angle that scatters twice, over its mean: `deep_share`, by its table."""
        spot = dr.clip(cosine * len(_COSINES) - 0.5, 0.0, len(_COSINES) - 1.001)
        first = mi.UInt32(spot)
        a, b = (dr.gather(mi.Float, self._deep, which * len(_COSINES) + first + i) for i in range(2))
        return dr.lerp(a, b, spot - first)

    def _put(self, values: NDArray) -> None:
        three = np.broadcast_to(values, (*values.shape[:2], 3))  # a monochromatic variant has one channel
        self._values = mi.Float(three.astype(np.float32).ravel())

    def radiance(self, si: Any, normal: Any, direction: Any, active: Any) -> Any:
        """Return V at entries `si`, with outward `normal`, of paths that came from `direction`."""
        index: Any = dr.reinterpret_array(mi.UInt32, si.shape)
        which = dr.gather(mi.UInt32, self._number, index, active)
        mean, *moments = self._nearby.mean(which, si.p, normal, self._values, active)
        tangential = direction - normal * dr.dot(direction, normal)
        for moment, component in zip(moments, tangential, strict=True):
            mean += component * moment
        mean = dr.maximum(mean, 0) * self._depth(which, dr.dot(direction, normal))
        return mi.Spectrum(mean.x) if mi.is_monochromatic else mi.Spectrum(mean)
