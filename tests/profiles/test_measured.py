"""Measured profiles: the laws, exactly, for lines between points; and files as people write them."""

import itertools
import math

import numpy as np
import pytest
from scipy import integrate, stats

from nephrite.errors import ParameterError
from nephrite.profiles.measured import MeasuredProfile, read

POINTS = ([0.1, 0.4, 1.0, 1.7, 4.0], [0.105, 0.08, 0.025, 0.03, 0.0005])


def test_lines_integrate_exactly():
    profile = MeasuredProfile(*POINTS)
    edges = [0.0, *POINTS[0]]
    for end in (0.05, 0.4, 0.9, 3.3, 4.0, 9.0):
        parts = [edge for edge in edges if edge < end] + [min(end, 4.0)]
        part = sum(
            integrate.quad(lambda r: 2 * math.pi * r * profile.eval(r), *ends)[0]
            for ends in itertools.pairwise(parts)
        )
        assert profile.cdf(end) * profile.albedo() == pytest.approx(part, rel=1e-9)
    assert profile.cdf(4.0) == pytest.approx(1.0)


def test_values_are_those_of_the_points_and_0_beyond():
    profile = MeasuredProfile(*POINTS)
    np.testing.assert_allclose(profile.eval(np.array(POINTS[0][:-1])), POINTS[1][:-1])
    assert profile.eval(0.7) == pytest.approx(0.0525)
    assert profile.eval(0.0) == profile.eval(0.05) == 0.105
    assert profile.eval(4.1) == profile.pdf(4.1) == 0.0


def test_samples_follow_the_profile():
    """Kolmogorov-Smirnov; a right program fails with probability 1e-3, were the seed drawn anew."""
    profile = MeasuredProfile(*POINTS)
    u = np.random.default_rng(4).random(20_000)
    assert stats.kstest(profile.sample(u), profile.cdf).pvalue > 1e-3
    np.testing.assert_allclose(profile.cdf(profile.sample(u)), u, atol=1e-9)


def test_empty_rings_are_never_sampled():
    profile = MeasuredProfile([0.0, 1.0, 2.0, 3.0], [0.1, 0.0, 0.0, 0.01])
    radii = profile.sample(np.random.default_rng(5).random(5000))
    assert not np.any((radii > 1.001) & (radii < 1.999))


def test_drjit_gives_the_same_and_derivatives():
    import drjit as dr
    from drjit.llvm.ad import Float64

    profile = MeasuredProfile(*POINTS)
    for name, x in (("eval", 0.7), ("cdf", 0.7), ("pdf", 2.0), ("sample", 0.6)):
        variable = Float64(x, 0.05)
        dr.enable_grad(variable)
        value = getattr(profile, name)(variable)
        assert value[0] == pytest.approx(getattr(profile, name)(x), rel=1e-9)
        assert value[1] == pytest.approx(getattr(profile, name)(0.05), rel=1e-9)
        dr.backward(value)
        slope = (getattr(profile, name)(x + 1e-6) - getattr(profile, name)(x - 1e-6)) / 2e-6
        assert dr.grad(variable)[0] == pytest.approx(slope, rel=1e-5, abs=1e-9)


def test_a_file_has_one_column_or_three(tmp_path):
    file = tmp_path / "skin.csv"
    file.write_text("# measured on a cheek\nr, R\n0.1, 0.105\n1.0, 0.025 # worn\n\n4.0, 0.0005\n")
    (profile,) = read(file)
    assert profile.eval(1.0) == pytest.approx(0.025)
    file.write_text("r;red;green;blue\n0;.2;.1;.05\n2;.02;.01;.0\n")
    red, green, blue = read(file)
    assert red.albedo() == pytest.approx(2.0 * green.albedo())
    assert blue.reach() == 2.0
    file.write_text("0 .2\n2 .02\n")
    assert len(read(str(file))) == 1


@pytest.mark.parametrize(("text", "message"), [
    ("", "two points or more"),
    ("r,R\n", "two points or more"),
    ("0.1,0.2\n", "two points or more"),
    ("r,R\n0.1,0.2\n0.5;oops\n", "line 3: could not convert string to float: 'oops'"),
    ("0.1,0.2\n0.5,0.1,0.3\n", "line 2: 3 numbers, but there must be 2, as in the lines before"),
    ("0.1,0.2,0.3\n0.5,0.1,0.3\n", r"line 1: 3 numbers, but there must be 2 \(r, R\) or 4"),
    ("0.1,0.02\n0.5,-0.1\n", "R of point 2 is -0.1"),
    ("0.1,0.02\n0.5,nan\n", "R of point 2 is nan"),
    ("0.5,0.02\n0.5,0.01\n", "r of point 2 is 0.5, after 0.5: sort the points"),
    ("0.1,20\n5,10\n", "1/mm"),
    ("0.1,0\n5,0\n", "above 0"),
])  # fmt: skip
def test_a_file_that_is_wrong_is_named_with_the_remedy(tmp_path, text, message):
    file = tmp_path / "odd.csv"
    file.write_text(text)
    with pytest.raises(ParameterError, match=message) as error:
        read(file)
    assert "odd.csv" in str(error.value)


def test_a_file_that_is_not_there_or_no_text(tmp_path):
    with pytest.raises(ParameterError, match="cannot read the profile"):
        read(tmp_path / "none.csv")
    (tmp_path / "picture.csv").write_bytes(b"\xff\xd8\xff\xe0\x80")
    with pytest.raises(ParameterError, match="cannot read the profile"):
        read(tmp_path / "picture.csv")


def test_points_that_cannot_be_are_refused():
    with pytest.raises(ParameterError, match="at least two"):
        MeasuredProfile([1.0], [0.1])
    with pytest.raises(ParameterError, match="as many of both"):
        MeasuredProfile([1.0, 2.0], [0.1])
