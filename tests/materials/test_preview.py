import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nephrite.materials.preview import seen_through
from nephrite.physics import Medium

coefficient = st.one_of(st.just(0.0), st.floats(1e-9, 1e6))


@given(coefficient, coefficient, st.floats(0, 1e4))
def test_never_more_than_all(sigma_a, sigma_s, thickness):
    value = seen_through(Medium(sigma_a, sigma_s), thickness)[0]
    assert 0 <= value <= 1 + 1e-12
    assert seen_through(Medium(sigma_a, sigma_s), thickness + 1)[0] <= value + 1e-12


def test_limits():
    assert seen_through(Medium(0, 0), 10) == (1.0, 1.0, 1.0)
    assert seen_through(Medium(1, 5), 0) == (1.0, 1.0, 1.0)
    assert seen_through(Medium(0.1, 0), 4)[0] == pytest.approx(math.exp(-0.8))
    assert seen_through(Medium(0, 2), 4)[0] == pytest.approx(1 / (1 + 1.5 * 4))


@pytest.mark.parametrize("sigma_a", [0.01, 0.3])
def test_thick_slabs_fall_off_as_diffusion_says(sigma_a):
    medium = Medium(sigma_a, 2.0, g=0.5)
    depth = 10 * medium.dmfp[0]
    ratio = seen_through(medium, depth + 1)[0] / seen_through(medium, depth)[0]
    assert ratio == pytest.approx(math.exp(-medium.sigma_tr[0]), rel=1e-6)
