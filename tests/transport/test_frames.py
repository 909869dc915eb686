"""Tangential vectors: frames of unit tangents, and turns that keep lengths."""

import numpy as np
import pytest
from scipy import sparse

from nephrite.transport.frames import frames, turned, turning


def _directions(count, seed):
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_frames_are_unit_tangents():
    normals = np.concatenate([_directions(100, 1), [[0, 0, 1.0], [0, 0, -1.0]]])
    both = np.concatenate([frames(normals), normals[:, None]], axis=1)
    np.testing.assert_allclose(
        both @ both.transpose(0, 2, 1), np.broadcast_to(np.eye(3), both.shape), atol=1e-12
    )


def test_turned_frames_are_tangential_there_and_turn_about_what_both_normals_share():
    here, there = _directions(100, 2), _directions(100, 3)
    found = turned(here, there)
    np.testing.assert_allclose(np.einsum("nkj,nj->nk", found, there), 0, atol=1e-9)
    np.testing.assert_allclose(
        found @ found.transpose(0, 2, 1), np.broadcast_to(np.eye(2), (100, 2, 2)), atol=1e-9
    )
    axis = np.cross(here, there)
    np.testing.assert_allclose(
        np.einsum("nkj,nj->nk", found, axis), np.einsum("nkj,nj->nk", frames(here), axis), atol=1e-9
    )


def test_a_vector_keeps_its_length_over_a_bend():
    """A normal that turns by 60 degrees about y: what pointed along x follows the surface, and y stays."""
    coarse, fine = np.array([[0, 0, 1.0]]), np.array([[np.sqrt(0.75), 0, 0.5]])
    turn = turning(sparse.csr_matrix([[0.5]]), fine, coarse)
    for vector, expected in (([1.0, 0, 0], [0.5, 0, -np.sqrt(0.75)]), ([0, 1.0, 0], [0, 1.0, 0])):
        first, second = frames(coarse)[0] @ vector
        turned_to = turn[0, 0] * (first + 1j * second)
        found = np.array([turned_to.real, turned_to.imag]) @ frames(fine)[0]
        assert found == pytest.approx(0.5 * np.array(expected), abs=1e-6)
