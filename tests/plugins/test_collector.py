"""Python's garbage collector while kernels are recorded: it removes no scene on the way."""

import gc

import pytest

from nephrite.plugins import collector, path
from support import measure, scenes


@pytest.mark.parametrize("before", [True, False])
def test_it_is_kept_off_for_a_picture_alone(before, monkeypatch):
    seen = []
    trace = path.trace
    monkeypatch.setattr(path, "trace", lambda *given: seen.append(gc.isenabled()) or trace(*given))
    description = scenes.camera(4) | {"light": scenes.environment()}
    description["object"] = scenes.placed("sphere") | scenes.translucent(0.1, 1.0)
    was = gc.isenabled()
    try:
        gc.enable() if before else gc.disable()
        measure.picture(description, scenes.ours(), 1)
        assert seen == [False]
        assert gc.isenabled() == before
    finally:
        gc.enable() if was else gc.disable()


def test_it_goes_on_after_an_error():
    with pytest.raises(ValueError, match="here"), collector.kept_off():
        raise ValueError("here")
    assert gc.isenabled()
