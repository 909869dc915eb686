"""Framing: the whole object is in the picture, in its middle, and fills it up to the margin."""

from __future__ import annotations

import mitsuba as mi
import numpy as np
import pytest

from nephrite.scene import camera


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def projected(sensor: dict, points: np.ndarray, resolution: tuple[int, int]) -> np.ndarray:
    """Where `points` are in the picture, (N, 2), from 0 to 1 across and down."""
    local = (np.linalg.inv(np.array(sensor["to_world"].matrix)) @ np.c_[points, np.ones(len(points))].T)[:3]
    slope = np.tan(np.radians(sensor["fov"]) / 2)
    across, down = local[:2] / local[2] / slope / 2 * max(resolution)
    return np.stack([0.5 - across / resolution[0], 0.5 - down / resolution[1]], 1)


@pytest.mark.parametrize("resolution", [(800, 600), (300, 900), (1000, 200)])
@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 0.1, 0.1), (0.05, 1, 0.05), (0.2, 0.1, 1)])
def test_all_of_an_object_is_framed(resolution: tuple[int, int], shape: tuple[float, ...]) -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(-0.5, 0.5, (500, 3)) * shape * 250 + (0, 40, 0)
    seen = projected(camera.framing(points, resolution), points, resolution)
    low, high = seen.min(axis=0), seen.max(axis=0)
    tight = np.argmax(high - low)
    np.testing.assert_allclose([low[tight], high[tight]], [camera.MARGIN, 1 - camera.MARGIN], atol=1e-6)
    assert np.all(low > camera.MARGIN - 1e-6)
    assert np.all(high < 1 - camera.MARGIN + 1e-6)
    np.testing.assert_allclose((low + high) / 2, 0.5, atol=0.08)  # across the other side, perspective skews


def test_the_benchmark_camera_is_that_of_b1() -> None:
    sensor = camera.benchmark(100.0, (400, 300))
    np.testing.assert_allclose(np.array(sensor["to_world"].matrix)[:3, 3], [25, 75, 175], rtol=1e-6)
    np.testing.assert_allclose(projected(sensor, np.array([[0.0, 33.0, 0.0]]), (400, 300)), 0.5, atol=1e-6)
    loaded = mi.load_dict(sensor)
    assert mi.traverse(loaded)["x_fov"].numpy()[0] == pytest.approx(38.0)
    assert list(loaded.film().size()) == [400, 300]
    assert "Box" in str(loaded.film().rfilter())
