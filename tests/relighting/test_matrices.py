"""Matrices of what is seen: those without their least entries lose no more than is said, and no light."""

import numpy as np
import pytest
from scipy import sparse

from nephrite.relighting.matrices import beside, thinned


@pytest.fixture
def matrices():
    """Return three matrices with their entries in the same places, of magnitudes from 1e-6 to 1; a row has none."""
    rng = np.random.default_rng(1)
    first = sparse.random(50, 400, 0.2, "csr", np.float32, rng)
    first = sparse.csr_matrix(first.multiply((np.arange(50) != 7)[:, None]), dtype=np.float32)
    found = []
    for _ in range(3):
        values = (10.0 ** rng.uniform(-6, 0, first.nnz)).astype(np.float32)
        found.append(sparse.csr_matrix((values, first.indices, first.indptr), shape=first.shape))
    return found


def test_what_is_left_out_is_bounded_and_sums_stay(matrices):
    less = thinned(matrices, 0.01)
    for before, after in zip(matrices, less, strict=True):
        sums = np.asarray(before.sum(axis=1)).ravel()
        np.testing.assert_allclose(np.asarray(after.sum(axis=1)).ravel(), sums, rtol=1e-5)
        moved = np.asarray(abs(before - after).sum(axis=1)).ravel()
        assert (moved <= 2.01 * 0.01 * sums).all()  # what is left out, and as much that the others grow by
    assert 0 < less[0].nnz < 0.9 * matrices[0].nnz
    np.testing.assert_array_equal(less[0].indices, less[2].indices)


def test_nothing_is_left_out_of_nothing(matrices):
    np.testing.assert_allclose(thinned(matrices, 0.0)[1].toarray(), matrices[1].toarray(), rtol=1e-5)
    empty = [sparse.csr_matrix((4, 5), dtype=np.float32)] * 3
    assert thinned(empty, 0.01)[0].nnz == 0


def test_matrices_beside_each_other_add_up(matrices):
    a, b, _ = matrices
    x = np.random.default_rng(2).random(800).astype(np.float32)
    np.testing.assert_allclose(beside(a, b) @ x, a @ x[:400] + b @ x[400:], rtol=1e-5)
    assert beside(a, b).indices.dtype == np.int32
