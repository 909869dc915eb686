import pytest

from nephrite import materials
from nephrite.errors import ParameterError
from nephrite.materials import Material
from nephrite.physics import Medium


@pytest.fixture
def mine():
    material = materials.register(Material("My Stone", Medium(0.1, 1.0)))
    yield material
    materials.unregister("My Stone")


@pytest.mark.parametrize("name", ["white jade", "White-Jade", "WHITE_JADE", "whitejade", "white-jade"])
def test_spelling_does_not_matter(name):
    assert materials.find(name).name == "white-jade"


@pytest.mark.parametrize(
    ("published", "ours"),
    [
        ("Skimmilk", "skim-milk"),
        ("Chicken1", "chicken-1"),
        ("Wholemilk", "whole-milk"),
        ("Head & Shoulders Shampoo", "head-and-shoulders-shampoo"),
        ("Pacific Ocean Surface Water", "pacific-ocean-surface-water"),
    ],
)
def test_names_as_published_are_found(published, ours):
    assert materials.find(published).name == ours


def test_names_are_unique_and_all_found():
    names = materials.names()
    assert len(set(names)) == len(names) == len(materials.all_materials())
    assert all(materials.find(name).name == name for name in names)


def test_an_unknown_name_suggests_the_nearest():
    with pytest.raises(ParameterError, match=r"unknown material 'marbel'\. Did you mean 'marble'"):
        materials.find("marbel")
    with pytest.raises(ParameterError, match="material is 3"):
        materials.find(3)  # type: ignore[arg-type]


def test_a_registered_material_is_found_like_the_others(mine):
    assert materials.find("my-stone") is mine
    assert materials.names()[-1] == "My Stone"
    assert materials.register(Material("My Stone", Medium(0.1, 1.0))) == mine
    assert materials.names().count("My Stone") == 1


def test_a_name_means_one_thing(mine):
    with pytest.raises(ParameterError, match="already 'My Stone'"):
        materials.register(Material("my stone", Medium(0.2, 1.0)))
    with pytest.raises(ParameterError, match="already 'marble'"):
        materials.register(Material("Marble", Medium(0.2, 1.0)))


def test_only_what_was_added_can_be_removed():
    with pytest.raises(ParameterError, match="unknown registered material"):
        materials.unregister("jade")
    assert materials.find("jade")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": ""}, "name is ''"),
        ({"name": " -"}, "name is ' -'"),
        ({"kind": "guess"}, "kind of material"),
        ({"emission": (1, -1, 0)}, "emission"),
    ],
)
def test_impossible_materials_are_refused(arguments, message):
    with pytest.raises(ParameterError, match=message):
        Material(**({"name": "a", "medium": Medium(1, 1)} | arguments))


def test_exports():
    assert sorted(materials.__all__) == materials.__all__
    assert all(hasattr(materials, name) for name in materials.__all__)
