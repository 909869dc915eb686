"""Scenes from parts and from files."""

from __future__ import annotations

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

from nephrite import materials
from nephrite.errors import ParameterError
from nephrite.physics.medium import Medium
from nephrite.plugins.media import identity
from nephrite.scene import build, named
from nephrite.scene.translucent import object_mask, translucent_shapes

GLASS = {"type": "dielectric"}
SCENE = """<scene version="3.0.0">
  <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="8"/>
    <integer name="height" value="6"/></film></sensor>
  <shape type="sphere" id="ball"><transform name="to_world"><translate z="4"/></transform>{inside}</shape>
  <emitter type="constant"/>
</scene>"""
FOGGY = '<bsdf type="dielectric"/><medium name="interior" type="homogeneous"/>'


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def without_integrator(scene: dict) -> mi.Scene:
    return mi.load_dict({name: part for name, part in scene.items() if name != "integrator"})


def scene_file(folder: Path, text: str) -> Path:
    path = folder / "scene.xml"
    path.write_text(text)
    return path


def test_the_object_has_its_size_stands_on_the_floor_and_is_in_the_picture() -> None:
    scene = without_integrator(build.scene_dict(named.find("cube"), GLASS, 50.0, resolution=(40, 30)))
    box = next(shape for shape in scene.shapes() if shape.id() == build.OBJECT).bbox()
    low, high = np.array(box.min), np.array(box.max)
    assert np.max(high - low) == pytest.approx(50.0, rel=1e-5)
    assert low[1] == pytest.approx(0.0, abs=1e-4)
    assert list(scene.sensors()[0].film().size()) == [40, 30]


def test_a_mesh_file_and_the_mesh_itself_give_the_same_scene(tmp_path: Path) -> None:
    from nephrite.scene import meshes

    mesh = named.find("sphere")
    path = meshes.write_ply(mesh, tmp_path / "sphere.ply")
    boxes = []
    for source in (mesh, path, str(path)):
        scene = without_integrator(build.scene_dict(source, GLASS, 20.0))
        box = next(shape for shape in scene.shapes() if shape.id() == build.OBJECT).bbox()
        boxes.append([np.array(box.min), np.array(box.max)])
    np.testing.assert_allclose(boxes[1], boxes[0], atol=1e-3)
    np.testing.assert_allclose(boxes[2], boxes[0], atol=1e-3)


def test_the_integrator_carries_what_was_asked_for() -> None:
    asked = build.integrator_dict("dipole", "reduced + single", "exact", max_depth=7)
    assert asked == {
        "type": "translucent_path",
        "model": "dipole",
        "terms": "reduced+single",
        "exit": "exact",
        "max_depth": 7,
    }


def test_models_that_need_more_are_given_it(tmp_path: Path) -> None:
    file = tmp_path / "skin.csv"
    file.write_text("0 .1\n1 .05\n")
    asked = build.integrator_dict("measured", profile=file)
    assert (asked["model"], asked["profile"]) == ("measured", str(file))
    assert build.integrator_dict("multipole", thickness=5.0)["thickness"] == 5.0
    assert "thickness" not in build.integrator_dict("multipole")


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"model": "measured"}, "needs a profile"),
        ({"model": "measured", "profile": "none.csv"}, "cannot read the profile none.csv"),
        ({"model": "walk", "profile": "a.csv"}, "belongs to the model measured"),
        ({"model": "dipole", "thickness": 1.0}, "belongs to the model multipole"),
        ({"model": "multipole", "thickness": -1.0}, "above 0"),
        ({"model": "wlak"}, "Did you mean 'walk'"),
        ({"exit": "exakt"}, "Did you mean 'exact'"),
        ({"terms": "singel"}, "Did you mean 'single'"),
        ({"terms": "single+single"}, "twice"),
        ({"terms": ""}, "unknown term"),
        ({"terms": "all+single"}, "unknown term 'all'"),
    ],
)
def test_unknown_models_terms_and_exits_are_refused(values: dict, says: str) -> None:
    with pytest.raises(ParameterError, match=says):
        build.integrator_dict(**values)


def test_a_material_of_ones_own_reaches_the_bsdf_in_millimetres() -> None:
    own = materials.Material("mine", Medium((0.1, 0.2, 0.3), (1, 2, 3), 0.5, 1.4), emission=(1, 0, 0))
    plugin = build.bsdf_dict(own, 0.2)
    assert plugin["sigma_a"]["value"] == [0.1, 0.2, 0.3]
    assert plugin["sigma_s"]["value"] == [1, 2, 3]
    assert plugin["emission"]["value"] == [1, 0, 0]
    assert (plugin["g"], plugin["int_ior"], plugin["alpha"], plugin["unit"]) == (0.5, 1.4, 0.2, 1.0)
    assert build.bsdf_dict("jade")["material"] == "jade"
    assert build.bsdf_dict(GLASS) is GLASS


@pytest.mark.parametrize("alpha", [-0.1, 1.1, float("nan")])
def test_an_impossible_roughness_is_refused(alpha: float) -> None:
    with pytest.raises(ParameterError, match="alpha"):
        build.bsdf_dict("jade", alpha)


def test_a_scene_file_gets_the_resolution_asked_for(tmp_path: Path) -> None:
    path = scene_file(tmp_path, SCENE.format(inside=FOGGY))
    assert list(build.load_xml(path).sensors()[0].film().size()) == [8, 6]
    scene = build.load_xml(path, (20, 10))
    assert mi.render(scene, integrator=mi.load_dict({"type": "direct"}), spp=1).shape == (10, 20, 3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (SCENE.format(inside='<bsdf type="diffuse"/>'), "no translucent object"),
        (SCENE.format(inside='<bsdf type="dielectric"/>'), "no translucent object"),
        ("<scene", "cannot load"),
        ("", "cannot load"),
        ('<scene version="3.0.0"/>', "no sensor"),
        ('<bsdf version="3.0.0" type="diffuse"/>', "cannot load|not a whole"),
    ],
)
def test_a_scene_file_that_cannot_be_rendered_is_refused(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(ParameterError, match=says):
        build.load_xml(scene_file(tmp_path, text))
    with pytest.raises(ParameterError, match="no scene file"):
        build.load_xml(tmp_path / "missing.xml")


def test_the_mask_shows_where_the_translucent_object_is(tmp_path: Path) -> None:
    scene = build.load_xml(scene_file(tmp_path, SCENE.format(inside=FOGGY)), (60, 40))
    assert [shape.id() for shape in translucent_shapes(scene)] == ["ball"]
    mask = object_mask(scene)
    assert mask.shape == (40, 60)
    rows, columns = np.nonzero(mask)
    assert (rows.mean(), columns.mean()) == pytest.approx((19.5, 29.5), abs=0.1)
    radius = np.sqrt(mask.sum() / np.pi) / 30 * np.tan(np.radians(scene_fov(scene)) / 2)
    assert radius == pytest.approx(1 / np.sqrt(15), rel=0.05)


def scene_fov(scene: mi.Scene) -> float:
    return float(mi.traverse(scene.sensors()[0])["x_fov"].numpy()[0])


def test_the_shapes_of_a_scene_file_keep_their_order_and_numbers(tmp_path: Path) -> None:
    """With other numbers Dr.Jit would compile another kernel, each time that a scene is loaded."""
    lamp = '<shape type="{kind}" id="{name}"><emitter type="area"/></shape>'
    lamps = [
        lamp.format(kind=kind, name=f"lamp{n}") for n, kind in enumerate(("cube", "rectangle", "sphere") * 3)
    ]
    text = SCENE.format(inside=FOGGY).replace("<emitter", "".join(lamps) + "<emitter")
    path = scene_file(tmp_path, text)
    scenes = [build.load_xml(path) for _ in range(10)]  # kept, so that no number is given twice
    for scene in scenes:
        assert [shape.id() for shape in scene.shapes()] == ["ball", *(f"lamp{n}" for n in range(9))]
        assert np.all(np.diff([identity(shape) for shape in scene.shapes()]) > 0)
