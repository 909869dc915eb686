import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.scene import meshes, primitives
from nephrite.scene.meshes import from_arrays

TALL = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=np.float64) + np.array([5, 6, 7])
WEDGE = from_arrays(TALL, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), "wedge")


def test_stands_on_the_ground_centred_with_its_size():
    mesh = meshes.placed(WEDGE, 60.0)
    assert mesh.bounds == pytest.approx(np.array([[-10, 0, -30], [10, 40, 30]]))
    assert mesh.volume == pytest.approx(20**3)
    assert mesh.report.volume == pytest.approx(20**3)
    assert mesh.closed


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_the_named_axis_points_up_and_nothing_is_mirrored(up):
    mesh = meshes.placed(WEDGE, 3.0, up=up)
    assert mesh.volume == pytest.approx(WEDGE.volume)
    axis = "xyz".index(up[-1])
    along = WEDGE.vertices[:, axis] * (-1 if up.startswith("-") else 1)
    assert mesh.vertices[:, 1] == pytest.approx(along - along.min())


def test_placing_twice_is_placing_once():
    once = meshes.placed(primitives.slab(), 80.0)
    assert meshes.placed(once, 80.0).vertices == pytest.approx(once.vertices)


@pytest.mark.parametrize("size", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_size(size):
    with pytest.raises(ParameterError, match="longest side"):
        meshes.placed(WEDGE, size)


def test_bad_axis():
    with pytest.raises(ParameterError, match="unknown axis"):
        meshes.placed(WEDGE, 1.0, up="w")
