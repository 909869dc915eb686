"""What ends up on the film: AOVs, filters, crops, alpha, hidden emitters, sample counts, seeds."""

import gc

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from nephrite.plugins import camera, sequence
from support import measure, scenes
from support.quick import slow


def _scene(**film):
    scene = scenes.camera(16, **film)
    scene["object"] = scenes.placed("sphere") | scenes.translucent((0.02, 0.05, 0.1), 0.6)
    scene["light"] = scenes.light((0.6, 0.5, 0.6), 24.0, 6.0)
    return scene


def test_a_gaussian_filter_keeps_the_mean():
    box, gaussian = (
        measure.picture(_scene(rfilter=name), scenes.ours(), 1024) for name in ("box", "gaussian")
    )
    assert gaussian[4:12, 4:12].mean() == pytest.approx(box[4:12, 4:12].mean(), rel=0.02)


@pytest.mark.slow
def test_a_crop_window_is_a_part_of_the_picture():
    whole = measure.passes(_scene(), scenes.ours(), 128, 10, 100)
    crop = {"crop_offset_x": 4, "crop_offset_y": 8, "crop_width": 8, "crop_height": 4}
    part = measure.passes(_scene(**crop), scenes.ours(), 128, 10, 900)
    assert part.mean.shape == (4, 8, 3)
    measure.assert_same(part, measure.Passes(whole.pictures[:, 8:12, 4:12]))


@pytest.mark.parametrize("model", ["walk", "dipole", slow("tabulated")])
def test_paths_are_traced_once(model):
    scene, integrator = mi.load_dict(_scene()), mi.load_dict(scenes.ours(model=model))
    mi.render(scene, integrator=integrator, spp=4)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        dr.eval(mi.render(scene, integrator=integrator, spp=4))
        kernels = [k["operation_count"] for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
    assert sum(count > 1000 for count in kernels) == 1


def test_alpha_is_where_something_is():
    picture = measure.picture(_scene(pixel_format="rgba"), scenes.ours(), 64)
    assert picture.shape == (16, 16, 4)
    assert picture[8, 8, 3] == pytest.approx(1)
    assert picture[0, 0, 3] == pytest.approx(0)


@pytest.mark.parametrize("model", ["walk", "dipole", "brdf"])
def test_alpha_is_the_coverage_of_the_object(model):
    picture = measure.picture(_scene(pixel_format="rgba"), scenes.ours(model=model), 256)
    depth = measure.picture(_scene(pixel_format="rgba"), {"type": "path", "max_depth": 2}, 256)
    np.testing.assert_allclose(picture[..., 3], depth[..., 3], atol=0.15)


@pytest.mark.slow
def test_aovs_come_with_the_picture():
    integrator = {"type": "aov", "aovs": "d:depth,n:sh_normal", "own": scenes.ours()}
    plain = measure.passes(_scene(), scenes.ours(), 128, 8, 100)
    both = measure.passes(_scene(), integrator, 128, 8, 900)
    assert both.pictures.shape[3] == 3 + 1 + 3
    assert both.mean[8, 8, 3] == pytest.approx(45.0, abs=1.0)
    measure.assert_same(measure.Passes(both.pictures[..., :3]), plain)


def test_hidden_emitters_are_hidden_and_shine():
    scene = _scene()
    scene["light"] = scenes.light((0.0, 0.0, -1.0), 40.0, 1.0)
    seen, hidden = (measure.picture(scene, scenes.ours(hide_emitters=hide), 64) for hide in (False, True))
    assert seen[0, 0].mean() > 0.5
    assert hidden[0, 0].mean() == 0
    assert hidden[8, 8].mean() > 0


def test_a_seed_is_a_picture_and_another_seed_another():
    scene, method = mi.load_dict(_scene()), scenes.ours()
    a, b, c = (measure.picture(scene, method, 16, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert np.abs(a - c).max() > 0


@pytest.mark.parametrize("spp", [1, 3, 63, 65, 130])
def test_every_sample_count_has_that_many(spp):
    """A pixel of a constant environment is exact with any number of paths a lane."""
    scene = scenes.camera(4)
    scene["environment"] = scenes.environment((0.2, 0.5, 0.8))
    picture = measure.picture(scene, scenes.ours(), spp)
    np.testing.assert_allclose(picture, np.broadcast_to([0.2, 0.5, 0.8], picture.shape), rtol=1e-4)


def test_the_sensors_sample_count_holds_without_another():
    scene = scenes.camera(4)
    scene["sensor"]["sampler"] = {"type": "multijitter", "sample_count": 4}
    scene["environment"] = scenes.environment(1.0)
    picture = np.array(mi.render(mi.load_dict(scene), integrator=mi.load_dict(scenes.ours())))
    np.testing.assert_allclose(picture, 1.0, rtol=1e-4)


def test_a_scene_without_anything_is_black():
    assert not measure.picture(scenes.camera(4), scenes.ours(), 4).any()


def test_the_paths_of_a_pixel_begin_evenly():
    """No gap between 100 numbers is wider than .05; by chance, the widest of all pixels would be about .1."""
    sensor = mi.load_dict(_scene()).sensors()[0]
    lanes = camera.Camera(sensor, 100, 7)
    groups = int(lanes.even.turns[0])
    for dimension in range(sequence.TURN + 2):
        paths = [np.array(lanes.even(dimension, mi.UInt32(i), 0.5)) for i in range(100 // groups + 1)]
        pixels = np.array(paths).reshape(len(paths), -1, groups).swapaxes(1, 2).reshape(-1, 16 * 16)
        numbers = np.sort(pixels[:100], axis=0)
        assert numbers.min() >= 0.0
        assert numbers.max() < 1.0
        assert np.diff(numbers, axis=0).max() < 0.05
        assert np.unique(pixels[0]).size > 250  # each pixel's own
    other = camera.Camera(sensor, 100, 8)
    assert not np.allclose(other.even(0, mi.UInt32(0), 0.5), lanes.even(0, mi.UInt32(0), 0.5))
    assert float(lanes.even(0, mi.UInt32(0), 0.5, False)[0]) == 0.5


def test_the_steps_are_those_of_the_r_sequence():
    assert sequence.steps(1) == pytest.approx([0.6180339887498949])  # the golden ratio's
    assert sequence.steps(2) == pytest.approx(
        [0.7548776662466927, 0.5698402909980532]
    )  # the plastic number's


@pytest.mark.parametrize("model", ["walk", "dipole"])
def test_one_kernel_renders_all_passes_of_a_picture(model):
    """Whatever their samples and seeds, and wherever memory is: to compile it takes longer than many a pass."""
    gc.collect()  # objects that other tests have left behind are parts of kernels, as long as they are there
    scene = mi.load_dict(scenes.trial(scenes.TRIALS[0]))
    integrator = mi.load_dict(scenes.ours(model=model))
    found = set()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for seed, spp in enumerate((1, 2, 8, 3, 70, 1, 1)):
            dr.kernel_history_clear()
            mi.render(scene, integrator=integrator, spp=spp, seed=seed).numpy()
            history = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
            found.add(max(history, key=lambda k: k["operation_count"])["hash"])
        dr.kernel_history_clear()
    assert len(found) == 1
