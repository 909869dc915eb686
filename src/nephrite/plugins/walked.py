"""Walks from points of a surface to where they leave it: what the volume carries from there to here.

Transport keeps where they go; diffusion models learn from them how much there is (see `balance`).

Light that falls from all sides enters, walks and leaves. By reciprocity the share that goes from x to y is the share
of the light entering at y that is seen at x.

A vectorised loop runs until the slowest of its lanes is done, and walks have long tails. So each lane takes several
walks, and starts the next as soon as one ends. Long walks are the dear ones, and the light that they bring is spread
evenly, so that few are enough: roulette thins them out by their order. Where media scatter forward, a walk that has
forgotten its direction goes on by similarity, in steps that are 1 / (1 - g) times as long. How walks begin follows one
sequence for all of them, so that those from one place, and from places nearby, do not begin alike.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import lobe
from nephrite.physics import phase
from nephrite.plugins import channels, interface, sequence
from nephrite.plugins.sequence import FREE_PATH, LEADER, POSITION, TURN

_WALKS_PER_LANE = 32
_MIN_LANES = 1 << 14
_ROULETTE_SHARE = 0.05  # of the light, below which roulette begins
_ORDER = 64.0  # reduced order of scattering, above which walks are thinned out by its inverse
_SIMILAR = 8.0  # from which on the medium is taken for one that scatters evenly, and less often
_LONGEST = 100_000


class Ends:
    """Where walks left a shape: points and outward normals, one a walk.

    `weight`: per channel and per light that has entered, 0 for walks of fewer than two events; `twice`: the light that
    scattered a second time; `lost`: what other objects in the shape took; `out`, `back`: tangential directions outside
    at the end and at the start, times what makes their products with other directions the linear part of the lobe's
    kernel (see `nephrite.bssrdf.lobe`).

    A plain class: Dr.Jit would take a dataclass for a part of the loop's state.
    """

    def __init__(self, count: int) -> None:
        """Hold the ends of as many walks, which have brought nothing yet."""
        self.p, self.n = dr.zeros(mi.Point3f, count), dr.zeros(mi.Vector3f, count)
        self.out, self.back = dr.zeros(mi.Vector3f, count), dr.zeros(mi.Vector3f, count)
        self.weight, self.twice, self.lost = (dr.zeros(mi.Spectrum, count) for _ in range(3))

    def evaluate(self) -> None:
        """Make the walks that have been recorded."""
        dr.eval(self.p, self.n, self.out, self.back, self.weight, self.twice, self.lost)


def walk(scene: Any, seed: int, entry: Any, at: Any, shape: Any, begin: Any) -> Ends:
    """Make one walk for each entry of `begin`, from that point of `at`; normals there point outward.

    `entry`: the `entry.Entry` of the shape.
    """
    count = dr.width(begin)
    ends = Ends(count)
    dr.eval(at, begin)
    sampler: Any = mi.load_dict({"type": "independent"})
    sampler.seed(seed, min(count, max(_MIN_LANES, -(-count // _WALKS_PER_LANE))))
    _walk(scene, sampler, sequence.of_one(seed), entry, at, shape, begin, ends)
    ends.evaluate()
    return ends


@dr.syntax
def _walk(
    scene: Any, sampler: Any, even: Any, entry: Any, at: Any, shape: Any, begin: Any, ends: Ends
) -> None:  # fmt: skip
    """Record the loop that fills `ends`."""
    identity = dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))
    eta = dr.opaque(mi.Float, entry.eta)
    g = dr.opaque(mi.Float, entry.g)
    reach = dr.opaque(mi.Float, entry.reach())
    normalization = dr.opaque(mi.Float, lobe.exit_lobe(entry.eta).normalization)
    m2 = dr.opaque(mi.Float, lobe.exit_lobe(entry.eta).m2)
    lanes = sampler.wavefront_size()

    # numbers that are no part of the kernel: one serves for as many walks as are asked for
    count, stride = dr.opaque(mi.UInt32, dr.width(begin)), dr.opaque(mi.UInt32, lanes)
    walks = dr.arange(mi.UInt32, lanes)  # The walk that each lane is making
    fresh, active = mi.Bool(True), walks < count
    origin, falling = mi.Point3f(0), mi.Vector3f(0)
    absorbed, sigma_s, sigma_t = mi.Spectrum(0), mi.Spectrum(0), mi.Spectrum(0)
    channel, β, ratio = mi.UInt32(0), mi.Spectrum(0), mi.Spectrum(0)
    ray = dr.zeros(mi.Ray3f, lanes)
    events, steps, travelled = mi.UInt32(0), mi.UInt32(0), mi.Float(0)
    forward, order = mi.Float(g), mi.Float(0)  # Mean cosine by now; reduced order of scattering
    while active:
        if fresh:
            start = dr.gather(type(at), at, dr.gather(mi.UInt32, begin, walks, active), active)
            origin = mi.Point3f(start.p)
            spot = mi.Point2f(even(POSITION, walks, 0), even(POSITION + 1, walks, 0))
            falling = -mi.Frame3f(start.n).to_world(mi.warp.square_to_cosine_hemisphere(spot))
            inward = interface.cross(start, falling, eta)
            absorbed, sigma_s = entry.coefficients(start, active)
            sigma_t = absorbed + sigma_s
            entered = mi.Spectrum((1 - inward.reflectance) / normalization)
            channel, β, ratio = channels.lead(entered, sigma_t, even(LEADER, walks, 0))
            ray = start.spawn_ray(inward.refracted)
            events, steps, travelled = mi.UInt32(0), mi.UInt32(0), mi.Float(0)
            forward, order = mi.Float(g), mi.Float(0)
        leading = dr.maximum(channels.pick(sigma_t, channel), 1e-30)
        first = steps == 0
        free = even(FREE_PATH, walks, sampler.next_1d(active), first)
        ray.maxt = dr.minimum(-dr.log(1 - free) / leading, 1e30)
        hit = scene.ray_intersect_preliminary(ray, coherent=False, active=active)
        stops = hit.is_valid()
        distance = dr.select(stops, hit.t, ray.maxt)
        travelled += distance
        along = dr.exp(-sigma_t * distance)
        density = along * dr.select(stops, 1, sigma_t)
        of_leader = dr.maximum(channels.pick(density, channel), 1e-30)
        β *= along * dr.select(stops, 1, sigma_s) / of_leader
        ratio *= density / of_leader
        weight = β / dr.sum(ratio)
        u: Any = sampler.next_2d(active)
        u = mi.Point2f(*(even(TURN + i, walks, u[i], first) for i in range(2)))
        goes_on = mi.Bool(active)
        if stops:
            si = hit.compute_surface_interaction(ray, mi.RayFlags.All, active & stops)
            x = interface.cross(si, ray.d, dr.rcp(eta))
            own = mi.Bool(dr.reinterpret_array(mi.UInt32, si.shape) == identity)
            leaves = own & (u.x >= x.reflectance)
            gone = active & leaves & (events > 1)
            memory = lobe.memory(order, 0)[0]
            usual = (1 - memory) * lobe.usual((si.p - origin) / travelled, eta, m2)
            out, back = memory * x.refracted + usual, -memory * falling - usual
            normal = dr.gather(mi.Normal3f, at.n, dr.gather(mi.UInt32, begin, walks, gone), gone)
            dr.scatter(ends.p, si.p, walks, gone)
            dr.scatter(ends.n, -x.normal, walks, gone)
            dr.scatter(ends.weight, weight, walks, gone)
            dr.scatter(ends.out, 2 / m2 * _tangential(out, -x.normal), walks, gone)
            dr.scatter(ends.back, 2 / m2 * _tangential(back, mi.Vector3f(normal)), walks, gone)
            dr.scatter(ends.lost, weight, walks, active & ~own)
            ray = si.spawn_ray(x.reflected)
            goes_on &= own & ~leaves
        else:
            events += 1
            order += 1 - forward
            dr.scatter(ends.twice, weight, walks, active & (events == 2))
            ray.o += ray.d * distance
            ray.d = mi.Frame3f(ray.d).to_world(mi.Vector3f(*phase.sample(u.x, u.y, forward)))
        goes_on &= dr.squared_norm(ray.o - origin) < dr.square(reach)  # or it has found a hole in the shape
        steps += 1
        survival = dr.minimum(dr.max(weight) / _ROULETTE_SHARE, 1)
        thinned = ~stops & (order > _ORDER)
        survival *= dr.select(thinned, 1 - (1 - forward) / order, 1)
        # similarity: what has forgotten its direction goes where it would by sigma_s (1 - g) and g = 0
        similar = order >= _SIMILAR
        sigma_s = mi.Spectrum(sigma_s * mi.Spectrum(dr.select(similar, 1 - forward, 1)))
        sigma_t = absorbed + sigma_s
        forward = dr.select(similar, 0, forward)
        goes_on &= (sampler.next_1d(active) < survival) & (steps < _LONGEST)
        β /= survival
        fresh = active & ~goes_on
        walks += dr.select(fresh, stride, 0)
        active &= walks < count


def _tangential(v: Any, n: Any) -> Any:
    return v - n * dr.dot(v, n)
