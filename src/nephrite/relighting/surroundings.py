"""How light goes from surface to surface, whatever the lights: found once for a scene, by rays from all of them.

Stations are points on the other surfaces, where light from the objects' nodes gets to; these surfaces are taken to be
diffuse there. Directions: a node's `Lambda` is what arrives as the exit lobe sees it (see `plugins.transport`); `X` is
what it sends out, per transmittance of the surface; a station's radiance is what it sends out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import KDTree

from nephrite.plugins import interface

STATIONS = 8192
FROM_NODES, FROM_STATIONS, FROM_PIXELS = 16, 64, 16  # rays from each


def faced(si: Any) -> Any:
    """Return interactions whose normals are on the side that has been hit."""
    side = dr.sign(si.wi.z)
    si.n, si.sh_frame = mi.Normal3f(si.n * side), mi.Frame3f(si.sh_frame.n * side)
    return si


@dataclass
class Seen:
    """What points see by their rays: matrices to the points from nodes (of X), and from stations (of radiance)."""

    nodes: Any
    stations: Any


class Surroundings:
    """Stations and what is seen of nodes and stations.

    `from_nodes`: what nodes see, as the exit lobe does; `from_stations`: what stations see, as a mean of radiance.
    """

    def __init__(self, solid: Any, lookup: Any, members: list[tuple[Any, Any]]) -> None:
        """Shoot the rays."""
        self._solid, self._lookup = solid, lookup
        sent = self._shoot(
            lookup.at, FROM_NODES, 1, lambda node, cosine: dr.pi * lookup.sensitivity(node, cosine)
        )
        opaque = np.flatnonzero(np.array(sent[0].opaque))
        chosen = np.random.default_rng(1).permutation(opaque)[:STATIONS]
        self.at: Any = None
        self.albedo = np.zeros((0, 3), np.float32)
        if len(chosen):
            self.at = dr.gather(type(sent[0].si), sent[0].si, mi.UInt32(np.sort(chosen)))
            self.albedo = self.reflectance(self.at)
            self.at = faced(self.at)
        self.count = len(chosen)
        self._tree = KDTree(np.array(self.at.p).T) if self.count else None
        self.from_nodes = self._seen(sent, len(lookup.points))
        self.open = _reflections(sent[1] if len(sent) > 1 else None)
        self.from_stations = self.seen(self.at, FROM_STATIONS, 2) if self.count else self._nothing(0)

    @staticmethod
    def reflectance(si: Any) -> NDArray[np.float32]:
        """Return the diffuse reflectance at interactions, [n, 3], on the side that has been hit."""
        bsdf = si.bsdf()
        lit = (si.wi.z > 0) | mi.has_flag(bsdf.flags(), mi.BSDFFlags.BackSide)
        return np.array(dr.select(lit, bsdf.eval_diffuse_reflectance(si), 0)).T.astype(np.float32)

    def seen(self, at: Any, count: int, seed: int) -> Seen:
        """Return what points of other surfaces see: means over the hemisphere, by the cosine."""
        sent = self._shoot(at, count, seed, lambda *_: mi.Float(1))
        return self._seen(sent, dr.width(at.p))

    def nearest(self, points: NDArray) -> NDArray:
        """Return the stations nearest to points."""
        return (
            np.asarray(self._tree.query(points, workers=-1)[1]) if self._tree else np.zeros(len(points), int)
        )

    def _nothing(self, rows: int) -> Seen:
        return Seen(
            sparse.csr_matrix((rows, len(self._lookup.points)), dtype=np.float32),
            sparse.csr_matrix((rows, self.count), dtype=np.float32),
        )

    def _shoot(self, at: Any, count: int, seed: int, weigh: Any) -> tuple[_Sent, ...]:
        """Shoot `count` rays from each point; return what they hit, and what their reflections in objects do."""
        width = dr.width(at.p)
        origin = dr.arange(mi.UInt32, width * count) // count
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, width * count)
        here = dr.gather(type(at), at, origin)
        local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        weight = dr.zeros(mi.Float, width * count) + weigh(origin, local.z) / count
        ray = here.spawn_ray(mi.Frame3f(here.sh_frame.n).to_world(local))
        first = self._hit(ray, origin, weight)
        reflecting = mi.UInt32(np.flatnonzero(np.array(first.hits)))
        if not dr.width(reflecting):
            return (first,)
        si = dr.gather(type(first.si), first.si, reflecting)
        eta = dr.gather(mi.Float, self._lookup.eta, self._lookup.number(si.shape, mi.Bool(True)))
        x = interface.cross(si, -si.to_world(si.wi), eta)
        origin, weight = (dr.gather(type(v), v, reflecting) for v in (origin, weight))
        return first, self._hit(si.spawn_ray(x.reflected), origin, weight * x.reflectance)

    def _hit(self, ray: Any, origin: Any, weight: Any) -> _Sent:
        si = self._solid.ray_intersect(ray)
        hits, X = self.sent(si, si.is_valid())
        found = _Sent(ray, si, origin, weight, hits, si.is_valid() & ~hits, X)
        dr.eval(ray, si, origin, weight, hits, found.opaque, X)
        return found

    def sent(self, si: Any, active: Any) -> tuple[Any, Any]:
        """Return where interactions lie on nodes' surfaces, and the share of X that leaves there towards them."""
        lookup = self._lookup
        hits = active & lookup.known(si.shape)
        which = lookup.number(si.shape, hits)
        cosine = dr.abs(dr.dot(si.wi, mi.Vector3f(0, 0, 1)))
        fresnel: Any = mi.fresnel
        through = 1 - fresnel(cosine, dr.gather(mi.Float, lookup.eta, which, hits))[0]
        return hits, dr.select(hits, through * lookup.depth(which, cosine), 0)

    def node(self, si: Any, active: Any) -> Any:
        """Return the nodes nearest to interactions."""
        which = self._lookup.number(si.shape, active)
        normal = dr.mulsign(mi.Vector3f(si.n), dr.dot(si.n, si.to_world(si.wi)))
        return self._lookup.nearby.nearest(which, si.p, normal, active)

    def _seen(self, parts: tuple[_Sent, ...], rows: int) -> Seen:
        found = self._nothing(rows)
        for sent in parts:
            origin, weight = np.array(sent.origin), np.array(sent.weight)
            hits = np.flatnonzero(np.array(sent.hits))
            if len(hits):
                node = np.array(self.node(sent.si, sent.hits))[hits]
                value = weight[hits] * np.array(sent.X)[hits]
                found.nodes += sparse.csr_matrix((value, (origin[hits], node)), shape=found.nodes.shape)
            opaque = np.flatnonzero(np.array(sent.opaque))
            if self.count and len(opaque):
                station = self.nearest(np.array(sent.si.p).T[opaque])
                found.stations += sparse.csr_matrix(
                    (weight[opaque], (origin[opaque], station)), shape=found.stations.shape
                )
        return found


@dataclass
class _Sent:
    """Rays that have been shot: where they have hit, from which points; `X`: share of a node's X that they see."""

    ray: Any
    si: Any
    origin: Any
    weight: Any
    hits: Any
    opaque: Any
    X: Any


@dataclass
class Open:
    """Rays on which lamps may be seen, until where something solid is: whose they are, and the weight of each."""

    ray: Any
    owner: Any
    weight: Any


def _reflections(sent: _Sent | None) -> Open | None:
    """Return the rays on which nodes see lamps reflected in objects."""
    if sent is None:
        return None
    ray = mi.Ray3f(sent.ray)
    ray.maxt = dr.select(sent.si.is_valid(), sent.si.t, dr.largest(mi.Float))
    found = Open(ray, sent.origin, mi.Spectrum(sent.weight))
    dr.eval(found.ray, found.owner, found.weight)
    return found


def interreflection(sent: list[NDArray], again: list[NDArray]) -> list[NDArray]:
    """Return, for each channel, what arrives after one or more further surfaces, of what arrives at first.

    `sent`: X of what arrives, M, between cells; `again`: what arrives of X, B. It is B M / (1 - B M).
    """
    found = []
    for M, B in zip(sent, again, strict=True):
        once = B @ M
        found.append(np.linalg.solve(np.eye(len(M)) - once, once).astype(np.float32))
    return found
