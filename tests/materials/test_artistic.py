import pytest

from nephrite import materials

ARTISTIC = [material for material in materials.all_materials() if material.kind == "artistic"]


def test_the_promised_ones_are_there():
    names = {material.name for material in ARTISTIC}
    assert {"jade", "white-jade", "wax", "alabaster", "soap", "amber", "milk-glass", "candle"} <= names
    assert len(names) >= 20


@pytest.mark.parametrize("material", ARTISTIC, ids=lambda m: m.name)
def test_each_says_what_it_is_and_how_it_was_chosen(material):
    assert material.source == "chosen for Nephrite"
    assert len(material.note) > 30
    assert material.unit == "mm"
    assert 1.3 <= material.medium.eta <= 1.7
    for channel in range(3):
        assert 0 < material.medium.diffuse_reflectance[channel] < 1
        assert 0.1 < material.medium.dmfp[channel] < 100


def test_jade_is_green_and_glows_in_thin_parts():
    medium = materials.find("jade").medium
    red, green, blue = medium.diffuse_reflectance
    assert green > 1.5 * blue > 1.5 * red
    assert medium.eta == 1.61
    assert all(0.5 <= 1 / extinct <= 2.0 for extinct in medium.sigma_t_prime)
    assert 4 < medium.dmfp[1] < 10


@pytest.mark.parametrize(("thin", "thick"), [(3.0, 30.0)])
def test_jade_lets_light_through_a_fin_but_not_through_a_body(thin, thick):
    from nephrite.materials.preview import seen_through

    medium = materials.find("jade").medium
    assert seen_through(medium, thin)[1] > 0.25
    assert seen_through(medium, thick)[1] < 0.01
    # and purer in colour by transmission than by reflection
    through, front = seen_through(medium, thin), medium.diffuse_reflectance
    assert through[1] / through[0] > front[1] / front[0] * 0.6
    assert seen_through(medium, 8.0)[1] / seen_through(medium, 8.0)[0] > front[1] / front[0]


def test_skins_darken_in_order():
    greens = [
        materials.find(f"skin-{name}").medium.diffuse_reflectance[1]
        for name in ("pale", "olive", "brown", "dark")
    ]
    assert greens == sorted(greens, reverse=True)
