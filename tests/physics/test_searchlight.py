"""The simulation of searchlights against exact and published values, and its laws.

Statistical tests fix their seeds. `_agree` fails a right program with probability 1e-4 a case, were seeds drawn anew.
"""

import math

import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

from nephrite.errors import ParameterError
from nephrite.physics import halfspace, phase, searchlight
from nephrite.physics.fresnel import external_diffuse_reflectance, reflectance, refracted_cosine
from nephrite.physics.single import single_scattering_share
from support import scenes

CHANCE = 1e-4
ALBEDOS = np.array([0.3, 0.8, 0.95, 0.99, 0.999])


def _agree(value, error, expected, chance=CHANCE):
    """Two-sided z-test of independent or correlated values, at the level `chance` for all of them together."""
    z = (np.ravel(value) - np.ravel(expected)) / np.ravel(error)
    assert np.abs(z).max() < stats.norm.isf(0.5 * chance / z.size), z


@pytest.mark.parametrize(
    ("eta", "g", "incidence", "paths"),
    [
        (1.0, 0.0, "normal", 2**19),
        (1.3, 0.0, "diffuse", 2**19),
        (1.6, 0.5, "normal", 2**17),
        (1.02, 0.8, "diffuse", 2**16),
        (1.4, 0.95, "diffuse", 2**14),
        (0.8, -0.4, "diffuse", 2**17),
    ],
)
def test_totals_are_exact(eta, g, incidence, paths):
    light = searchlight.simulate(eta, g, incidence=incidence, paths=paths, seed=1, longest=2**16)
    expected = [halfspace.total_reflectance(a, eta, g, incidence) for a in ALBEDOS]
    _agree(*light.total(ALBEDOS), expected)
    expected = [halfspace.total_reflectance(a, eta, g, incidence, multiple=True) for a in ALBEDOS]
    _agree(*light.total(ALBEDOS, first=2), expected)
    if incidence == "diffuse" and eta >= 1.0:
        # order by order: what the integrator takes away as single scattering
        _agree(*light.total(1.0, first=1, last=1), single_scattering_share(g, eta))


def test_slab_of_van_de_hulst():
    """The slab of Wang, Jacques and Zheng (1995), table 1: 10 and 90 /cm, g = .75, .02 cm, index-matched."""
    light = searchlight.simulate(1.0, 0.75, thickness=2.0, paths=2**20, seed=2)
    reflected, transmitted = light.total(0.9), light.total(0.9, transmitted=True)
    assert max(reflected.error, transmitted.error) < 4e-4
    # the published values are rounded
    _agree(reflected.value, np.hypot(reflected.error, 5e-6), 0.09739)
    _agree(transmitted.value, np.hypot(transmitted.error, 5e-6), 0.66096)


def test_half_space_of_giovanelli():
    """The same, table 2: 10 and 90 /cm, isotropic, index 1.5; with specular reflection."""
    light = searchlight.simulate(1.5, paths=2**20, seed=3, longest=2**14)
    total = light.total(0.9)
    entered = 1.0 - light.specular
    assert light.specular == pytest.approx(0.04)
    _agree(light.specular + entered * total.value, np.hypot(entered * total.error, 5e-5), 0.2600)


def test_nothing_is_lost_without_absorption():
    light = searchlight.simulate(1.3, 0.3, thickness=3.0, paths=2**17, seed=4)
    both = [light.total(1.0), light.total(1.0, transmitted=True)]
    # what leaves on one side does not on the other: errors add up at the most
    _agree(sum(b.value for b in both), sum(b.error for b in both), 1.0)
    rings = light.profile(1.0).value.sum() + light.profile(1.0, transmitted=True).value.sum()
    assert rings == pytest.approx(sum(b.value for b in both), rel=1e-12)
    sines = light.directions(1.0).value.sum() + light.directions(1.0, transmitted=True).value.sum()
    assert sines == pytest.approx(rings, rel=1e-12)
    assert light.cut(1.0) == 0.0


def test_what_is_cut_is_reported():
    light = searchlight.simulate(1.5, paths=2**17, seed=5, longest=60)
    total = light.total(1.0)
    share = light.cut(1.0)
    assert share > 0.05
    _agree(total.value + share, total.error + math.sqrt(2.0 * share / light.counts.paths), 1.0)
    assert light.cut(0.9) == pytest.approx(0.9**60 * share)


@pytest.mark.parametrize("eta", [1.0, 1.4])
def test_light_goes_both_ways(eta):
    """Radiance towards a direction, of diffuse light, is what light from there has as its total."""
    g, albedo = 0.7, 0.97
    diffuse = searchlight.simulate(eta, g, incidence="diffuse", paths=2**18, seed=6, longest=2**13)
    lobe = diffuse.directions(albedo)
    for bin in (0, 9, 17):
        middle = math.sqrt(1.0 - 0.5 * (lobe.edges[bin] + lobe.edges[bin + 1]))
        slanted = searchlight.simulate(eta, g, incidence=middle, paths=2**17, seed=7, longest=2**13)
        total = slanted.total(albedo)
        factor = (1.0 - reflectance(middle, eta)) / (1.0 - external_diffuse_reflectance(eta)) / 20
        _agree(lobe.value[bin], math.hypot(lobe.error[bin], factor * total.error), factor * total.value)


def test_directions_are_those_of_the_exact_solution():
    light = searchlight.simulate(1.3, 0.0, incidence="diffuse", paths=2**19, seed=8, longest=2**14)
    bins = light.directions(0.9, first=2)
    exits = halfspace.emergent(0.9, 1.3)
    order = np.argsort(exits.outside)
    sine = 1.0 - exits.outside[order] ** 2
    # share per unit of squared sine: the lobe's radiance over its mean
    density = (1.0 - reflectance(exits.outside[order], 1.3)) * exits.multiple[order]
    density /= 1.0 - external_diffuse_reflectance(1.3)
    points, weights = np.polynomial.legendre.leggauss(8)
    places = bins.edges[:-1, None] + 0.05 * 0.5 * (points + 1.0)
    expected = 0.05 * (np.interp(places, sine[::-1], density[::-1]) @ weights) / 2.0
    # the last bin ends at grazing light, where the interpolation is coarse
    _agree(bins.value[:-1], bins.error[:-1], expected[:-1])


@pytest.mark.parametrize("cosine", [1.0, 0.5])
def test_light_that_is_not_scattered_goes_straight(cosine):
    eta, thickness = 1.5, 0.7
    light = searchlight.simulate(eta, 0.5, thickness=thickness, incidence=cosine, paths=2**16, seed=9)
    inside = refracted_cosine(cosine, eta)
    reflected = reflectance(cosine, eta)
    passes = math.exp(-thickness / inside)
    expected = (1.0 - reflected) * passes / (1.0 - (reflected * passes) ** 2)
    _agree(*light.total(0.3, transmitted=True, first=0, last=0), expected)
    rings = light.profile(0.3, transmitted=True, first=0, last=0)
    offset = thickness * math.sqrt(1.0 - inside**2) / inside
    at = np.argmax(rings.value)
    assert rings.edges[at] <= max(offset, 1e-6) < rings.edges[at + 1]


@pytest.mark.parametrize("g", [0.0, 0.6])
def test_rings_of_light_that_scattered_once(g):
    """Against R(r) = integral over the depth z of e^-z p(-z/d) e^-d z/d^3, d^2 = r^2 + z^2; index-matched."""
    light = searchlight.simulate(1.0, g, paths=2**19, seed=15, longest=2, radii=(0.03, 3.0, 20))
    rings = light.profile(1.0, first=1, last=1)
    points, weights = np.polynomial.legendre.leggauss(12)
    edges = rings.edges[1:-1]
    r = edges[:-1, None, None] + np.diff(edges)[:, None, None] * 0.5 * (points[:, None] + 1.0)
    share, of_share = np.polynomial.legendre.leggauss(200)
    z = 12.0 * r * (0.5 * (share + 1.0)) ** 2 / (1.0 + r)  # from 0 to where little is left, crowded at 0
    depth = 12.0 * r * 0.5 * (share + 1.0) / (1.0 + r) * of_share
    d = np.sqrt(r**2 + z**2)
    radial = (depth * np.exp(-z - d) * phase.eval(-z / d, g) * z / d**3).sum(axis=-1, keepdims=True)
    expected = (2.0 * math.pi * r * radial * weights[:, None]).sum(axis=(1, 2)) * 0.5 * np.diff(edges)
    _agree(rings.value[1:-1], rings.error[1:-1], expected)


def test_gaussian_beam():
    """1 - e^-2 of a Gaussian beam lies within the radius where it has fallen to 1/e^2."""
    light = searchlight.simulate(
        1.0, thickness=0.1, beam_radius=0.5, paths=2**16, seed=10, radii=(0.25, 1.0, 2)
    )
    rings = light.profile(0.0, transmitted=True)
    within = 1.0 - np.exp(-2.0 * (np.array([0.25, 0.5, 1.0]) / 0.5) ** 2)
    expected = math.exp(-0.1) * np.diff(np.concatenate([[0.0], within, [1.0]]))
    _agree(rings.value, rings.error, expected)


def test_standard_errors_are_true():
    """Chi-square of 24 independent totals and rings, two-sided at 1e-4 each: errors neither too small nor too large."""
    albedo, edges = np.array([0.5, 0.999]), (0.1, 10.0, 2)
    runs = [
        searchlight.simulate(1.3, paths=2**12, seed=100 + k, longest=2**10, radii=edges) for k in range(24)
    ]
    for one in (lambda run: run.total(albedo), lambda run: run.profile(albedo)[1:]):
        values, errors = (np.array(column) for column in zip(*(one(run) for run in runs), strict=True))
        chi2 = np.sum((values - values.mean(axis=0)) ** 2, axis=0) / np.mean(errors**2, axis=0)
        low, high = stats.chi2.ppf([0.5e-4, 1.0 - 0.5e-4], len(runs) - 1)
        assert np.all((chi2 > low) & (chi2 < high)), chi2


def test_rings_hold_the_total_and_seeds_decide():
    first = searchlight.simulate(1.2, 0.4, paths=2**12, seed=11, longest=1000)
    again = searchlight.simulate(1.2, 0.4, paths=2**12, seed=11, longest=1000)
    other = searchlight.simulate(1.2, 0.4, paths=2**12, seed=12, longest=1000)
    assert first.profile(ALBEDOS).value.sum(axis=-1) == pytest.approx(first.total(ALBEDOS).value, rel=1e-12)
    np.testing.assert_array_equal(first.counts.rings, again.counts.rings)
    assert np.any(first.counts.rings != other.counts.rings)
    assert np.all(first.total(ALBEDOS, transmitted=True).value == 0.0)


def test_forward_scattering_is_like_less_scattering():
    """Similarity: how light falls off far away depends on the reduced coefficients alone (z-test as in `_agree`)."""
    albedo_prime, values, errors = 0.995, [], []
    for g in (0.0, 0.8):
        albedo = albedo_prime / (1.0 - g + albedo_prime * g)
        unit = 1.0 - albedo * g
        rings = (8.0 / unit, 32.0 / unit, 2)
        light = searchlight.simulate(1.3, g, paths=2**16, seed=13, longest=2**14, radii=rings)
        near, far = light.profile(albedo).value[1:3]
        values.append(far / near)
        errors.append(values[-1] * np.hypot(*light.profile(albedo).error[1:3] / [near, far]))
    _agree(values[1] - values[0], np.hypot(*errors), 0.0)
    assert np.hypot(*errors) < 0.06 * values[0]


@pytest.mark.slow
@pytest.mark.parametrize("cosine", [1.0, 0.3])
def test_the_integrators_exact_walk_agrees(cosine):
    """Radiance of a thick plate under a uniform sky: what it reflects of light from there, by another program."""
    eta, g, albedos = 1.4, 0.6, [0.5, 0.9, 0.99]
    origin = [200.0 * math.sqrt(1.0 - cosine**2) + 1.0, 2.0, 200.0 * cosine]
    transform = mi.ScalarTransform4f
    plate = {"type": "cube", "to_world": transform().translate([0, 0, -60]).scale([300, 300, 60])}
    scene = {
        "type": "scene",
        "plate": plate | scenes.translucent([1.0 - a for a in albedos], albedos, g, eta),
        "sky": scenes.environment(1.0),
        "sensor": {
            "type": "orthographic",
            "to_world": transform().look_at(origin, [1.0, 2.0, 0.0], [0, 1, 0])
            @ transform().scale([0.01, 0.01, 1]),
            "film": {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}},
        },
    }
    integrator = mi.load_dict(scenes.ours(model="walk", exit="exact"))
    pixels = np.array(mi.render(mi.load_dict(scene), integrator=integrator, spp=256, seed=1)).reshape(-1, 3)
    noise = pixels.std(axis=0) / math.sqrt(len(pixels))
    light = searchlight.simulate(eta, g, incidence=cosine, paths=2**19, seed=14, longest=2**14)
    total = light.total(np.array(albedos))
    expected = light.specular + (1.0 - light.specular) * total.value
    assert np.all(noise < 2e-3)
    _agree(pixels.mean(axis=0), np.hypot(noise, (1.0 - light.specular) * total.error), expected)


@pytest.mark.parametrize(
    "parameters",
    [
        {"eta": 0.0},
        {"g": 1.0},
        {"thickness": 0.0},
        {"thickness": math.nan},
        {"beam_radius": -1.0},
        {"incidence": "oblique"},
        {"incidence": 0.0},
        {"incidence": 0.1, "eta": 0.8},
        {"paths": 0},
        {"radii": (1.0, 0.5, 10)},
    ],
)
def test_nonsense_is_refused(parameters):
    with pytest.raises(ParameterError):
        searchlight.simulate(**parameters)


def test_orders_beyond_those_told_apart_are_refused():
    light = searchlight.simulate(1.0, paths=16, longest=300)
    with pytest.raises(ParameterError, match="last"):
        light.total(0.5, last=200)
