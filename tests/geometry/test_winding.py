"""Which faces of a mesh are wound against the others."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from nephrite.geometry import winding

BALL = trimesh.creation.icosphere(subdivisions=2)
VERTICES, FACES = np.array(BALL.vertices), np.array(BALL.faces)


def _apart(vertices, faces):
    """Return the same triangles, none of which shares a vertex with another."""
    return vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)


def _two(inner, outer):
    """Return a ball in a larger one; `inner`, `outer`: whether each faces inward."""
    faces = [winding.turned_over(FACES, np.full(len(FACES), inward)) for inward in (inner, outer)]
    return np.concatenate([0.5 * VERTICES, VERTICES]), np.concatenate([faces[0], faces[1] + len(VERTICES)])


@pytest.mark.parametrize("apart", [False, True], ids=["shared", "apart"])
@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0.05, 0.95))
@settings(max_examples=20, deadline=None)
def test_what_was_turned_is_found(apart, seed, share):
    turned = np.random.default_rng(seed).random(len(FACES)) < share
    vertices, faces = _apart(VERTICES, FACES) if apart else (VERTICES, FACES)
    found = winding.against_others(vertices, winding.turned_over(faces, turned))
    np.testing.assert_array_equal(found, turned)


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize("apart", [False, True], ids=["shared", "apart"])
def test_nothing_is_found_in_a_mesh_wound_in_one_way(inward, apart):
    faces = winding.turned_over(FACES, np.full(len(FACES), inward))
    vertices, faces = _apart(VERTICES, faces) if apart else (VERTICES, faces)
    assert not winding.against_others(vertices, faces).any()


def test_a_cavity_stays_one():
    vertices, faces = _two(inner=True, outer=False)
    assert not winding.against_others(vertices, faces).any()
    turned = np.arange(len(faces)) % 3 == 0
    np.testing.assert_array_equal(
        winding.against_others(vertices, winding.turned_over(faces, turned)), turned
    )


def test_an_open_mesh_keeps_its_majority():
    faces = FACES[5:]
    turned = np.arange(len(faces)) % 5 == 0
    found = winding.against_others(VERTICES, winding.turned_over(faces, turned))
    np.testing.assert_array_equal(found, turned)


def test_faces_without_an_area_and_empty_meshes():
    turned = np.arange(len(FACES)) % 4 == 0
    point = np.repeat(FACES[:1, :1], 3, axis=1)
    faces = np.concatenate([point, winding.turned_over(FACES, turned)])
    np.testing.assert_array_equal(winding.against_others(VERTICES, faces), np.r_[False, turned])
    assert winding.against_others(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)).shape == (0,)


def test_winding_number():
    assert winding.winding_number(VERTICES, FACES, np.array([0.2, 0.1, 0.0])) == pytest.approx(1)
    assert winding.winding_number(VERTICES, FACES, np.array([1.2, 0.1, 0.0])) == pytest.approx(0, abs=1e-12)
