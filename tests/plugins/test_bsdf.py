"""The BSDF `translucent` under Mitsuba's own integrators: the local model, and a BSDF like any other."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.physics import color
from support import measure, scenes

SURFACES = [{}, {"alpha": 0.3}, {"alpha": 0.1, "int_ior": 1.5}, {"int_ior": 1.0}, {"int_ior": 0.8}]


def _dict(**parameters):
    return {"type": "translucent", "sigma_a": scenes.rgb((0.01, 0.1, 1.0)), "sigma_s": 1.0, **parameters}


@pytest.mark.parametrize("surface", SURFACES[:4], ids=str)
@pytest.mark.parametrize("degrees", [5, 60, 85])
def test_sample_follows_pdf(surface, degrees, tmp_path, monkeypatch):
    """Chi-square, Mitsuba's own test, at a significance of .01 with Sidak's correction for all the cases."""
    properties = "".join(
        f'<float name="{key}" value="{value}"/>'
        for key, value in {"sigma_a": 0.1, "sigma_s": 1.0, **surface}.items()
    )
    wi = [np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))]
    context = mi.BSDFContext()
    if "alpha" not in surface:
        context.component = 1  # the smooth surface's reflection has no density
    sample, pdf = mi.chi2.BSDFAdapter("translucent", properties, wi=[float(x) for x in wi], ctx=context)
    test = mi.chi2.ChiSquareTest(
        domain=mi.chi2.SphericalDomain(), sample_func=sample, pdf_func=pdf, sample_dim=3, sample_count=200_000, res=101,
        ires=16,
    )  # fmt: skip
    monkeypatch.chdir(tmp_path)  # where a failing test leaves its data
    assert test.run(significance_level=0.01, test_count=12), test.messages


def _interaction(count, degrees):
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    si.n = mi.Normal3f(0, 0, 1)
    si.wi = mi.Vector3f(float(np.sin(np.radians(degrees))), 0.0, float(np.cos(np.radians(degrees))))
    return si


@pytest.mark.parametrize("surface", SURFACES, ids=str)
@pytest.mark.parametrize("degrees", [0, 40, 75, 88])
def test_weights_are_value_over_density_and_make_no_energy(surface, degrees):
    bsdf = mi.load_dict(_dict(**surface))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(3, 1 << 16)
    si = _interaction(1 << 16, degrees)
    bs, weight = bsdf.sample(mi.BSDFContext(), si, sampler.next_1d(), sampler.next_2d())
    assert np.all(np.isfinite(weight))
    assert np.array(weight).mean(1).max() <= 1 + 5e-3
    value, density = bsdf.eval_pdf(mi.BSDFContext(), si, bs.wo)
    smooth = ~mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
    there = np.array(smooth & (bs.pdf > 1e-4))
    np.testing.assert_allclose(np.array(density)[there], np.array(bs.pdf)[there], rtol=1e-3)
    np.testing.assert_allclose(
        np.array(value)[:, there], np.array(weight * bs.pdf)[:, there], rtol=1e-3, atol=1e-5
    )


def test_nothing_comes_through_or_from_below():
    bsdf = mi.load_dict(_dict())
    si = _interaction(1, 30)
    assert not np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(0, 0, -1))).any()
    si.wi = -si.wi
    assert not np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(0, 0, 1))).any()


def test_it_is_reciprocal():
    bsdf = mi.load_dict(_dict(alpha=0.3))
    a, b = _interaction(1, 20), _interaction(1, 70)
    there, back = (
        np.array(bsdf.eval(mi.BSDFContext(), x, y.wi)).ravel() / mi.Frame3f.cos_theta(y.wi)[0]
        for x, y in ((a, b), (b, a))
    )
    np.testing.assert_allclose(there, back, rtol=1e-4)


def test_diffuse_reflectance_is_what_a_thick_piece_sends_out():
    bsdf = mi.load_dict(_dict(unit=2.0))
    expected = [color.albedo_to_color(1.0 / (1.0 + a), 1.3) for a in (0.01, 0.1, 1.0)]
    found = np.array(bsdf.diffuse_reflectance(_interaction(1, 0), mi.Bool(True))).ravel()
    np.testing.assert_allclose(found, expected, rtol=1e-4)


@pytest.mark.parametrize("shape", ["sphere", "cube"])
def test_path_shows_what_the_model_brdf_shows(shape):
    """z-test; fails a right program with probability `measure.FALSE_ALARM`."""
    scene = mi.load_dict(scenes.trial(scenes.Trial(shape, "skin"), "translucent"))
    path = measure.passes(scene, {"type": "path"}, 128, 12, 100)
    own = measure.passes(scene, scenes.ours(model="brdf"), 128, 12, 900)
    measure.assert_same(own, path)


def test_path_shows_nearly_the_model_brdf_on_a_rough_surface():
    """What enters follows the microfacets in one and the plain Fresnel term in the other."""
    scene = mi.load_dict(scenes.trial(scenes.Trial("sphere", "skin", alpha=0.3), "translucent"))
    path, own = (measure.picture(scene, i, 2048) for i in ({"type": "path"}, scenes.ours(model="brdf")))
    assert own.mean() == pytest.approx(path.mean(), rel=0.05)


def test_parameters_can_be_traversed_and_changed():
    scene = mi.load_dict(scenes.trial(scenes.Trial("sphere", "skin"), "translucent"))
    before = measure.picture(scene, scenes.ours())
    parameters = mi.traverse(scene)
    keys = [str(key) for key, _ in parameters if "sigma_a" in str(key)]
    assert keys
    parameters[keys[0]] = parameters[keys[0]] * 20
    parameters.update()
    assert measure.picture(scene, scenes.ours()).mean() < 0.9 * before.mean()


@pytest.mark.parametrize("material", ["jade", "Skim Milk", "coke", "spectralon"])
def test_named_materials_load(material):
    assert "Translucent[" in str(mi.load_dict({"type": "translucent", "material": material}))


def test_a_users_g_keeps_a_named_materials_reduced_scattering():
    si = _interaction(1, 0)
    reduced = []
    for g in (0.0, 0.9):
        bsdf = mi.load_dict({"type": "translucent", "material": "skim milk", "g": g})
        reduced.append(np.array(bsdf.coefficients(si, True)[1]).ravel() * (1 - g))
    np.testing.assert_allclose(*reduced, rtol=1e-5)
    np.testing.assert_allclose(reduced[0], scenes.SKIM_MILK[1], rtol=1e-5)
