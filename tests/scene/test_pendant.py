import numpy as np
import pytest

from nephrite.geometry.topology import edges_of
from nephrite.scene import pendant
from nephrite.scene.isosurface import polygonise
from nephrite.scene.meshes import from_arrays


def test_a_ball_is_found_where_it_is():
    ball = lambda x, y, z: np.sqrt((x - 1) ** 2 + y**2 + z**2) - 2  # noqa: E731
    vertices, faces = polygonise(ball, np.array([-2.0, -3, -3]), np.array([4.0, 3, 3]), 0.2)
    assert np.linalg.norm(vertices - [1, 0, 0], axis=1) == pytest.approx(2, abs=1e-4)
    mesh = from_arrays(vertices, faces, "ball")
    assert not mesh.report.findings
    assert mesh.closed
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 8, rel=0.01)
    euler = len(mesh.vertices) - len(edges_of(mesh.faces).faces_at) + len(mesh.faces)
    assert euler == 2


def test_the_pendant_is_one_closed_piece_and_the_same_each_time():
    mesh, again = pendant.carve(0.8), pendant.carve(0.8)
    assert mesh.closed
    assert mesh.report.parts == 1
    assert mesh.extents == pytest.approx([60, 70, 14], abs=1)
    assert (mesh.vertices == again.vertices).all()


@pytest.mark.slow
def test_the_pendant_at_its_full_resolution_is_cached(tmp_path, monkeypatch):
    monkeypatch.setenv("NEPHRITE_CACHE", str(tmp_path))
    mesh = pendant.make()
    assert mesh.closed
    assert mesh.report.parts == 1
    assert 100_000 < len(mesh.faces) < 210_000
    assert mesh.volume == pytest.approx(9570, rel=0.01)
    # Pierced: as many handles as there are openings.
    euler = len(mesh.vertices) - len(edges_of(mesh.faces).faces_at) + len(mesh.faces)
    assert euler < -20
    monkeypatch.setattr(pendant, "carve", lambda: pytest.fail("carved again"))
    kept = pendant.make()
    assert kept.closed
    assert kept.volume == pytest.approx(mesh.volume, rel=1e-5)
