"""The denoiser: it helps, keeps edges that it is told of, never makes NaN, and may be missing."""

import warnings

import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.image import denoise as module
from nephrite.image.denoise import DenoiserWarning, available, denoise, why_unavailable
from nephrite.image.errors import relmse

needs_library = pytest.mark.skipif(not available(), reason="Open Image Denoise is not installed")


@pytest.fixture
def scene():
    """A soft glow on a fine chequered surface: (truth, noisy, albedo, normal)."""
    y, x = np.mgrid[0:128, 0:128]
    albedo = np.where(((x // 4 + y // 4) % 2)[..., None], [0.8, 0.7, 0.5], [0.5, 0.6, 0.6])
    glow = 2.0 * np.exp(-((x - 50) ** 2 + (y - 70) ** 2) / 3000.0)[..., None] + 0.1
    truth = (albedo * glow).astype(np.float32)
    noise = np.random.default_rng(3).gamma(1.0, 1.0, truth.shape)
    normal = np.broadcast_to(np.float32([0, 0, 1]), truth.shape)
    return truth, (truth * noise).astype(np.float32), albedo, normal


@needs_library
def test_it_removes_noise_and_keeps_the_brightness(scene):
    truth, noisy, albedo, normal = scene
    clean = denoise(noisy, albedo, normal)
    assert clean.dtype == np.float32
    assert relmse(clean, truth) < relmse(noisy, truth) / 50
    np.testing.assert_allclose(clean.mean(axis=(0, 1)), truth.mean(axis=(0, 1)), rtol=0.05)


@needs_library
def test_albedo_keeps_the_texture_that_is_smeared_without(scene):
    truth, noisy, albedo, normal = scene
    assert relmse(denoise(noisy, albedo, normal), truth) < relmse(denoise(noisy), truth) / 2


@needs_library
def test_it_never_makes_nan_and_leaves_its_input_alone(scene):
    _, noisy, albedo, normal = scene
    noisy[3, 4] = np.nan
    noisy[5, 6] = (np.inf, -np.inf, -3.0)
    noisy[7, 8] = 1e30
    spoiled = np.array(albedo)
    spoiled[9, 9] = np.nan
    before = noisy.copy()
    clean = denoise(noisy, spoiled, normal * 5)
    assert np.isfinite(clean).all()
    assert (clean >= 0).all()
    np.testing.assert_array_equal(noisy, before)


@needs_library
@pytest.mark.parametrize("shape", [(1, 1, 3), (7, 130, 3), (64, 3, 3)])
def test_any_size_and_layout(shape):
    pixels = np.asfortranarray(np.full(shape, 0.5))
    clean = denoise(pixels)
    assert clean.shape == shape
    np.testing.assert_allclose(clean, 0.5, rtol=0.01)  # up to the borders


@needs_library
def test_black_stays_black():
    assert denoise(np.zeros((32, 32, 3), np.float32)).max() < 1e-4


def test_without_the_library_the_picture_comes_back_with_a_message(scene, monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(f"No module named {name!r}")

    why_unavailable.cache_clear()
    try:
        with monkeypatch.context() as patch:
            patch.setattr(module.importlib, "import_module", missing)
            assert not available()
            with pytest.warns(DenoiserWarning, match="pip install pyoidn"):
                assert denoise(scene[1]) is scene[1]
    finally:
        why_unavailable.cache_clear()


@needs_library
def test_a_failure_of_the_library_is_told_and_the_picture_comes_back(scene, monkeypatch):
    import pyoidn

    def fail(*args, **kwargs):
        raise RuntimeError("out of memory")

    noisy = scene[1]
    noisy[2, 3] = (np.nan, np.inf, -1.0)
    expected = noisy.copy()
    expected[2, 3] = 0.0
    monkeypatch.setattr(pyoidn, "denoise", fail)
    with pytest.warns(DenoiserWarning, match="out of memory"):
        np.testing.assert_array_equal(denoise(noisy), expected)


def test_shapes_are_checked(scene):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ParameterError, match="albedo"):
            denoise(scene[1], albedo=scene[2][:-1])
        with pytest.raises(ParameterError, match="normal"):
            denoise(scene[1], normal=scene[3][..., :2])
        with pytest.raises(ParameterError, match="shape"):
            denoise(scene[1][..., 0])
