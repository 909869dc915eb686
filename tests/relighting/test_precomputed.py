"""Transport in files: the same frames, and a clear no to files of other objects and of other programs."""

import mitsuba as mi
import numpy as np
import pytest

from nephrite.errors import ParameterError
from nephrite.relighting import Viewer, load, precompute
from support import scenes


def _scene(radius=8.0, sigma_a=0.01, second=False):
    scene = scenes.camera(8) | {"lamp": scenes.light((0.6, 0.7, 0.3))}
    scene["ball"] = {"type": "sphere", "radius": radius} | scenes.translucent(sigma_a, 1.0)
    if second:
        scene["other"] = {"type": "sphere", "radius": 2.0, "center": [20, 0, 0]} | scenes.translucent(
            0.0, 4.0
        )
    return mi.load_dict(scene)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("transport") / "ball.npz"
    made = precompute(_scene(), walks=20_000)
    made.save(path)
    return made, path


def test_a_file_gives_the_same_frames(file):
    made, path = file
    first, second = Viewer(_scene(), made), Viewer(_scene(), path)
    np.testing.assert_allclose(second.frame(), first.frame(), rtol=1e-5, atol=1e-7)
    again = path.with_name("again.npz")
    second.save(again)
    assert again.read_bytes() == path.read_bytes()
    assert sorted(p.name for p in path.parent.iterdir()) == ["again.npz", "ball.npz"]


def test_another_object_is_refused_with_what_differs(file):
    with pytest.raises(ParameterError, match="another shape"):
        Viewer(_scene(radius=7.0), file[1])
    with pytest.raises(ParameterError, match=r"another sigma_a: \[0.01.* there, \[0.02.* here"):
        Viewer(_scene(sigma_a=0.02), file[1])
    with pytest.raises(ParameterError, match="1 translucent shapes, but the scene has 2"):
        Viewer(_scene(second=True), file[1])


def test_other_files_are_refused(file, tmp_path):
    with pytest.raises(ParameterError, match="no file"):
        load(tmp_path / "nothing.npz")
    foreign = tmp_path / "foreign.npz"
    np.savez(foreign, a=np.ones(3))
    text = tmp_path / "text.npz"
    text.write_text("no transport")
    short = tmp_path / "short.npz"
    whole = file[1].read_bytes()
    short.write_bytes(whole[: len(whole) // 2])
    flipped = tmp_path / "flipped.npz"
    flipped.write_bytes(
        whole[: len(whole) // 2] + bytes([whole[len(whole) // 2] ^ 255]) + whole[len(whole) // 2 + 1 :]
    )
    for path in (foreign, text, short, flipped, tmp_path):
        with pytest.raises(ParameterError, match=r"holds no transport, or is damaged"):
            load(path)


def test_a_file_that_cannot_be_written_is_told(file, tmp_path):
    with pytest.raises(ParameterError, match="cannot write"):
        file[0].save(tmp_path / "deep" / "deeper" / "ball.npz")
