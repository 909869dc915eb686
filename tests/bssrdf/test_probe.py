"""The probe's density is a density: over planes at any angle, by sampling; and no weight is large."""

import math

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.bssrdf import probe

COUNT = 1 << 18
POLES = [(0.7, 0.6), (3.0, 0.4)]
CORE = 1.0


def _frame(normal):
    return mi.Frame3f(mi.Vector3f(*(float(x) for x in normal)))


def _draw(seed):
    """Chords of many probes around the origin: origin, direction, length."""
    rng = np.random.default_rng(seed)
    u = [mi.Float(rng.random(COUNT)) for _ in range(5)]
    depth = dr.select(u[0] < POLES[0][1], POLES[0][0], POLES[1][0])
    axes = probe.axis(_frame((0, 0, 1)), u[1])
    return probe.chord(mi.Point3f(0), axes, probe.distance(depth, u[2]), CORE, u[3], u[4])


def _density(points, normal):
    n = mi.Vector3f(*(float(x) for x in normal))
    return np.array(probe.density(POLES, _frame((0, 0, 1)), mi.Vector3f(points.T), n, CORE))


def _disc(normal, offset, radius):
    """Midpoint rule in polar coordinates over a disc around a point: points, areas."""
    r, phi = (np.arange(800) + 0.5) / 800, 2 * np.pi * (np.arange(400) + 0.5) / 400
    r, phi = (x.ravel() for x in np.meshgrid(r**2 * radius, phi, indexing="ij"))
    frame = _frame(normal)
    s, t = (np.array(x).ravel() for x in (frame.s, frame.t))
    points = offset + np.outer(r * np.cos(phi), s) + np.outer(r * np.sin(phi), t)
    # r = radius x^2: dr = 2 radius x dx
    return points, r * 2 * radius * np.sqrt(r / radius) / 800 * (2 * np.pi / 400)


def test_axes_are_chosen_with_probabilities_that_add_up_to_one():
    assert sum(probe.AXES) == pytest.approx(1)
    frame = _frame((0, 0, 1))
    along, across, other = probe.axis(frame, mi.Float(np.linspace(0, 0.9999, 1000)))
    of_normal = np.mean(np.abs(np.array(along)[2]) > 0.9)
    assert of_normal == pytest.approx(probe.AXES[0], abs=2e-3)
    for a, b in ((along, across), (along, other), (across, other)):
        assert np.abs(np.array(dr.dot(a, b))).max() < 1e-6


@pytest.mark.parametrize("cosine", [1.0, 0.8, 0.3])
@pytest.mark.parametrize("height", [0.0, -2.0, 5.0])
def test_density_integrates_over_a_disc_to_the_chance_of_a_hit(cosine, height):
    """Discs at any angle, through the entry or beside it; each chord hits one at most once (4 sigma: 6e-5)."""
    normal = np.array([math.sqrt(1 - cosine * cosine), 0.0, cosine])
    center, radius = np.array([0.3, 0.0, height]), 6.0
    points, area = _disc(normal, center, radius)
    integral = area @ _density(points, normal)
    origin, direction, length = _draw(5)
    n = mi.Vector3f(*(float(x) for x in normal))
    t = dr.dot(mi.Point3f(*(float(x) for x in center)) - origin, n) / dr.dot(direction, n)
    away = dr.norm(origin + t * direction - mi.Point3f(*(float(x) for x in center)))
    hits = np.mean(np.array((t > 0) & (t < length) & (away < radius)))
    error = math.sqrt(max(hits * (1 - hits), 1e-6) / COUNT)
    assert integral == pytest.approx(hits, abs=4 * error + 1e-3)


def test_chords_reach_heights_with_the_probability_that_the_density_takes():
    rng = np.random.default_rng(8)
    r = mi.Float(np.full(COUNT, 0.5))
    axes = probe.axis(_frame((0, 0, 1)), mi.Float(0.1))
    _, _, length = probe.chord(mi.Point3f(0), axes, r, CORE, mi.Float(0), mi.Float(rng.random(COUNT)))
    for height in (0.5, 1.5, 3.0, 12.0):
        share = np.mean(np.array(length) / 2 >= height)
        expected = float(probe.reached(mi.Float(height), mi.Float(0.5), CORE)[0])
        assert share == pytest.approx(expected, abs=4 * math.sqrt(0.25 / COUNT))


def test_no_point_weighs_much_whatever_its_normal():
    """A dipole's kernel over the density, for points all around: bounded, so that there are no fireflies."""
    rng = np.random.default_rng(3)
    points = rng.normal(size=(20000, 3)) * np.exp(rng.uniform(-4, 5, (20000, 1)))
    normals = rng.normal(size=(20000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    density = np.array(
        probe.density(POLES, _frame((0, 0, 1)), mi.Vector3f(points.T), mi.Vector3f(normals.T), CORE)
    )
    squared = (points**2).sum(axis=1)
    kernel = sum(p * z / (2 * math.pi * (squared + z * z) ** 1.5) for z, p in POLES)
    assert (kernel / density).max() < 12
