"""Every bad parameter is an error that names the parameter, its value and what to do instead.

Mitsuba hands on what a Python plugin raises as a `RuntimeError` that holds the text of ours.
"""

import math
import re

import mitsuba as mi
import pytest

from nephrite.errors import ParameterError
from support import scenes

NAN, INF = math.nan, math.inf
GOOD = {"sigma_a": 0.1, "sigma_s": 1.0}


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({}, "no medium; give either material, or sigma_a and sigma_s, or albedo and radius"),
        ({"material": "jaed"}, "unknown material 'jaed'. Did you mean 'jade'"),
        ({"material": "jade", "sigma_a": 0.1}, "material, sigma_a"),
        ({"sigma_a": 0.1}, "sigma_a"),
        ({"sigma_s": 0.1}, "sigma_s"),
        ({"albedo": 0.5}, "albedo"),
        ({"albedo": 0.5, "radius": 1.0, "sigma_a": 1.0, "sigma_s": 1.0}, "give either"),
        ({"sigma_a": -1.0, "sigma_s": 1.0}, "sigma_a is .*-1.*not negative"),
        ({"sigma_a": scenes.rgb((0.1, -0.2, 0.1)), "sigma_s": 1.0}, "sigma_a is .*-0.2.*not negative"),
        ({"sigma_a": NAN, "sigma_s": 1.0}, "sigma_a is .*nan.*finite"),
        ({"sigma_a": 0.1, "sigma_s": INF}, "sigma_s is .*inf.*finite"),
        ({"sigma_a": "much", "sigma_s": 1.0}, "sigma_a is 'much'.*number"),
        ({"albedo": 1.2, "radius": 1.0}, r"albedo is .*1.2.*\[0, 1\]"),
        ({"albedo": scenes.rgb((0.5, 0.5, -0.1)), "radius": 1.0}, r"albedo is .*\[0, 1\]"),
        ({"albedo": 0.5, "radius": -1.0}, "radius is .*-1.*not negative"),
        ({**GOOD, "g": 1.0}, "g is 1.*strictly between -1 and 1"),
        ({**GOOD, "g": -1.5}, "g is -1.5"),
        ({**GOOD, "g": NAN}, "g is nan"),
        ({**GOOD, "int_ior": 0.0}, "int_ior is 0.*above 0"),
        ({**GOOD, "int_ior": -1.3}, "int_ior is -1.3"),
        ({**GOOD, "ext_ior": NAN}, "ext_ior is nan"),
        ({**GOOD, "int_ior": "watr"}, "int_ior is 'watr'.*water"),
        ({**GOOD, "alpha": -0.1}, "alpha is -0.1"),
        ({**GOOD, "alpha": 1.5}, "alpha is 1.5"),
        ({**GOOD, "unit": 0.0}, "unit is 0.*length of one scene unit in mm"),
        ({**GOOD, "unit": -1.0}, "unit is -1"),
        ({**GOOD, "unit": "mm"}, "unit is 'mm'"),
        ({**GOOD, "emission": -0.1}, "emission is .*-0.1"),
    ],
    ids=str,
)
def test_bsdf(parameters, message):
    with pytest.raises(RuntimeError, match=f"ParameterError: .*{message}"):
        mi.load_dict({"type": "translucent", **parameters})


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"model": "wlak"}, "unknown model 'wlak'. Did you mean 'walk'"),
        ({"exit": "exat"}, "unknown exit 'exat'. Did you mean 'exact'"),
        ({"terms": "singel"}, "unknown term 'singel'. Did you mean 'single'"),
        ({"max_depth": -2}, "max_depth is -2"),
        ({"max_depth": 2.5}, "max_depth is 2.5"),
        ({"rr_depth": 0}, "rr_depth is 0"),
        ({"max_steps": 0}, "max_steps is 0"),
        ({"model": "measured"}, "the model measured needs a profile: name a CSV file"),
        ({"model": "measured", "profile": "none.csv"}, "cannot read the profile none.csv"),
        (
            {"model": "dipole", "profile": "a.csv"},
            "profile is 'a.csv', but the model is dipole.*model measured",
        ),
        ({"thickness": 2.0}, "thickness is 2.0, but the model is walk.*the model multipole; leave out"),
        ({"model": "multipole", "thickness": 0.0}, "thickness is 0.0; it must be a length in mm, above 0"),
        ({"model": "multipole", "thickness": INF}, "thickness is inf.*Without it a slab has no end"),
        ({"model": "multipole", "thickness": "5mm"}, "thickness is '5mm'; it must be a length in mm"),
    ],
    ids=str,
)
def test_integrator(parameters, message):
    with pytest.raises(RuntimeError, match=f"ParameterError: .*{message}"):
        mi.load_dict(scenes.ours(**parameters))


@pytest.mark.usefixtures("switching")
@pytest.mark.parametrize(
    ("variant", "message"),
    [
        ("llvm_ad_mono", "columns for red, green and blue, but llvm_ad_mono.*give one"),
        ("llvm_ad_spectral", "columns for red, green and blue.*use an rgb variant"),
    ],
)
def test_channels_that_a_variant_lacks(variant, message, tmp_path):
    mi.set_variant(variant)
    file = tmp_path / "three.csv"
    file.write_text("0 .1 .2 .1\n1 .05 .1 .1\n")
    with pytest.raises(RuntimeError, match=f"ParameterError: .*{message}"):
        mi.load_dict(scenes.ours(model="measured", profile=str(file)))


@pytest.mark.parametrize(
    "plugin", [{"type": "translucent", **GOOD, "sigma_z": 1.0}, scenes.ours(modle="walk")], ids=str
)
def test_misspelt_parameters_are_not_ignored(plugin):
    with pytest.raises(RuntimeError, match=r"sigma_z|modle"):
        mi.load_dict(plugin)


def _refused(scene, message):
    """Assert that rendering fails for our reason, which Dr.Jit hands on as the cause of its own error."""
    loaded, method = mi.load_dict(scene), mi.load_dict(scenes.ours())
    with pytest.raises(Exception) as raised:  # noqa: PT011
        mi.render(loaded, integrator=method, spp=1)
    error = raised.value
    while error is not None and not isinstance(error, ParameterError):
        error = error.__cause__ or error.__context__
    assert error is not None, f"{raised.value} does not come from a ParameterError"
    assert re.search(message, str(error)), error


def test_a_medium_behind_a_surface_that_lets_nothing_in():
    scene = scenes.camera(4)
    medium = scenes.standard(0.1, 1.0)["interior"]
    scene["object"] = scenes.placed("sphere") | {"bsdf": {"type": "diffuse"}, "interior": medium, "id": "pot"}
    _refused(scene, r"'pot'.*needs a dielectric, roughdielectric or translucent")


def test_a_medium_that_is_not_homogeneous():
    scene = scenes.camera(4)
    medium = {"type": "heterogeneous", "albedo": 0.5, "sigma_t": {"type": "constvolume", "value": 1.0}}
    scene["object"] = scenes.placed("sphere") | {
        "bsdf": {"type": "dielectric"},
        "interior": medium,
        "id": "cloud",
    }
    _refused(scene, r"'cloud'.*homogeneous.*volpathmis")


def test_a_phase_function_that_is_not_known():
    scene = scenes.camera(4)
    inside = scenes.standard(0.1, 1.0)
    inside["interior"]["phase"] = {"type": "rayleigh"}
    scene["object"] = scenes.placed("sphere") | inside | {"id": "sky"}
    _refused(scene, r"'sky'.*phase function.*isotropic and hg")
