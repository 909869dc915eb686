"""What a camera sees, whatever the lights: first hits, what is reflected in them, and which nodes they look at.

Surfaces of objects show X of their nodes (see `surroundings`) through the interface, and reflect; the little light
that gets through unscattered is followed straight on. What such rays meet is found once; only lamps are looked for
again. All other surfaces show the light that falls on one point a pixel, averaged over neighbouring pixels.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from nephrite.plugins import interface
from nephrite.plugins.lookup import Lookup
from nephrite.relighting.matrices import beside, of_entries
from nephrite.relighting.samples import TILE, Sequence, over_pixels
from nephrite.relighting.surroundings import FROM_PIXELS, Open, Surroundings, faced
from nephrite.transport.nodes import REACH, interpolation

SIDE = 2  # of the square of rays in a pixel
REFLECTIONS = 3
_LEAST = 1e-3  # weight of rays that are followed
_ALIKE = 0.9  # cosine between the normals of neighbouring pixels that are averaged


class View:
    """A camera's picture as matrices and points; see the attributes.

    `nodes`: [pixels, nodes], from X towards the camera; `shown`: one matrix a channel, from the same, and from X and
    stations' radiance as seen in surfaces; `toward`: directions from the nodes to the camera; `open`: rays to lamps.
    `at`: the points of other surfaces, `sequence` their samples, `pixel` where they are, `inverse` and `reflects` of
    their albedo, the latter by what they cover, `mean` the average over neighbours, `seen` what reaches them from nodes
    and stations.
    """

    def __init__(
        self, solid: Any, sensor: Any, lookup: Lookup, surroundings: Surroundings, layouts: Any, media: Any
    ) -> None:
        """Trace the rays of `sensor`."""
        self._solid, self._lookup, self._surroundings = solid, lookup, surroundings
        self.width, self.height = (int(side) for side in sensor.film().crop_size())
        self.pixels = self.width * self.height
        rays, pixel = _rays(sensor, self.width, self.height)
        si = solid.ray_intersect(rays)
        hits, shown = surroundings.sent(si, si.is_valid())
        number = dr.select(si.is_valid(), media.number(si.shape), 0)
        x = interface.cross(si, rays.d, dr.select(hits, media.lookup(media.eta, number), 1.5))
        dr.eval(si, hits, shown, x, number)
        hit = np.flatnonzero(np.array(hits))
        of_pixel = np.array(pixel).astype(np.int64)
        self._open: list[tuple[Any, ...]] = []
        self._keep_camera(rays, si, of_pixel)
        self._look(si, x, shown, hit, of_pixel, rays, layouts)
        self._follow(*self._reflect(rays, si, x, hit, of_pixel, media, number))
        self._points(rays, si, hits, of_pixel)
        self.shown = [beside(self.nodes, *reflected) for reflected in zip(*self._reflected, strict=True)]
        self.open = _joined(self._open)

    def _keep_camera(self, rays: Any, si: Any, pixel: NDArray) -> None:
        """Keep rays that meet nothing, and one a pixel of the others, for lamps in front of things."""
        valid = np.array(si.is_valid())
        solid_count = np.bincount(pixel, valid, self.pixels)
        first = valid & (np.arange(len(pixel)) % SIDE**2 == 0)
        weight = np.where(valid, 0.0, 1.0) / SIDE**2
        weight[first] = solid_count[pixel[first]] / SIDE**2
        kept = np.flatnonzero(weight > 0)
        until = np.where(valid, np.array(si.t), np.finfo(np.float32).max)
        o, d = np.array(rays.o).T[kept], np.array(rays.d).T[kept]
        self._open.append((o, d, until[kept], pixel[kept], np.repeat(weight[kept, None], 3, 1)))

    def _look(
        self, si: Any, x: Any, shown: Any, hit: NDArray, pixel: NDArray, rays: Any, layouts: Any
    ) -> None:
        """Find which nodes the first hits on objects look at."""
        lookup = self._lookup
        p, n = np.array(si.p).T[hit], np.array(x.normal).T[hit]
        which = np.array(lookup.number(si.shape, mi.Bool(True)))[hit]
        total = sparse.csr_matrix((self.pixels, len(lookup.points)), dtype=np.float32)
        for i, (_, _, spacing) in enumerate(layouts):
            own, mine = lookup.own(i), which == i
            if not mine.any():
                continue
            near = interpolation(p[mine], n[mine], lookup.points[own], lookup.normals[own], REACH * spacing)
            weight = np.array(shown)[hit][mine] / SIDE**2
            sums = sparse.csr_matrix(
                (weight.astype(np.float32), (pixel[hit][mine], np.arange(len(weight)))),
                shape=(self.pixels, len(weight)),
            )
            part = (sums @ near).tocoo()
            shape = (self.pixels, len(lookup.points))
            total = total + sparse.csr_matrix((part.data, (part.row, part.col + own.start)), shape=shape)
        self.nodes = total.astype(np.float32)
        # the mean direction in which each node is seen
        middle = np.zeros((self.pixels, 3))
        for axis in range(3):
            middle[:, axis] = -np.bincount(pixel, np.array(rays.d)[axis], self.pixels)
        toward = self.nodes.T @ middle
        unseen = np.linalg.norm(toward, axis=1) < 1e-12
        toward[unseen] = lookup.normals[unseen]
        self.toward = (toward / np.linalg.norm(toward, axis=1, keepdims=True)).astype(np.float32)

    def _reflect(
        self, rays: Any, si: Any, x: Any, hit: NDArray, pixel: NDArray, media: Any, number: Any
    ) -> tuple[Any, ...]:
        """Return the rays that leave objects without having been scattered: reflected ones, and straight through."""
        chosen = mi.UInt32(hit)
        first = dr.gather(type(si), si, chosen)
        reflectance = dr.gather(mi.Float, x.reflectance, chosen)
        reflected = first.spawn_ray(dr.gather(mi.Vector3f, x.reflected, chosen))
        number = dr.gather(mi.UInt32, number, chosen)
        inside = first.spawn_ray(dr.gather(mi.Vector3f, x.refracted, chosen))
        absorbed, scattered = media.coefficients(number, first, mi.Bool(True))
        other = self._solid.ray_intersect(inside)
        through = interface.cross(other, inside.d, dr.rcp(media.lookup(media.eta, number)))
        left = dr.exp(-(absorbed + scattered) * other.t) * (1 - reflectance) * (1 - through.reflectance)
        left = dr.select(other.is_valid() & (media.number(other.shape) == number), left, 0)
        beyond = other.spawn_ray(through.refracted)
        parts = []
        for ray, weight in ((reflected, mi.Spectrum(reflectance)), (beyond, left)):
            w = np.array(weight).T / SIDE**2
            kept = w.max(axis=1) > _LEAST / SIDE**2
            parts.append((np.array(ray.o).T[kept], np.array(ray.d).T[kept], pixel[hit][kept], w[kept]))
        return tuple(np.concatenate(part) for part in zip(*parts, strict=True))

    def _follow(self, o: NDArray, d: NDArray, pixel: NDArray, weight: NDArray) -> None:
        """Find what such rays meet; `_reflected` holds matrices from X and from stations' radiance, one a channel."""
        lookup, shape = self._lookup, (self.pixels, len(self._lookup.points))
        entries: list[list[tuple[Any, ...]]] = [[], []]
        for _ in range(REFLECTIONS):
            if not len(o):
                break
            ray = mi.Ray3f(mi.Point3f(o.T), mi.Vector3f(d.T))
            si = self._solid.ray_intersect(ray)
            hits, shown = self._surroundings.sent(si, si.is_valid())
            node = self._surroundings.node(si, hits)
            which = lookup.number(si.shape, hits)
            x = interface.cross(si, ray.d, dr.select(hits, dr.gather(mi.Float, lookup.eta, which, hits), 1.5))
            following = si.spawn_ray(x.reflected)
            dr.eval(si, shown, node, x, following)
            valid, hit = np.array(si.is_valid()), np.array(hits)
            until = np.where(valid, np.array(si.t), np.finfo(np.float32).max)
            self._open.append((o, d, until, pixel, weight))
            entries[0].append((pixel[hit], np.array(node)[hit], weight[hit] * np.array(shown)[hit, None]))
            other = valid & ~hit
            if self._surroundings.count:
                stations = self._surroundings.nearest(np.array(si.p).T[other])
                entries[1].append((pixel[other], stations, weight[other]))
            weight = weight * np.array(x.reflectance)[:, None]
            kept = hit & (weight.max(axis=1) > _LEAST)
            o, d = np.array(following.o).T[kept], np.array(following.d).T[kept]
            pixel, weight = pixel[kept], weight[kept]
        shapes = (shape, (self.pixels, self._surroundings.count))
        self._reflected = [of_entries(parts, size) for parts, size in zip(entries, shapes, strict=True)]

    def _points(self, rays: Any, si: Any, hits: Any, pixel: NDArray) -> None:
        """Choose a point of the other surfaces in each pixel that shows one."""
        other = np.flatnonzero(np.array(si.is_valid() & ~hits))
        cover = np.bincount(pixel[other], minlength=self.pixels) / SIDE**2
        self.pixel, first = np.unique(pixel[other], return_index=True)
        self.at: Any = None
        self.seen: Any = None
        if not len(self.pixel):
            return
        chosen = mi.UInt32(other[first])
        self.at = self._solid.ray_intersect(dr.gather(mi.Ray3f, rays, chosen))
        dr.eval(self.at)
        albedo = np.maximum(Surroundings.reflectance(self.at), 1e-4).T
        self.inverse = mi.Spectrum(1 / albedo)
        self.reflects = cover[self.pixel].astype(np.float32) * albedo
        y, x = np.divmod(self.pixel, self.width)
        self.sequence: Sequence = over_pixels(x, y)
        self.mean = self._neighbours(x, y)
        seen = self._surroundings.seen(
            faced(self._solid.ray_intersect(dr.gather(mi.Ray3f, rays, chosen))), FROM_PIXELS, 3
        )
        self.seen = beside(seen.nodes, seen.stations)

    def _neighbours(self, x: NDArray, y: NDArray) -> Any:
        """Return the mean over pixels around, of the same surface; each of a tile's has equal weight in it."""
        place = np.full((self.height, self.width), -1)
        place[y, x] = np.arange(len(x))
        n, p = np.array(self.at.sh_frame.n).T, np.array(self.at.p).T
        shape = np.array(dr.reinterpret_array(mi.UInt32, self.at.shape))
        far = np.array(self.at.t)
        rows, columns, weights = [], [], []
        half = TILE // 2
        for dy in range(-half, half + 1):
            for dx in range(-half, half + 1):
                there = (y + dy >= 0) & (y + dy < self.height) & (x + dx >= 0) & (x + dx < self.width)
                a = np.flatnonzero(there)
                b = place[y[a] + dy, x[a] + dx]
                a, b = a[b >= 0], b[b >= 0]
                above = np.abs(np.einsum("ij,ij->i", p[b] - p[a], n[a]))
                alike = (
                    (shape[a] == shape[b])
                    & (np.einsum("ij,ij->i", n[a], n[b]) > _ALIKE)
                    & (above < 0.01 * far[a])
                )
                a, b = a[alike], b[alike]
                rows.append(a)
                columns.append(b)
                edges = (abs(dx) == half) + (abs(dy) == half)
                weights.append(np.full(len(a), 0.5**edges))
        index = np.concatenate(rows), np.concatenate(columns)
        matrix = sparse.csr_matrix((np.concatenate(weights), index), shape=(len(x),) * 2)
        return (sparse.diags(1 / np.asarray(matrix.sum(axis=1)).ravel()) @ matrix).astype(np.float32)


def _rays(sensor: Any, width: int, height: int) -> tuple[Any, Any]:
    """Return the camera's rays, on a square grid in each pixel, and the pixels that they belong to."""
    index = dr.arange(mi.UInt32, width * height * SIDE**2)
    pixel, part = index // SIDE**2, index % SIDE**2
    x = mi.Float(pixel % width) + (mi.Float(part % SIDE) + 0.5) / SIDE
    y = mi.Float(pixel // width) + (mi.Float(part // SIDE) + 0.5) / SIDE
    spot = mi.Point2f(x / width, y / height)
    ray = sensor.sample_ray(sensor.shutter_open(), 0.5, spot, mi.Point2f(0.5))[0]
    dr.eval(ray, pixel)
    return mi.Ray3f(ray), pixel


def _joined(parts: list[tuple[Any, ...]]) -> Open:
    o, d, until, pixel, weight = (np.concatenate(part) for part in zip(*parts, strict=True))
    ray: Any = mi.Ray3f(mi.Point3f(o.T), mi.Vector3f(d.T))
    ray.maxt = mi.Float(until)
    found = Open(ray, mi.UInt32(pixel), mi.Spectrum(weight.T.astype(np.float32)))
    dr.eval(found.ray, found.owner, found.weight)
    return found
