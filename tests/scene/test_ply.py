import numpy as np
import pytest

from nephrite.errors import MeshError
from nephrite.scene import meshes, primitives
from nephrite.scene.normals import with_normals
from nephrite.scene.ply import write_atomically


def test_round_trip(tmp_path):
    ball = meshes.placed(primitives.sphere(), 100.0)
    again = meshes.load(meshes.write_ply(ball, tmp_path / "new" / "ball.ply"))
    assert again.closed
    assert len(again.faces) == len(ball.faces)
    assert again.volume == pytest.approx(ball.volume, rel=1e-6)


def test_a_ball_is_smooth():
    ball = primitives.sphere()
    places, _, normals = with_normals(ball.vertices, ball.faces)
    assert len(places) == len(ball.vertices)
    assert normals == pytest.approx(places / np.linalg.norm(places, axis=1, keepdims=True), abs=2e-3)


def test_a_cube_keeps_its_edges():
    cube = primitives.cube()
    places, _, normals = with_normals(cube.vertices, cube.faces)
    assert len(places) == 24
    assert np.sort(np.abs(normals), axis=1) == pytest.approx(np.tile([0, 0, 1], (24, 1)))
    assert np.einsum("ij,ij->i", normals, places) == pytest.approx(0.5)


def test_faces_without_area_have_finite_normals():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], dtype=np.float64)
    _, _, normals = with_normals(vertices, np.array([[0, 1, 2], [0, 2, 3]]))
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)


def test_mitsuba_reads_it(tmp_path):
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    cube = meshes.placed(primitives.cube(), 2.0)
    path = meshes.write_ply(cube, tmp_path / "cube.ply")
    shape = mi.load_dict({"type": "ply", "filename": str(path)})
    assert shape.surface_area()[0] == pytest.approx(24)
    assert shape.has_vertex_normals()
    hit = mi.load_dict({"type": "scene", "cube": shape}).ray_intersect(mi.Ray3f([0.3, 1, 5], [0, 0, -1]))
    assert hit.t[0] == pytest.approx(4)
    assert hit.sh_frame.n.numpy().ravel() == pytest.approx([0, 0, 1], abs=1e-6)


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "kept.ply"
    write_atomically(path, b"good")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        write_atomically(path, b"bad")
    assert path.read_bytes() == b"good"
    assert list(tmp_path.iterdir()) == [path]


def test_unwritable_place_is_a_clear_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(MeshError, match="Choose another folder"):
        meshes.write_ply(primitives.cube(), tmp_path / "file" / "cube.ply")
