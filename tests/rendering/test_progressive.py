"""Progressive rendering: goals, determinism, noise, interrupts, NaN; on Mitsuba's own integrator."""

import os
import signal
import time

import numpy as np
import pytest

import nephrite  # noqa: F401 (first, for LLVM)
from nephrite.errors import ParameterError
from nephrite.image.errors import z_limit, z_scores
from nephrite.rendering import progressive
from nephrite.rendering.progressive import render


@pytest.fixture(scope="module")
def scene():
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    box = mi.cornell_box()
    box["sensor"]["film"] = {"type": "hdrfilm", "width": 32, "height": 24, "rfilter": {"type": "box"}}
    box["integrator"] = {"type": "path", "max_depth": 4}
    return mi.load_dict(box)


class FakeScene:
    """Stands for a scene, a sensor, a film and a sampler; `picture(seed, spp)` makes the passes."""

    def __init__(self, picture, monkeypatch, shape=(4, 6), rounding=lambda spp: spp):
        self.shape, self.seeds, self.spps, self.rounding, self.spp = shape, [], [], rounding, 16
        self.picture = picture
        monkeypatch.setattr(progressive.mi, "render", self.render)
        monkeypatch.setattr(progressive.mi, "variant", lambda: "llvm_ad_rgb")

    def render(self, scene, sensor, integrator, seed, spp):
        self.seeds.append(seed)
        self.spps.append(spp)
        return self.picture(seed, spp)

    def sensors(self):
        return [self]

    def film(self):
        return self

    def crop_size(self):
        return [self.shape[1], self.shape[0]]

    def sampler(self):
        return self

    def clone(self):
        return FakeSampler(self.rounding)

    def sample_count(self):
        return self.spp


class FakeSampler:
    def __init__(self, rounding):
        self.rounding = rounding

    def set_sample_count(self, spp):
        self.spp = self.rounding(spp)

    def sample_count(self):
        return self.spp


def noisy(seed, spp):
    return 1 + np.random.default_rng(seed).normal(size=(4, 6, 3)).astype(np.float32) / np.sqrt(spp)


def test_spp_is_exact_and_the_picture_is_deterministic(scene):
    first, second = render(scene, spp=37, seed=5), render(scene, spp=37, seed=5)
    assert first.spp == 37
    assert first.stopped == "spp"
    assert not first.interrupted
    assert first.pixels.shape == first.variance.shape == (24, 32, 3)
    assert first.pixels.dtype == np.float32
    np.testing.assert_array_equal(first.pixels, second.pixels)
    assert not np.array_equal(first.pixels, render(scene, spp=37, seed=6).pixels)


def test_mean_and_variance_agree_with_one_ordinary_render(scene):
    import mitsuba as mi

    a = render(scene, spp=512, seed=1)
    b = np.array(mi.render(scene, seed=999, spp=512))
    scores = z_scores(a.pixels, b, a.variance, a.variance, block=8)
    assert np.abs(scores).max() < z_limit(scores.size, 1e-4)
    assert scores.std() == pytest.approx(1, abs=0.4)


def test_the_variance_is_the_error_that_there_is(scene):
    reference = render(scene, spp=4096, seed=77)
    # The few pixels at the edge of the lamp would need thousands of renders to average.
    quiet = reference.variance.mean(axis=2) < np.quantile(reference.variance.mean(axis=2), 0.9)
    results = [render(scene, spp=64, seed=seed) for seed in range(6)]
    errors = [np.mean((result.pixels - reference.pixels)[quiet] ** 2) for result in results]
    assert np.mean([result.variance[quiet].mean() for result in results]) == pytest.approx(
        np.mean(errors), rel=0.1
    )


def test_noise_goal_is_reached_and_not_by_far(scene):
    result = render(scene, noise=0.2)
    assert result.stopped == "noise"
    assert 0.1 < result.noise <= 0.2
    np.testing.assert_array_equal(result.pixels, render(scene, noise=0.2).pixels)


def test_time_goal_is_kept(scene):
    render(scene, spp=1)
    start = time.perf_counter()
    result = render(scene, time_s=1.5)
    assert time.perf_counter() - start < 2.5
    assert result.stopped == "time"
    assert result.passes > 2
    assert result.seconds > 0.7


@pytest.mark.parametrize("variant", ["llvm_ad_mono", "llvm_ad_spectral", "scalar_rgb"])
def test_other_variants(variant):
    import mitsuba as mi

    before = mi.variant() or "llvm_ad_rgb"
    try:
        mi.set_variant(variant)
        film = {"type": "hdrfilm", "width": 8, "height": 6, "pixel_format": "rgba"}
        sensor = {"type": "perspective", "film": film}
        result = render(
            mi.load_dict({"type": "scene", "sensor": sensor, "light": {"type": "constant"}}),
            mi.load_dict({"type": "path"}),
            spp=4,
        )
        assert result.pixels.shape == (6, 8, 3)
        np.testing.assert_allclose(result.pixels, 1, atol=0.05 if variant != "llvm_ad_spectral" else 0.6)
    finally:
        mi.set_variant(before)


def test_without_a_goal_the_sampler_decides(monkeypatch):
    assert render(FakeScene(noisy, monkeypatch)).spp == 16


def test_every_pass_has_its_own_seed(monkeypatch):
    fake = FakeScene(noisy, monkeypatch)
    render(fake, spp=200, seed=3)
    assert len(set(fake.seeds)) == len(fake.seeds) > 8
    again = FakeScene(noisy, monkeypatch)
    render(again, spp=200, seed=4)
    assert not set(fake.seeds) & set(again.seeds)


def test_samplers_that_round_are_counted_as_they_do(monkeypatch):
    squares = FakeScene(noisy, monkeypatch, rounding=lambda spp: int(np.ceil(np.sqrt(spp))) ** 2)
    result = render(squares, spp=64)
    assert result.spp == sum(int(np.ceil(np.sqrt(spp))) ** 2 for spp in squares.spps)
    assert 64 <= result.spp < 80


def test_memory_limits_the_passes(monkeypatch):
    fake = FakeScene(noisy, monkeypatch)
    render(fake, spp=64, max_samples=24 * 2)
    assert max(fake.spps) == 2
    fake = FakeScene(noisy, monkeypatch)
    render(fake, spp=5, max_samples=1)
    assert fake.spps == [1] * 5


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 10])
def test_any_film(monkeypatch, channels):
    fake = FakeScene(lambda seed, spp: np.arange(1.0, channels + 1) * np.ones((4, 6, 1)), monkeypatch)
    expected = [1, 2, 3] if channels >= 3 else [1, 1, 1]
    np.testing.assert_array_equal(render(fake, spp=2).pixels[0, 0], expected)


def test_nan_and_infinity_are_left_out_counted_and_reported(monkeypatch):
    def spoiled(seed, spp):
        picture = np.full((4, 6, 3), 0.5)
        picture[1, 2] = np.nan if len(fake.seeds) % 2 else 0.5
        picture[3, 3, 0] = np.inf
        return picture

    fake = FakeScene(spoiled, monkeypatch)
    result = render(fake, spp=4)
    assert result.dropped == 2 + 4
    assert "NaN" in result.notes[0]
    expected = np.full((4, 6, 3), 0.5)
    expected[3, 3] = 0
    np.testing.assert_array_equal(result.pixels, expected)


def test_progress_counts_up_and_knows_the_end(monkeypatch):
    seen = []
    result = render(FakeScene(noisy, monkeypatch), spp=64, on_progress=seen.append)
    assert [step.passes for step in seen] == list(range(1, result.passes + 1))
    assert [step.spp for step in seen] == sorted({step.spp for step in seen})
    assert all(step.target == 64 for step in seen)
    assert seen[0].remaining_s is None
    assert seen[0].noise == np.inf
    assert all(step.remaining_s is not None and step.remaining_s > 0 for step in seen[1:-1])
    assert (seen[-1].fraction, seen[-1].remaining_s) == (1.0, 0.0)
    assert seen[-1].noise == result.noise < seen[2].noise


def test_time_left_follows_the_clock(monkeypatch):
    seen = []

    def slow(seed, spp):
        time.sleep(0.02 if seen else 0.3)  # the first pass compiles
        return noisy(seed, spp)

    render(FakeScene(slow, monkeypatch), spp=8, on_progress=seen.append)
    assert seen[3].remaining_s == pytest.approx(4 * 0.02, rel=0.5)


def test_noise_goal_predicts_its_end(monkeypatch):
    seen = []
    result = render(FakeScene(noisy, monkeypatch), noise=0.02, on_progress=seen.append)
    assert seen[0].target is None
    assert seen[-3].target == pytest.approx(result.spp, rel=0.3)
    assert result.spp == pytest.approx(2500, rel=0.3)


def test_a_noise_that_is_not_reached_ends_at_the_cap_with_a_note(monkeypatch):
    monkeypatch.setattr("nephrite.rendering.goal.MAX_SPP", 256)
    result = render(FakeScene(noisy, monkeypatch), noise=1e-4)
    assert (result.spp, result.stopped) == (256, "cap")
    assert "not reached" in result.notes[0]
    limited = render(FakeScene(noisy, monkeypatch), noise=1e-4, spp=20)
    assert (limited.spp, limited.stopped) == (20, "spp")


def test_a_black_picture_does_not_wait_for_its_noise(monkeypatch):
    result = render(FakeScene(lambda seed, spp: np.zeros((4, 6, 3)), monkeypatch), noise=0.01)
    assert result.stopped == "dark"
    assert result.spp <= 128
    assert "no light" in result.notes[0]


def test_ctrl_c_returns_the_picture_so_far_and_restores_the_handler(scene):
    def press(progress):
        if progress.passes == 3:
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    result = render(scene, spp=4096, on_progress=press)
    assert result.interrupted
    assert result.stopped == "interrupted"
    assert result.passes in (3, 4)
    assert np.isfinite(result.pixels).all()
    assert result.pixels.mean() > 0.01
    assert signal.getsignal(signal.SIGINT) is before
    # The picture is the beginning of the whole one, and Dr.Jit still works.
    assert np.isfinite(render(scene, spp=4).pixels).all()


def test_a_second_ctrl_c_ends_at_once(monkeypatch):
    def press_twice(seed, spp):
        if len(fake.seeds) == 3:
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)
            for _ in range(1000):
                time.sleep(0.001)
            pytest.fail("still running")
        return noisy(seed, spp)

    fake = FakeScene(press_twice, monkeypatch)
    result = render(fake, spp=64)
    assert result.interrupted
    assert result.passes == 2


def test_an_interrupt_before_the_first_picture_is_raised(monkeypatch):
    def interrupt(seed, spp):
        raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        render(FakeScene(interrupt, monkeypatch), spp=4)
    assert signal.getsignal(signal.SIGINT) is before


def test_other_errors_are_not_hidden(monkeypatch):
    def fail(seed, spp):
        raise RuntimeError("out of memory")

    with pytest.raises(RuntimeError, match="out of memory"):
        render(FakeScene(fail, monkeypatch), spp=4)


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ({"spp": 0}, "spp"),
        ({"spp": 2.5}, "spp"),
        ({"spp": True}, "spp"),
        ({"time_s": 0}, "time_s"),
        ({"time_s": float("nan")}, "time_s"),
        ({"noise": -0.1}, "noise"),
        ({"noise": float("inf")}, "noise"),
        ({"seed": -1}, "seed"),
        ({"seed": 1.5}, "seed"),
        ({"max_samples": 0}, "max_samples"),
    ],
)
def test_impossible_goals_are_refused(monkeypatch, goal, reason):
    with pytest.raises(ParameterError, match=reason):
        render(FakeScene(noisy, monkeypatch), **goal)
