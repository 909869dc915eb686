"""What is wrong with meshes, and what becomes of it."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from nephrite.errors import MeshError
from nephrite.scene import meshes

BALL = trimesh.creation.icosphere(subdivisions=2)
BOX = trimesh.creation.box()


def made(vertices, faces):
    return meshes.from_arrays(np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int64), "it")


def joined(*solids):
    whole = trimesh.util.concatenate(solids)
    return np.array(whole.vertices), np.array(whole.faces)


def test_a_good_mesh_keeps_its_triangles():
    mesh = made(BALL.vertices, BALL.faces)
    assert mesh.closed
    assert str(mesh.report) == "closed"
    assert mesh.report.volume == pytest.approx(BALL.volume)
    corners = lambda v, f: sorted(map(tuple, np.sort(v[f].reshape(len(f), -1), axis=1)))  # noqa: E731
    assert corners(mesh.vertices, mesh.faces) == corners(BALL.vertices, BALL.faces)
    assert meshes.repair(mesh) is mesh


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_vertices_that_are_not_numbers(value):
    vertices = np.array(BALL.vertices)
    vertices[7] = value
    mesh = made(vertices, BALL.faces)
    assert mesh.closed
    assert mesh.report["non-finite"].count in (5, 6)
    assert mesh.report["open"].done.startswith("1 closed")
    assert np.isfinite(mesh.vertices).all()
    assert mesh.volume == pytest.approx(BALL.volume, rel=0.02)


def test_nothing_but_nan():
    with pytest.raises(MeshError, match="no face with finite"):
        made(np.full((3, 3), np.nan), [[0, 1, 2]])


@pytest.mark.parametrize("end", [[0.0, 0.0, 0.0], [2.0, 2.0, 2.0]], ids=["point", "line"])
def test_no_area(end):
    with pytest.raises(MeshError, match="no area"):
        made([[0, 0, 0], [1, 1, 1] if any(end) else [0, 0, 0], end], [[0, 1, 2]])


def test_degenerate_faces_are_left_out():
    faces = np.concatenate([BALL.faces, [[0, 0, 1], [2, 2, 2]]])
    mesh = made(BALL.vertices, faces)
    assert mesh.closed
    assert mesh.report["degenerate"].count == 2
    assert len(mesh.faces) == len(BALL.faces)


def test_inside_out_is_turned():
    mesh = made(BALL.vertices, BALL.faces[:, ::-1])
    assert mesh.volume == pytest.approx(BALL.volume)
    assert mesh.report["inside-out"].count == len(BALL.faces)
    assert "turned over" in str(mesh.report)


@given(st.lists(st.integers(0, len(BALL.faces) - 1), unique=True, min_size=1))
@settings(max_examples=30, deadline=None)
def test_mixed_winding_is_made_one(turned):
    faces = np.array(BALL.faces)
    faces[turned] = faces[turned][:, ::-1]
    mesh = made(BALL.vertices, faces)
    assert mesh.closed
    assert mesh.volume == pytest.approx(BALL.volume)
    assert ("winding" in mesh.report) or ("inside-out" in mesh.report)


def test_each_part_is_turned_by_itself():
    vertices, faces = joined(BALL, BOX.copy().apply_translation([5, 0, 0]))
    faces[len(BALL.faces) :] = faces[len(BALL.faces) :, ::-1]
    mesh = made(vertices, faces)
    assert mesh.report.parts == 2
    assert mesh.volume == pytest.approx(BALL.volume + 1)


@pytest.mark.parametrize("flip", [False, True])
def test_a_cavity_stays_a_cavity(flip):
    hollow = BALL.copy().apply_scale(0.5)
    hollow.invert()
    vertices, faces = joined(BALL, hollow)
    mesh = made(vertices, faces[:, ::-1] if flip else faces)
    assert mesh.closed
    assert mesh.volume == pytest.approx(BALL.volume * 7 / 8)


def test_a_hole_is_filled_without_losing_other_parts():
    vertices, faces = joined(BALL, BOX.copy().apply_translation([5, 0, 0]))
    mesh = made(vertices, np.delete(faces, [3], axis=0))
    assert mesh.closed
    assert mesh.report.parts == 2
    assert mesh.volume == pytest.approx(BALL.volume + 1, rel=1e-6)
    assert mesh.report["open"].solved


def test_a_bowl_gets_a_lid_and_a_warning():
    upper = BALL.faces[(BALL.triangles_center[:, 2] > 0)]
    mesh = made(BALL.vertices, upper)
    assert mesh.closed
    assert mesh.volume == pytest.approx(BALL.volume / 2, rel=0.1)
    assert any("boundary" in warning for warning in mesh.report.warnings)


@pytest.mark.parametrize("count", [30, 3000])
def test_a_tube_is_closed_at_both_ends(count):
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    k = np.arange(count)
    after = (k + 1) % count
    faces = np.concatenate(
        [np.stack([k, after, count + after], 1), np.stack([k, count + after, count + k], 1)]
    )
    mesh = made(np.concatenate([ring, ring + np.array([0, 0, 1])]), faces)
    assert mesh.closed
    assert mesh.volume == pytest.approx(np.pi, rel=0.01)
    assert mesh.report["open"].done.startswith("2 closed")


def test_a_sheet_stays_a_sheet():
    mesh = made([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    assert not mesh.closed
    assert mesh.report.volume == 0
    assert len(mesh.faces) == 2
    assert "not closed" in str(mesh.report)
    assert mesh.report.warnings


def test_a_moebius_strip_is_told_apart():
    turn = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    rim = [
        np.stack([(2 + s * np.cos(turn / 2)) * np.cos(turn), (2 + s * np.cos(turn / 2)) * np.sin(turn),
                  s * np.sin(turn / 2)], axis=1)
        for s in (-0.5, 0.5)
    ]  # fmt: skip
    faces = []
    for k in range(20):
        a, b, c, d = k, 20 + k, k + 1, 21 + k
        if k == 19:
            c, d = 20, 0
        faces += [[a, b, c], [b, d, c]]
    mesh = made(np.concatenate(rim), faces)
    assert "one-sided" in mesh.report
    assert not mesh.closed


def test_folded_faces_cancel():
    vertices = np.concatenate([BALL.vertices, [[2.0, 0, 0]]])
    flap = [[0, 1, len(BALL.vertices)], [1, 0, len(BALL.vertices)]]
    mesh = made(vertices, np.concatenate([BALL.faces, flap]))
    assert mesh.closed
    assert mesh.report["folded"].count == 2
    assert len(mesh.faces) == len(BALL.faces)


@pytest.mark.parametrize("part", [slice(None), slice(0, 5)], ids=["all", "some"])
def test_faces_that_are_there_twice(part):
    mesh = made(BALL.vertices, np.concatenate([BALL.faces, BALL.faces[part]]))
    assert mesh.closed
    assert mesh.volume == pytest.approx(BALL.volume)
    assert mesh.report["repeated"].count == len(BALL.faces[part])


def test_boxes_that_touch_along_an_edge_come_apart():
    vertices, faces = joined(BOX, BOX.copy().apply_translation([1, 1, 0]))
    mesh = made(vertices, faces)
    assert mesh.closed
    assert mesh.report["non-manifold"].count == 1
    assert mesh.report.parts == 2
    assert mesh.volume == pytest.approx(2)


@pytest.mark.parametrize("flip", [False, True])
def test_wedges_around_an_edge_come_apart_each_by_itself(flip):
    turn = np.radians([10, 70, 130, 190, 250, 310])
    rim = np.stack([np.cos(turn), np.sin(turn), 0.5 + 0 * turn], axis=1)
    faces = []
    for k in (2, 4, 6):
        faces += [[0, k, k + 1], [1, k + 1, k], [0, 1, k], [1, 0, k + 1]]
    faces = np.array(faces)[:, ::-1] if flip else faces
    mesh = made(np.concatenate([[[0, 0, 0], [0, 0, 1]], rim]), faces)
    assert mesh.closed
    assert mesh.report.parts == 3
    assert mesh.volume == pytest.approx(3 * np.sin(np.radians(60)) / 6)
    assert "non-manifold" in mesh.report


def test_boxes_with_a_common_wall_become_one():
    mirrored = trimesh.Trimesh(np.array(BOX.vertices) * [-1, 1, 1], np.array(BOX.faces)[:, ::-1])
    vertices, faces = joined(BOX, mirrored.apply_translation([1, 0, 0]))
    mesh = made(vertices, faces)
    assert mesh.closed
    assert mesh.report.parts == 1
    assert mesh.volume == pytest.approx(2)
    assert mesh.report["folded"].count == 4
    assert len(mesh.faces) == 20


def test_an_extra_fin_is_no_reason_to_drop_the_ball():
    vertices = np.concatenate([BALL.vertices, [[3.0, 0, 0]]])
    mesh = made(vertices, np.concatenate([BALL.faces, [[*BALL.edges[0], len(BALL.vertices)]]]))
    assert "non-manifold" in mesh.report
    assert len(mesh.faces) >= len(BALL.faces)
    assert mesh.bounds[0] == pytest.approx(BALL.bounds[0])


def test_cracks_are_sewn_up():
    soup = np.array(BALL.triangles).reshape(-1, 3)
    soup += np.random.default_rng(0).uniform(-1e-7, 1e-7, soup.shape)
    mesh = made(soup, np.arange(len(soup)).reshape(-1, 3))
    assert mesh.closed
    assert mesh.report["cracks"].count > 0
    assert len(mesh.faces) == len(BALL.faces)
    assert mesh.volume == pytest.approx(BALL.volume, rel=1e-5)


def test_a_soup_of_triangles_ends_soon_and_says_so():
    rng = np.random.default_rng(0)
    corners = (rng.normal(size=(5000, 1, 3)) + 0.1 * rng.normal(size=(5000, 3, 3))).reshape(-1, 3)
    mesh = made(corners, np.arange(15000).reshape(-1, 3))
    assert not mesh.closed
    assert len(mesh.faces) == 5000
    assert mesh.report["open"].count == 15000


def test_many_faces_at_one_edge_end_soon():
    turn = np.linspace(0, 2 * np.pi, 3001)[:-1]
    pages = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    vertices = np.concatenate([[[0, 0, 0], [0, 0, 1]], pages])
    mesh = made(vertices, [[0, 1, k + 2] for k in range(3000)])
    assert not mesh.closed
    assert len(mesh.faces) == 3000


def test_specks_are_left_out():
    dust = BALL.copy().apply_scale(1e-4).apply_translation([2, 0, 0])
    mesh = made(*joined(BALL, dust))
    assert mesh.report.parts == 1
    assert mesh.report["specks"].count == 1


@pytest.mark.parametrize("scale", [1e-30, 1e-6, 1e6, 1e30])
def test_size_changes_nothing(scale):
    vertices, faces = joined(BALL, BOX.copy().apply_translation([1.4, 0, 0]))
    mesh = made(vertices * scale, np.delete(faces, [3], axis=0))
    assert mesh.closed
    assert mesh.volume == pytest.approx((BALL.volume + 1) * scale**3, rel=1e-6)
    at_one = meshes.placed(mesh, 100.0)
    assert at_one.extents.max() == pytest.approx(100)


def test_far_from_the_origin_is_told():
    mesh = made(np.array(BALL.vertices) + np.array([1e7, 0, 0]), BALL.faces)
    assert mesh.closed
    assert mesh.volume == pytest.approx(BALL.volume, rel=1e-5)
    assert "far-away" in mesh.report
    assert meshes.placed(mesh, 10.0).bounds[0] == pytest.approx([-5, 0, -5], abs=1e-4)
