"""The probe's density is a density: over a plane through its origin, and over a tilted one, by sampling."""

import math

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.bssrdf import probe
from nephrite.physics.fresnel import boundary_factor
from nephrite.profiles import StandardDipole

PROFILE = StandardDipole(0.05, 1.0, boundary_factor(1.3))
COUNT = 1 << 18


def _frame(normal):
    return mi.Frame3f(mi.Vector3f(*(float(x) for x in normal)))


def _density(points, normal, frame_normal, r_max):
    frame, n = _frame(frame_normal), mi.Vector3f(*(float(x) for x in normal))
    value = probe.density(PROFILE, frame, mi.Vector3f(points.T), n, r_max)
    return np.array(value)


def _disc(normal, radius):
    """Midpoint rule in polar coordinates over a disc around the origin: points, areas."""
    r, phi = (np.arange(800) + 0.5) / 800, 2 * np.pi * (np.arange(400) + 0.5) / 400
    r, phi = (x.ravel() for x in np.meshgrid(r**2 * radius, phi, indexing="ij"))
    frame = _frame(normal)
    s, t = (np.array(x).ravel() for x in (frame.s, frame.t))
    points = np.outer(r * np.cos(phi), s) + np.outer(r * np.sin(phi), t)
    # r = radius x^2: dr = 2 radius x dx
    area = r * 2 * radius * np.sqrt(r / radius) / 800 * (2 * np.pi / 400)
    return points, area


def test_axes_are_chosen_with_probabilities_that_add_up_to_one():
    assert sum(probe.AXES) == pytest.approx(1)
    frame = _frame((0, 0, 1))
    along, across, other = probe.axis(frame, mi.Float(np.linspace(0, 0.9999, 1000)))
    of_normal = np.mean(np.abs(np.array(along)[2]) > 0.9)
    assert of_normal == pytest.approx(probe.AXES[0], abs=2e-3)
    for a, b in ((along, across), (along, other), (across, other)):
        assert np.abs(np.array(dr.dot(a, b))).max() < 1e-6


@pytest.mark.parametrize("cosine", [1.0, 0.8, 0.3])
def test_density_integrates_over_a_plane_to_the_chance_of_a_hit(cosine):
    """A plane through the centre, tilted by any angle, is hit once by each chord that is not parallel to it.

    Chords are cut at the sphere of radius r_max, so all hits of the axis along the plane's normal count; the others
    lose those beyond the sphere, which is what the Monte Carlo counts.
    """
    normal = np.array([math.sqrt(1 - cosine * cosine), 0.0, cosine])
    r_max = 8.0
    points, area = _disc(normal, r_max)
    integral = area @ _density(points, normal, (0, 0, 1), r_max)
    rng = np.random.default_rng(5)
    u = [mi.Float(rng.random(COUNT)) for _ in range(4)]
    radius = PROFILE.sample(u[0], u[1], r_max)
    axes = probe.axis(_frame((0, 0, 1)), u[2])
    half = probe.half_chord(radius, mi.Float(r_max), PROFILE.z_virtual)
    origin, direction, length = probe.chord(mi.Point3f(0), axes, radius, half, u[3])
    n = mi.Vector3f(*(float(x) for x in normal))
    t = -dr.dot(origin, n) / dr.dot(direction, n)
    hits = np.mean(np.array((t > 0) & (t < length) & (radius < r_max)))
    error = math.sqrt(max(hits * (1 - hits), 1e-6) / COUNT)
    assert integral == pytest.approx(hits, abs=4 * error + 2e-3)
    if cosine == 1.0:
        # only the normal's chords cross the plane of the two tangents
        assert integral == pytest.approx(probe.AXES[0], abs=2e-3)


def test_truncation_keeps_almost_all_light_and_is_bounded():
    r_max = probe.truncation_radius(PROFILE, 1e9)
    assert float(np.ravel(PROFILE.cdf(np.ravel(r_max)[0]))[0]) > 0.97
    assert np.ravel(probe.truncation_radius(PROFILE, 0.5))[0] == pytest.approx(0.5)


def test_density_is_nothing_beyond_the_truncation_radius():
    points = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [9.0, 0.0, 0.0]]) + 1e-3
    value = _density(points, (0, 0, 1), (0, 0, 1), 8.0)
    assert value[1] > 0
    assert value[2] == 0
