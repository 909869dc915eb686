"""What must change nothing: a winding flip, a unit with its size, a switch of variants.

Statistical, with fixed seeds: each test fails a right program with probability `measure.FALSE_ALARM`.
"""

import dataclasses
import math

import mitsuba as mi
import numpy as np
import pytest

from nephrite.geometry.winding import turned_over
from nephrite.scene import named
from nephrite.scene.place import placed
from nephrite.scene.ply import write_ply
from support import measure, scenes
from support.quick import slow

SIGMA_A, SIGMA_S = (0.02, 0.05, 0.1), (0.5, 0.7, 0.9)
MODELS = [
    {"model": "walk"},
    slow({"model": "walk", "exit": "exact"}),
    slow({"model": "dipole"}),
    slow({"model": "brdf"}),
]


def _scene(shape, kind=scenes.translucent, **parameters):
    scene = scenes.camera(12)
    scene["object"] = shape | kind(SIGMA_A, SIGMA_S, **parameters)
    scene["light"] = scenes.light((0.7, 0.5, 0.4), 24.0, 8.0)
    scene["environment"] = scenes.environment(0.3)
    return scene


def _same(one, other, parameters, spp=64):
    a = measure.passes(one, scenes.ours(**parameters), spp, 10, 100)
    b = measure.passes(other, scenes.ours(**parameters), spp, 10, 900)
    measure.assert_same(a, b, label=str(parameters))


@pytest.mark.parametrize("parameters", MODELS, ids=lambda p: "-".join(p.values()))
def test_flipped_normals(parameters):
    _same(
        _scene(scenes.placed("sphere")), _scene(scenes.placed("sphere") | {"flip_normals": True}), parameters
    )


@pytest.mark.slow
def test_flipped_normals_of_a_rough_standard_object():
    flipped = scenes.placed("sphere") | {"flip_normals": True}
    one, other = (_scene(s, scenes.standard, alpha=0.3) for s in (scenes.placed("sphere"), flipped))
    _same(one, other, {"model": "walk"})


@pytest.mark.parametrize(
    ("order", "model"),
    [
        ("mixed", "walk"),
        slow("reversed", "walk"),
        slow("reversed", "dipole"),
        slow("mixed", "dipole"),
        slow("mixed, vertices not shared", "dipole"),
        slow("mixed", "tabulated"),
        slow("mixed", "directional"),
    ],
)
def test_reversed_and_mixed_faces(order, model, tmp_path):
    """Mixed windings are mended where the package reads a mesh; here Mitsuba reads them as they are."""
    mesh = placed(named.find("cube"), 14.0)
    vertices, faces = mesh.vertices, mesh.faces
    if "not shared" in order:
        vertices, faces = vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    every = 1 if order == "reversed" else 2
    changed = turned_over(faces, np.arange(len(faces)) % every == 0)
    shapes = []
    for piece in (mesh, dataclasses.replace(mesh, vertices=vertices, faces=changed)):
        path = write_ply(piece, tmp_path / f"{len(shapes)}.ply")
        shapes.append({"type": "ply", "filename": str(path), "face_normals": True})
    _same(_scene(shapes[0]), _scene(shapes[1]), {"model": model}, spp=1024)


@pytest.mark.parametrize("parameters", [MODELS[0], *MODELS[2:]], ids=lambda p: "-".join(p.values()))
def test_a_unit_with_its_size(parameters):
    """Centimetres with unit 10 for millimetres with unit 1."""
    millimetres = _scene(scenes.placed("sphere"))
    centimetres = _scene(scenes.placed("sphere"))
    centimetres["object"]["to_world"] = mi.ScalarTransform4f().scale(1.0)
    centimetres["object"]["bsdf"] |= {"unit": 10.0}
    tenth = mi.ScalarTransform4f().scale(0.1)
    centimetres["light"]["to_world"] = tenth @ centimetres["light"]["to_world"]
    look = mi.ScalarTransform4f().look_at(origin=[0, 0, 5.5], target=[0, 0, 0], up=[0, 1, 0])
    centimetres["sensor"]["to_world"] = look
    _same(millimetres, centimetres, parameters)


def _grey(pixel_format):
    """A scene whose picture is the same in every variant; made anew for each, as textures belong to variants."""
    scene = scenes.camera(12, pixel_format=pixel_format)
    scene["object"] = {"type": "sphere", "to_world": mi.ScalarTransform4f().scale(10)}
    scene["object"]["bsdf"] = {"type": "translucent", "sigma_a": 0.05, "sigma_s": 0.7}
    scene["other"] = {"type": "sphere", "center": [8.0, 8.0, 0.0], "radius": 4.0}
    scene["other"] |= scenes.standard(0.05, 0.7)
    scene["environment"] = scenes.environment(1.0)
    return scene


@pytest.mark.usefixtures("switching")
@pytest.mark.parametrize("model", ["brdf", slow("walk"), slow("dipole")])
def test_variants_agree_and_switch_back_and_forth(model):
    found = {}
    order = ("llvm_ad_rgb", "llvm_ad_mono", "llvm_ad_spectral", "scalar_rgb", "llvm_ad_rgb", "llvm_ad_mono")
    for i, variant in enumerate(order):
        mi.set_variant(variant)
        if variant == "scalar_rgb":
            continue
        scene = _grey("luminance" if "mono" in variant else "rgb")
        own = measure.passes(scene, scenes.ours(model=model), 64, 32, 100 * i)
        assert np.isfinite(own.pictures).all(), variant
        grey = measure.Passes(own.pictures.mean(3, keepdims=True))
        found.setdefault(variant, []).append(grey)
    base = found["llvm_ad_rgb"][0]
    for variant, pictures in found.items():
        for other in pictures:
            if other is not base:
                measure.assert_same(other, base, label=f"{model} in {variant}")


@pytest.mark.usefixtures("switching")
@pytest.mark.parametrize(
    "plugin", [{"type": "translucent", "material": "jade"}, {"type": "translucent_path"}]
)
def test_scalar_variants_say_what_to_do(plugin):
    mi.set_variant("scalar_rgb")
    with pytest.raises(RuntimeError, match=r"VariantError: .*scalar_rgb.*llvm_ad_rgb"):
        mi.load_dict(plugin)
    mi.set_variant("llvm_ad_rgb")
    mi.load_dict(plugin)


@pytest.mark.usefixtures("switching")
def test_polarised_variants_are_refused():
    mi.set_variant("llvm_ad_spectral_polarized")
    with pytest.raises(RuntimeError, match=r"VariantError: .*polarisation"):
        mi.load_dict({"type": "translucent_path"})


def test_a_body_within_another_has_luck_of_its_own():
    """Half a mean free path, 1.5 in the inner body, and half again; with one number for both, e^-2 would be seen."""
    scene = scenes.camera(4, fov=1.0) | {"sky": scenes.environment(1.0)}
    for name, half, sigma_a in (("outer", 5.0, 0.2), ("inner", 2.5, 0.3)):
        cube = {"type": "cube", "to_world": mi.ScalarTransform4f().scale(half)}
        scene[name] = cube | scenes.translucent(sigma_a, 0.0, eta=1.0)
    picture = measure.picture(scene, scenes.ours(), 4096)
    assert picture.mean((0, 1)) == pytest.approx(math.exp(-2.5), rel=0.06)  # five standard errors
