import numpy as np
import pytest

from nephrite.errors import MissingDependencyError, ParameterError
from nephrite.scene import dragon, named


@pytest.mark.parametrize(("name", "volume"), [("sphere", np.pi / 6), ("cube", 1.0), ("slab", 0.05)])
def test_primitives_are_closed(name, volume):
    mesh = named.find(name)
    assert mesh.closed
    assert mesh.name == name
    assert not mesh.report.findings
    assert mesh.volume == pytest.approx(volume, rel=1e-3)


def test_names():
    assert named.names() == (
        "dragon", "dragon-full", "dragon-small", "dragon-tiny", "pendant", "sphere", "cube", "slab",
    )  # fmt: skip


def test_case_and_separators_do_not_matter():
    assert named.find(" Cube ").name == "cube"


def test_unknown_name_suggests_the_nearest():
    with pytest.raises(ParameterError, match="Did you mean 'pendant'"):
        named.find("pendent")


def test_without_the_dragon_the_pendant_comes_with_a_note(monkeypatch):
    def unreachable(name):
        raise MissingDependencyError("no network here.")

    monkeypatch.setattr(dragon, "fetch", unreachable)
    monkeypatch.setattr(named.pendant, "make", named.primitives.cube)
    mesh = named.find("Dragon_Small")
    assert mesh.note == "no network here. Taking the built-in pendant instead."
