"""Laws of the colour maps, exact values, and renders by the exact walk, which shares no code with them."""

import math

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from drjit.scalar import ArrayXf
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from nephrite.errors import ParameterError
from nephrite.image.errors import z_limit
from nephrite.physics import Medium, color, color_halfspace, color_interface, fresnel, halfspace, inversion
from nephrite.physics.single import single_scattering_share
from support import plate
from support.measure import FALSE_ALARM
from support.quick import slow

SURFACES = [
    (0.7, 0.0, 0.0),
    (1.0, 0.0, 0.0),
    (1.0, 0.95, 0.0),
    (1.005, 0.9, 0.0),
    (1.3, 0.0, 0.0),
    (1.5, -0.5, 0.0),
    (1.6, 0.95, 0.0),
    (2.5, 0.8, 0.0),
    (1.3, 0.0, 0.05),
    (1.5, 0.8, 0.3),
    (1.6, 0.0, 1.0),
]
COLORS = np.concatenate([[0.001, 0.005, 0.01, 0.02], np.linspace(0.03, 0.99, 97), [0.999]])


def half_space(albedo):
    """Chandrasekhar's H function, isotropic, index-matched: albedo for normal and for diffuse light."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    mu, weights = 0.5 * (nodes + 1), 0.5 * weights
    kernel = weights * mu / (mu[:, None] + mu)
    absorbed = math.sqrt(1 - albedo)
    h = np.ones_like(mu)
    for _ in range(2000):
        h = 1 / (absorbed + 0.5 * albedo * kernel @ h)
    at_normal = 1 / (absorbed + 0.5 * albedo * np.sum(weights * mu / (1 + mu) * h))
    return 1 - absorbed * at_normal, 1 - absorbed * 2 * np.sum(weights * mu * h)


@pytest.mark.parametrize(
    ("albedo", "published"), [(0.5, 0.1152), (0.8, 0.2853), (0.95, 0.5355), (0.99, 0.7527), (0.999, 0.9128)]
)
def test_a_matched_half_space_has_its_exact_colour(albedo, published):
    normal, diffuse = half_space(albedo)
    assert normal == pytest.approx(published, abs=1e-4)
    assert color.albedo_to_color(albedo, 1.0) == pytest.approx(diffuse, abs=2e-6)


def test_giovanellis_half_space():
    """Index 1.5, albedo .9, isotropic: .2600 of normally incident light comes back, the highlight included (1955)."""
    eta = 1.5
    at = color_halfspace.streams(eta, 24)
    surface = color_interface.interface(at, eta, 0.0)
    medium = color_halfspace.reflection(at, 0.0, 0.9)
    upward = medium @ np.linalg.solve(np.eye(36) - surface.reflects @ medium, surface.transmits)
    highlight = fresnel.reflectance(1.0, eta)
    seen = at.project(np.array([1.0]), np.array([1.0 - highlight])) @ upward  # by reciprocity
    assert highlight + seen == pytest.approx(0.2600, abs=1e-4)


@pytest.mark.parametrize("eta", [1.0, 1.3, 1.6])
@pytest.mark.parametrize("g", [-0.5, 0.0, 0.5, 0.9])
def test_dark_media_scatter_once(eta, g):
    albedo = 1e-4
    reduced = albedo * (1 - g) / (1 - albedo * g)
    # at g = .9 light still leaves after many events, each of which changes its direction little
    assert color.albedo_to_color(reduced, eta, g) / albedo == pytest.approx(
        single_scattering_share(g, eta), rel=1e-2 if g > 0.8 else 2e-3
    )


@pytest.mark.parametrize("eta", [0.8, 1.01, 1.3, 1.6])
@pytest.mark.parametrize("g", [-0.5, 0.0, 0.9])
def test_a_second_solver_finds_the_same(eta, g):
    """`halfspace` has other directions, another eigenvalue problem, and treats forward peaks in another way."""
    for asked in (0.02, 0.3, 0.9, 0.98):
        reduced = color.color_to_albedo(asked, eta, g)
        shown = halfspace.total_reflectance(reduced / (1 - g + g * reduced), eta, g)
        assert shown == pytest.approx(asked, rel=5e-4)


@pytest.mark.parametrize("surface", SURFACES, ids=str)
def test_round_trips_are_monotone_and_end_exactly(surface):
    of = color.color_map(*surface)
    colors = COLORS * of.reach
    falloffs = of.falloff(colors)
    assert np.all(np.diff(falloffs) < 0)
    assert np.all((falloffs > 0) & (falloffs < math.sqrt(3)))
    np.testing.assert_allclose(of.color_of_falloff(falloffs), colors, rtol=2e-4)
    np.testing.assert_allclose(of.color(of.albedo(colors)), colors, rtol=2e-4)
    assert np.all(np.diff(of.color(np.linspace(0, 1, 301))) > 0)
    assert (of.albedo(of.reach), of.color(1.0)) == (1.0, of.reach)
    assert of.albedo(0.0) == pytest.approx(0.0, abs=1e-15)
    assert of.color(0.0) == of.of_coefficients(1.0, 0.0) == of.of_coefficients(0.0, 0.0) == 0.0
    assert of.of_coefficients(0.0, 1.0) == of.reach
    if surface[2] == 0:
        assert of.reach == 1


@settings(deadline=None, max_examples=20)
@given(st.floats(0.02, 1), st.floats(0.7, 2.0), st.floats(-0.5, 0.98), st.sampled_from([0.0, 0.0, 0.0, 0.2]))
def test_round_trip_through_the_medium(share, eta, g, alpha):
    """To the .001 that the module promises in this range: two polynomials, each the other's inverse by a fit."""
    of = color.color_map(eta, g, alpha)
    medium = color.from_color_and_radius(share * of.reach, 2.5, g, eta, alpha)
    assert 1 / medium.sigma_t_prime[0] == pytest.approx(2.5, rel=1e-9)
    assert (medium.g, medium.eta) == (g, eta)
    again = color.albedo_to_color(medium.albedo_prime[0], eta, g, alpha)
    assert again == pytest.approx(share * of.reach, rel=1e-3)


def test_more_streams_change_nothing(monkeypatch):
    """The error that the module states: .1 % of the colour from .02 on."""
    for surface in [SURFACES[i] for i in (3, 6, 9)]:
        monkeypatch.setattr(color, "_STREAMS", 24)
        monkeypatch.setattr(color_interface, "_NODES", 48)
        usual = color._color_map.__wrapped__(*surface)
        monkeypatch.setattr(color, "_STREAMS", 36)
        monkeypatch.setattr(color, "_ALBEDOS", 24)
        monkeypatch.setattr(color_interface, "_NODES", 64)
        finer = color._color_map.__wrapped__(*surface)
        colors = COLORS[COLORS >= 0.02] * usual.reach * 0.999
        np.testing.assert_allclose(finer.color_of_falloff(usual.falloff(colors)), colors, rtol=1e-3)


@pytest.mark.parametrize("surface", [(1.3, 0.0, 0.0), (1.5, 0.9, 0.0), (1.5, 0.0, 0.3)], ids=str)
def test_drjit_textures_go_through_the_same_map(surface):
    of = color.color_map(*surface)
    colors = np.linspace(0, 1, 51)
    for function, tolerance in ((of.falloff, 5e-6), (of.albedo, 5e-6), (of.color, 5e-4)):
        result = function(ArrayXf(colors))
        assert dr.is_array_v(result)
        # float32 loses half its digits in sqrt(1 - albedo')
        np.testing.assert_allclose(np.array(result), function(colors), atol=tolerance)


@pytest.mark.parametrize("surface", [(1.3, 0.0, 0.0), (1.5, 0.9, 0.3)], ids=str)
def test_derivatives_are_those_of_finite_differences(surface):
    from drjit.llvm.ad import Float64

    of = color.color_map(*surface)
    share = np.array([0.0, 0.01, 0.1, 0.5, 0.9]) * of.reach
    for function, points in ((of.falloff, share + 1e-4), (of.albedo, share + 1e-4), (of.color, share)):
        x = Float64(points)
        dr.enable_grad(x)
        dr.forward(function(x))
        y = Float64(points)
        dr.enable_grad(y)
        value = function(y)
        dr.backward(value)
        step = 1e-6
        expected = (function(points + step) - function(points - step)) / (2 * step)
        if function == of.color:
            expected[0] = (function(2 * step) - function(0.0)) / (2 * step)
        np.testing.assert_allclose(np.array(y.grad), expected, rtol=1e-3)


def test_colours_out_of_reach_are_clamped_or_refused():
    of = color.color_map(1.5, 0.0, 0.5)
    assert 0.5 < of.reach < 0.6
    assert color.color_to_albedo(0.9, 1.5, 0.0, 0.5) == 1.0
    assert color.color_to_albedo(-0.1, 1.5) == pytest.approx(0.0, abs=1e-15)
    with pytest.raises(ParameterError, match=r"color is 0.9.* roughness 0.5.*0\.549.*alpha"):
        color.from_color_and_radius(0.9, 1.0, eta=1.5, alpha=0.5)
    # a matched surface is none
    assert color.color_map(1.0, 0.0, 0.5).reach == 1
    assert color.color_to_albedo(0.4, 1.0, 0.0, 0.5) == color.color_to_albedo(0.4, 1.0)


def test_rougher_is_darker_and_a_little_roughness_is_nearly_smooth():
    whites = [color.color_map(1.4, 0.0, alpha).reach for alpha in (0.0, 0.02, 0.2, 1.0)]
    assert np.all(np.diff(whites) < 0)
    colors = np.linspace(0.05, 0.95, 10)
    of = color.color_map(1.4, 0.5, 0.003)
    np.testing.assert_allclose(of.albedo(colors), color.color_to_albedo(colors, 1.4, 0.5), rtol=2e-3)


def test_a_rough_surface_loses_the_light_that_the_module_says():
    at = color_halfspace.streams(1.5, 24)
    surface = color_interface.interface(at, 1.5, 0.3)
    flux = at.weights * at.cosines
    kept = flux @ (surface.transmits + surface.reflects.sum(axis=1))
    assert 1 - kept / flux.sum() == pytest.approx(0.18, abs=0.005)


@pytest.mark.parametrize("eta", [0.8, 1.0, 1.1, 1.5, 2.0])
def test_what_enters_a_smooth_surface_is_not_reflected(eta):
    entering = color.color_map(eta).entering
    assert entering == pytest.approx(1 - fresnel.external_diffuse_reflectance(eta), rel=1e-5)


@pytest.mark.parametrize(("eta", "alpha"), [(1.3, 0.05), (1.5, 0.3), (1.6, 1.0)])
def test_what_enters_a_rough_surface_is_what_mitsubas_lets_in(eta, alpha):
    """By reciprocity: the map looks from inside, this from outside. Error of the mean: 4e-4."""
    interface = mi.load_dict(
        {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "int_ior": eta, "ext_ior": 1.0}
    )
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(1, 1 << 20)
    si = dr.zeros(mi.SurfaceInteraction3f, 1 << 20)
    si.wi = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
    context = mi.BSDFContext(mi.TransportMode.Importance)
    bs, weight = interface.sample(context, si, sampler.next_1d(), sampler.next_2d())
    entered = dr.select(bs.wo.z < 0, weight[0], 0.0)
    assert float(dr.mean(entered)[0]) == pytest.approx(color.color_map(eta, 0.0, alpha).entering, rel=2e-3)


def test_channels_are_independent_and_no_radius_becomes_diffuse():
    medium = color.from_color_and_radius((0.1, 0.5, 0.9), (3.0, 2.0, 0.0), eta=1.5)
    assert color.albedo_to_color(np.array(medium.albedo_prime), 1.5) == pytest.approx(
        (0.1, 0.5, 0.9), rel=1e-4
    )
    assert medium.sigma_t_prime == pytest.approx((1 / 3, 0.5, 1 / inversion.MIN_RADIUS))


def test_the_ends_are_exact():
    assert color.from_color_and_radius(1.0, 2.0).sigma_a == (0.0, 0.0, 0.0)
    black = color.from_color_and_radius(0.0, 2.0)
    assert black.sigma_s == (0.0, 0.0, 0.0)
    assert black.sigma_a == pytest.approx((0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"color": 1.2}, "color .*255"),
        ({"color": -0.1}, "color .*negative"),
        ({"color": math.nan}, "color .*finite"),
        ({"radius": -1.0}, "radius .*negative"),
        ({"eta": 0.0}, "eta"),
        ({"g": 1.0}, "g is"),
        ({"alpha": 1.1}, "alpha .*smooth"),
        ({"alpha": "rough"}, "alpha"),
    ],
)
def test_impossible_appearances_are_refused(arguments, message):
    with pytest.raises(ParameterError, match=message):
        color.from_color_and_radius(**{"color": 0.5, "radius": 1.0, **arguments})


@pytest.mark.parametrize(
    ("eta", "g", "alpha", "colors"),
    [
        (1.0, 0.5, 0.0, (0.1, 0.8)),
        slow(1.3, 0.0, 0.0, (0.1, 0.4, 0.8)),
        slow(1.6, 0.7, 0.0, (0.05, 0.3)),
        slow(1.5, 0.6, 0.4, (0.05, 0.3)),
    ],
)
def test_a_render_has_the_colour_that_was_asked_for(eta, g, alpha, colors):
    """Within 1 %, by the exact walk. Each fails a right map with probability `FALSE_ALARM`; seeds are fixed."""
    of = color.color_map(eta, g, alpha)
    for asked in colors:
        scene = plate.scene(color.from_color_and_radius(asked, 1.0, g, eta, alpha), alpha)
        paths = int(6000 / asked)  # light colours vary less, and their walks are longer
        found = plate.shown(scene, paths, 8, seed=round(1e5 * (eta + asked)))[:, 0] / of.entering
        mean, error = found.mean(), found.std(ddof=1) / math.sqrt(len(found))
        print(
            f"{eta, g, alpha}: {asked} is {100 * (mean / asked - 1):+.2f} +- {100 * error / asked:.2f} % off"
        )
        limit = stats.t.isf(stats.norm.sf(z_limit(len(colors), FALSE_ALARM)), len(found) - 1)
        assert abs(mean - asked) < limit * error
        assert error < 0.0045 * asked
        assert mean == pytest.approx(asked, rel=0.01)


def test_maps_that_know_no_interface_are_far_off():
    asked = np.linspace(0.1, 0.9, 9)
    errors = [
        color.albedo_to_color(reduced, eta) / asked - 1
        for reduced in (inversion.chiang_albedo(asked), inversion.van_de_hulst_albedo(asked))
        for eta in (1.3, 1.5)
    ]
    assert np.min(errors) == pytest.approx(-0.68, abs=0.005)
    assert np.max(errors) == pytest.approx(-0.08, abs=0.005)


def test_a_medium_is_an_ordinary_one():
    assert isinstance(color.from_color_and_radius(0.5, 1.0), Medium)
