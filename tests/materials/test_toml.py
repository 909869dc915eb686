import numpy as np
import pytest

from nephrite import materials
from nephrite.errors import ParameterError
from nephrite.physics.color import albedo_to_color

TEA = """
[green-tea]
unit = "1/cm"
sigma_a = [0.02, 0.01, 0.12]
sigma_s = 0.3
g = 0.8
eta = 1.33
source = "my kitchen"
kind = "measured"
note = "second infusion"
emission = [10.0, 0.0, 0.0]
"""


@pytest.fixture
def load(tmp_path):
    def load(text):
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return materials.load_toml(path)

    return load


def test_coefficients(load):
    material = load(TEA)["green-tea"]
    assert material.medium.sigma_a == pytest.approx((0.002, 0.001, 0.012))
    assert material.medium.sigma_s == pytest.approx((0.03, 0.03, 0.03))
    assert (material.medium.g, material.medium.eta) == (0.8, 1.33)
    assert material.emission == pytest.approx((1.0, 0.0, 0.0))
    assert (material.name, material.unit) == ("green-tea", "1/cm")
    assert (material.source, material.kind, material.note) == ("my kitchen", "measured", "second infusion")


def test_reduced_scattering(load):
    material = load('[a]\nunit = "1/mm"\nsigma_a = 0\nsigma_s_prime = [1.0, 2.0, 3.0]\ng = 0.9')["a"]
    assert material.medium.sigma_s == pytest.approx((10, 20, 30))


def test_albedo_and_radius(load):
    material = load('[my-jade]\nunit = "cm"\nalbedo = [0.2, 0.5, 0.3]\nradius = 0.12\neta = 1.61')["my-jade"]
    shown = albedo_to_color(np.array(material.medium.albedo_prime), 1.61)
    assert shown == pytest.approx((0.2, 0.5, 0.3), abs=1e-3)
    assert material.medium.sigma_t_prime == pytest.approx((1 / 1.2,) * 3)
    assert material.kind == "artistic"
    assert material.source.endswith("mine.toml")


@pytest.mark.parametrize(("unit", "factor"), [("1/mm", 1.0), ("1/cm", 0.1), ("1/m", 0.001), ("1 / cm", 0.1)])
def test_units_of_coefficients(load, unit, factor):
    material = load(f'[a]\nunit = "{unit}"\nsigma_a = 1.0\nsigma_s = 5.0')["a"]
    assert material.medium.sigma_a == pytest.approx((factor,) * 3)
    assert material.medium.sigma_s == pytest.approx((5 * factor,) * 3)


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("cm", 10.0), ("m", 1000.0)])
def test_units_of_the_radius(load, unit, factor):
    material = load(f'[a]\nunit = "{unit}"\nalbedo = 0.5\nradius = 2')["a"]
    assert 1 / material.medium.sigma_t_prime[0] == pytest.approx(2 * factor)


def test_several_keep_their_order(load):
    one = '\nunit = "1/mm"\nsigma_a = 1\nsigma_s = 1\n'
    assert list(load(f"[b]{one}[a]{one}[c]{one}")) == ["b", "a", "c"]


COEFFICIENTS = 'unit = "1/mm"\nsigma_a = 1.0\nsigma_s = 1.0\n'


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("[a]\nsigma_a = 1\nsigma_s = 1", ["[a]", "no unit", 'unit = "1/mm"']),
        ("[a]\nalbedo = 0.5\nradius = 1", ["[a]", "no unit", 'unit = "mm"']),
        ('[a]\nunit = "1/in"\nsigma_a = 1\nsigma_s = 1', ["unit = '1/in'", "1/mm, 1/cm, 1/m"]),
        ('[a]\nunit = "mm"\nsigma_a = 1\nsigma_s = 1', ["unit = 'mm'", "1/mm"]),
        ('[a]\nunit = "1/mm"\nalbedo = 1\nradius = 1', ["unit = '1/mm'", "mm, cm, m"]),
        ("[a]\nunit = 1\nsigma_a = 1\nsigma_s = 1", ["unit = 1", "quotes"]),
        ('[a]\nunit = "1/mm"\nsigma_a = 1', ["sigma_a but no sigma_s"]),
        ('[a]\nunit = "1/mm"\nsigma_s = 1', ["sigma_s but no sigma_a"]),
        ('[a]\nunit = "mm"\nalbedo = 1', ["albedo but no radius"]),
        (f"[a]\n{COEFFICIENTS}albedo = 0.5", ["albedo, sigma_a, sigma_s", "either"]),
        (f"[a]\n{COEFFICIENTS}sigma_s_prime = 0.5", ["both sigma_s and sigma_s_prime"]),
        ('[a]\nnote = "empty"', ["no optical properties", "albedo and radius"]),
        (f"[a]\n{COEFFICIENTS}sigma_z = 1", ["unknown key 'sigma_z'", "Did you mean 'sigma_"]),
        ('[a]\nunit = "1/mm"\nsigma_a = -1\nsigma_s = 1', ["sigma_a is -1", "negative"]),
        ('[a]\nunit = "1/mm"\nsigma_a = nan\nsigma_s = 1', ["sigma_a is nan", "finite"]),
        ('[a]\nunit = "1/mm"\nsigma_a = 1\nsigma_s = [1, 2]', ["sigma_s is [1, 2]", "three"]),
        ('[a]\nunit = "1/mm"\nsigma_a = "1"\nsigma_s = 1', ["sigma_a is '1'", "number"]),
        ('[a]\nunit = "mm"\nalbedo = 1.5\nradius = 1', ["albedo is 1.5", "[0, 1]"]),
        ('[a]\nunit = "mm"\nalbedo = 0.5\nradius = -1', ["radius is -1", "negative"]),
        (f"[a]\n{COEFFICIENTS}g = 1.0", ["g is 1.0"]),
        (f"[a]\n{COEFFICIENTS}eta = 0", ["eta is 0"]),
        (f"[a]\n{COEFFICIENTS}emission = -1", ["emission is -1"]),
        (
            f'[a]\n{COEFFICIENTS}kind = "guessed"',
            ["unknown kind of material 'guessed'", "artistic, measured"],
        ),
        (f"[a]\n{COEFFICIENTS}[A]\n{COEFFICIENTS}", ["[A]", "same name as [a]"]),
        (f'["!"]\n{COEFFICIENTS}', ["name is '!'"]),
        ("sigma_a = 1", ["sigma_a = 1", "outside a material"]),
        ("", ["no material"]),
        ("[a\n", ["not TOML"]),
    ],
)
def test_errors_name_file_key_value_and_remedy(load, text, messages):
    with pytest.raises(ParameterError) as error:
        load(text)
    for message in ["mine.toml", *messages]:
        assert message in str(error.value)


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(ParameterError, match=r"none\.toml: there is no such file"):
        materials.load_toml(tmp_path / "none.toml")
    with pytest.raises(ParameterError, match="cannot be read"):
        materials.load_toml(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ParameterError, match="UTF-8"):
        materials.load_toml(binary)


def test_loading_does_not_register(load):
    load(TEA)
    with pytest.raises(ParameterError, match="unknown material"):
        materials.find("green-tea")
