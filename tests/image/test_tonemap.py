"""Exposure, shoulder and the sRGB curve."""

import numpy as np
import pytest

from nephrite.image.tonemap import from_srgb8, soft_clip, srgb_decode, srgb_encode, to_srgb8


def test_published_values_of_the_srgb_curve():
    # IEC 61966-2-1: middle grey of 18 % is 118 of 255; the two branches meet.
    assert to_srgb8(np.array([0.0, 0.18, 0.2140, 1.0])).tolist() == [0, 118, 127, 255]
    assert srgb_encode(np.array(0.0031308)) == pytest.approx(0.04045, abs=1e-6)
    assert srgb_encode(np.array(0.00313081)) == pytest.approx(0.04045, abs=1e-6)


def test_every_code_survives_the_round_trip():
    codes = np.arange(256, dtype=np.uint8)
    assert np.array_equal(to_srgb8(from_srgb8(codes)), codes)


def test_decode_undoes_encode():
    linear = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(srgb_decode(srgb_encode(linear)), linear, atol=1e-7)


def test_exposure_is_in_stops():
    linear = np.array([0.05, 0.1, 0.2], np.float32)
    assert np.array_equal(to_srgb8(linear, exposure=1.0), to_srgb8(2 * linear))
    assert np.array_equal(to_srgb8(linear, exposure=-2.0), to_srgb8(linear / 4))


@pytest.mark.parametrize("shoulder", [False, True])
def test_odd_values(shoulder):
    odd = np.array([np.nan, -1.0, -np.inf, np.inf, 1e30], np.float32)
    assert to_srgb8(odd, shoulder=shoulder).tolist() == [0, 0, 0, 255, 255]


def test_input_is_not_changed():
    pixels = np.array([np.nan, -1.0, 2.0], np.float32)
    to_srgb8(pixels, 1.0, True)
    np.testing.assert_array_equal(pixels, np.array([np.nan, -1.0, 2.0], np.float32))


def test_shoulder_is_smooth_and_monotonic_and_leaves_the_rest_alone():
    x = np.linspace(0, 4, 4001)
    y = soft_clip(x)
    assert np.array_equal(y[x <= 0.8], x[x <= 0.8])
    assert np.all(np.diff(y) > 0)
    assert y[-1] < 1
    assert np.abs(np.diff(y, 2)).max() < 1e-5  # no corner: the slope is continuous at the start
    assert to_srgb8(np.array([1.0]), shoulder=True)[0] < to_srgb8(np.array([1.5]), shoulder=True)[0] < 255
