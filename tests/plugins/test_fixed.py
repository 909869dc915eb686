"""Measured profiles and slabs in the integrator: lookups, lengths, and pictures against models and the walk."""

import mitsuba as mi
import numpy as np
import pytest

from nephrite.bssrdf import fixed, kernel
from nephrite.physics.single import single_scattering_share
from nephrite.plugins.fixed import Measured, Slabs
from nephrite.plugins.media import Media
from nephrite.profiles import find
from nephrite.profiles.measured import MeasuredProfile
from nephrite.scene.translucent import object_mask
from support import measure, scenes

SIGMA_A, SIGMA_S = (0.0014, 0.0025, 0.0142), (0.70, 1.22, 1.90)
RADII = [0.1, 0.4, 1.0, 1.7, 4.0]
THREE = tuple(MeasuredProfile(RADII, np.array([0.1, 0.08, 0.02, 0.01, 0.0]) * k) for k in (1.0, 0.6, 0.3))


def _entries(**bsdf):
    scene = scenes.camera(4)
    scene["object"] = scenes.placed("slab") | scenes.translucent(SIGMA_A, SIGMA_S)
    scene["object"]["bsdf"] |= bsdf
    return Media.of(mi.load_dict(scene)).entries


def _lookup(kernels, r, far=False, unit=1.0):
    coefficients = (mi.Spectrum(x) * unit for x in (SIGMA_A, SIGMA_S))
    place = kernels.place(mi.UInt32(1), *coefficients, mi.Float(0))
    up = mi.Vector3f(0, 0, 1)
    offset = mi.Vector3f(mi.Float(r / unit), 0, 0)
    return np.exp2(np.array(kernels.between(place, None, offset, up, -up if far else up)))


@pytest.mark.parametrize("columns", [1, 3])
@pytest.mark.parametrize("unit", [1.0, 10.0])
def test_a_measured_profile_is_in_millimetres_and_gives_up_single_scattering(columns, unit):
    """Some 2 % are interpolation, where the profile has corners."""
    r = np.geomspace(0.05, 3.3, 50)
    found = _lookup(Measured(_entries(unit=unit), THREE[:columns]), r, unit=unit)
    for i in range(3):
        profile = THREE[i % columns]
        albedo = SIGMA_S[i] / (SIGMA_A[i] + SIGMA_S[i])
        multiple = 1.0 - albedo * single_scattering_share(0.0, 1.3) / profile.albedo()
        assert found[i] == pytest.approx(profile.eval(r) * multiple * unit**2, rel=0.03)


def test_a_measured_profile_below_single_scattering_sends_nothing():
    dark = tuple(MeasuredProfile(RADII, np.array([0.1, 0.08, 0.02, 0.01, 0.0]) * k) for k in (1.0, 0.05, 1.0))
    red, green, _ = _lookup(Measured(_entries(), dark), np.array([0.5]))[:, 0]
    assert red > 0.01
    assert green < 1e-20


@pytest.mark.parametrize("unit", [1.0, 10.0])
def test_slabs_tell_their_faces_apart(unit):
    """On the far one the distance is that along the face."""
    kernels = Slabs(_entries(unit=unit), 2.0)
    along = np.geomspace(0.01, 20.0, 200)
    chord = np.sqrt(along**2 + 4.0)
    found = (_lookup(kernels, along, False, unit), _lookup(kernels, chord, True, unit))
    for i in range(3):
        totals = _totals(SIGMA_A[i], SIGMA_S[i], 2.0)
        for total, face in zip(totals, found, strict=True):
            ring = face[i] / unit**2 * 2.0 * np.pi * along**2
            assert np.trapezoid(ring, np.log(along)) == pytest.approx(total, rel=0.02)


def _totals(sigma_a, sigma_s, thickness):
    """Return what leaves both faces after two events or more, isotropic and behind an index of 1.3."""
    extinction = sigma_a + sigma_s
    table = fixed.slabs((thickness * extinction,), 1.3, 0.0)
    rows = fixed.totals(table).reshape(2, -1)
    return [np.interp(sigma_a / extinction, 1.0 - kernel.albedos(), row) for row in rows]


@pytest.mark.usefixtures("switching")
@pytest.mark.parametrize("variant", ["llvm_ad_rgb", "llvm_ad_spectral"])
def test_slabs_follow_coefficients_that_vary(variant):
    """What leaves both faces of a slab of 4 mm, for media between those of a texture."""
    mi.set_variant(variant)
    texture = {"type": "checkerboard", "color0": scenes.rgb(0.1), "color1": scenes.rgb(0.9)}
    kernels = Slabs(_entries(sigma_a=scenes.rgb(0.02), sigma_s=texture), 4.0)
    along, up = np.geomspace(0.01, 30.0, 200), mi.Vector3f(0, 0, 1)
    for sigma_s in (0.1, 0.17, 0.5, 0.9):
        place = kernels.place(mi.UInt32(1), mi.Spectrum(0.02), mi.Spectrum(sigma_s), mi.Float(0))
        for face, total in zip((up, -up), _totals(0.02, sigma_s, 4.0), strict=True):
            chord = np.sqrt(along**2 + (16.0 if face is not up else 0.0))
            offset = mi.Vector3f(mi.Float(chord), 0, 0)
            values = np.exp2(np.array(kernels.between(place, None, offset, up, face)))
            rings = np.trapezoid(values * 2.0 * np.pi * along**2, np.log(along), axis=-1)
            assert rings == pytest.approx(total, rel=0.02)


def test_light_crosses_a_slab_of_two_materials_alike_both_ways():
    """Reciprocity."""
    texture = {"type": "checkerboard", "color0": scenes.rgb(0.2), "color1": scenes.rgb(0.8)}
    kernels = Slabs(_entries(sigma_a=scenes.rgb(0.02), sigma_s=texture), 2.0)
    here, there = (
        kernels.place(mi.UInt32(1), mi.Spectrum(0.02), mi.Spectrum(s), mi.Float(0)) for s in (0.2, 0.8)
    )
    up, offset = mi.Vector3f(0, 0, 1), mi.Vector3f(0.7, 0, 2.0)
    for face in (up, -up):
        one = np.array(kernels.between(here, there, offset, up, face))
        other = np.array(kernels.between(there, here, -offset, face, up))
        assert one == pytest.approx(other, rel=1e-6)


def _plate(turned=False, unit=1.0, half=1.0):
    """A plate lit from behind and seen in its middle."""
    t = mi.ScalarTransform4f
    scene = scenes.camera(8, fov=14.0)
    scene["object"] = {"type": "cube", "flip_normals": turned, "to_world": t().scale([12, 12, half])}
    scene["object"] |= scenes.translucent(SIGMA_A, SIGMA_S)
    scene["light"] = scenes.light((0.3, 0.2, -1.0), 24.0, 10.0)
    if unit != 1.0:
        scene["object"]["bsdf"]["unit"] = unit
        for name in ("object", "light", "sensor"):
            scene[name]["to_world"] = t().scale(1.0 / unit) @ scene[name]["to_world"]
        look = t().look_at(origin=[0, 0, 55 / unit], target=[0, 0, 0], up=[0, 1, 0])
        scene["sensor"]["to_world"] = look
    return scene


@pytest.mark.slow
@pytest.mark.parametrize(("half", "limit", "part"), [(0.4, 0.10, 0.75), (1.0, 0.06, 0.4), (2.0, 0.06, 0.4)])
def test_a_multipole_transmits_what_the_walk_does(half, limit, part):
    """Within the limit, two standard errors of .7 % included, and part of the dipole's error.

    The thinnest plate has half a mean free path: there diffusion itself is 6 % too bright in red, and the dipole, which
    takes both faces for one surface, 12 % too dark in blue. On the others the dipole is 20 to 45 % off.
    """
    scene = mi.load_dict(_plate(half=half))
    mask = object_mask(scene)

    def light(**parameters):
        return (
            measure.passes(scene, scenes.ours(terms="single+multiple", **parameters), 512, 16, 1)
            .total(mask)
            .mean(0)
        )

    walk = light(model="walk")
    slab = light(model="multipole", thickness=2.0 * half) / walk - 1.0
    dipole = light(model="dipole") / walk - 1.0
    print(half, np.round(100 * slab, 1), np.round(100 * dipole, 1))
    assert np.all(np.abs(slab) < limit)
    assert np.linalg.norm(slab) < part * np.linalg.norm(dipole)


@pytest.mark.slow
@pytest.mark.parametrize("change", [{"turned": True}, {"unit": 10.0}], ids=str)
@pytest.mark.parametrize("model", ["multipole", "measured"])
def test_windings_and_units_change_nothing(model, change, tmp_path):
    """Statistical: a right program fails with probability `measure.FALSE_ALARM`."""
    details = {"thickness": 2.0} if model == "multipole" else {"profile": _file(tmp_path, THREE)}
    method = scenes.ours(model=model, **details)
    one, other = (
        measure.passes(_plate(), method, 64, 8, 100),
        measure.passes(_plate(**change), method, 64, 8, 900),
    )
    measure.assert_same(one, other, label=f"{model} {change}")


@pytest.mark.slow
def test_a_dipole_from_a_file_is_the_dipole(tmp_path):
    """Statistical: a right program fails with probability `measure.FALSE_ALARM`."""
    r = np.geomspace(1e-3, 300.0, 500)
    dipoles = [
        find("dipole").make(a, s, 1.3) for a, s in zip((0.02, 0.05, 0.1), (0.7, 0.9, 1.2), strict=True)
    ]
    file = tmp_path / "dipole.csv"
    np.savetxt(file, np.stack([r, *(dipole.eval(r) for dipole in dipoles)], axis=1), delimiter=",")
    scene = scenes.camera(12)
    scene["object"] = scenes.placed("cube") | scenes.translucent((0.02, 0.05, 0.1), (0.7, 0.9, 1.2))
    scene["light"] = scenes.light((0.7, 0.5, 0.4), 24.0, 8.0)
    one = measure.passes(scene, scenes.ours(model="measured", profile=str(file)), 64, 10, 100)
    other = measure.passes(scene, scenes.ours(model="dipole"), 64, 10, 900)
    measure.assert_same(one, other, label="dipole from a file")


@pytest.mark.slow
def test_a_plate_with_a_texture_of_one_colour_is_an_even_one():
    """Statistical: a right program fails with probability `measure.FALSE_ALARM`."""
    pictures = []
    for seed, varies in ((100, False), (900, True)):
        scene = _plate()
        for key, value in (("sigma_a", 0.01), ("sigma_s", 0.8)):
            even = scenes.rgb(value)
            texture = {"type": "checkerboard", "color0": even, "color1": even}
            scene["object"]["bsdf"][key] = texture if varies else even
        pictures.append(measure.passes(scene, scenes.ours(model="multipole", thickness=2.0), 128, 16, seed))
    measure.assert_same(*pictures, label="texture")


def _file(folder, profiles):
    file = folder / "profile.csv"
    columns = [RADII, *(profile.eval(np.array(RADII)) for profile in profiles)]
    np.savetxt(file, np.array(columns).T, delimiter=",")
    return str(file)


def test_a_scene_file_finds_the_profile_beside_it(tmp_path):
    _file(tmp_path, THREE)
    scene = tmp_path / "scene.xml"
    scene.write_text(
        '<scene version="3.0.0"><integrator type="translucent_path"><string name="model" value="measured"/>'
        '<string name="profile" value="profile.csv"/></integrator></scene>'
    )
    assert "measured" in str(mi.load_file(str(scene)).integrator())


@pytest.mark.usefixtures("switching")
@pytest.mark.parametrize("model", ["multipole", "measured"])
@pytest.mark.parametrize("variant", ["llvm_ad_mono", "llvm_ad_spectral"])
def test_a_grey_ball_is_the_same_in_all_variants(variant, model, tmp_path):
    """Brightness, within four standard errors and 2 %, of what the variant for colours says."""
    details = {"thickness": 3.0} if model == "multipole" else {"profile": _file(tmp_path, THREE[:1])}
    method = scenes.ours(model=model, **details)
    found = []
    for name in (variant, "llvm_ad_rgb"):
        mi.set_variant(name)
        scene = scenes.camera(8, fov=14.0, pixel_format="luminance" if "mono" in name else "rgb")
        scene["object"] = {"type": "sphere", "to_world": mi.ScalarTransform4f().scale(5)}
        scene["object"]["bsdf"] = {"type": "translucent", "sigma_a": 0.02, "sigma_s": 1.0}
        scene["environment"] = {"type": "constant", "radiance": 1.0}
        found.append(measure.passes(scene, method, 128, 4, 10).total().mean(1))
    (one, other), errors = (x.mean() for x in found), [x.std(ddof=1) / 2 for x in found]
    assert one == pytest.approx(other, rel=0.02, abs=4 * np.hypot(*errors))
