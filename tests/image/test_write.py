"""Files that hold what they should, are there or not there, and refuse in time."""

import errno
import os
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import nephrite
from nephrite.errors import ParameterError
from nephrite.image import write
from nephrite.image.tonemap import to_srgb8

SETTINGS = {
    "material": "jade",
    "size": "100 mm",
    "camera.eye": "0.25 0.75 1.75",
    "note": "Šidák, µ = 1\nsecond line",
    "empty": "",
    "type": "a name that the format itself uses",
    "k" * write.MAX_KEY: "v" * 3000,
}


@pytest.fixture
def pixels():
    return np.random.default_rng(1).uniform(0, 3, (6, 9, 3)).astype(np.float32)


def read_exr(path):
    import mitsuba as mi

    return np.array(mi.Bitmap(str(path)))


def test_png_holds_the_tone_mapped_picture(tmp_path, pixels):
    path = write.save(tmp_path / "a.png", pixels, exposure=-1.0, shoulder=True)
    with Image.open(path) as image:
        assert image.mode == "RGB"
        assert np.array_equal(np.asarray(image), to_srgb8(pixels, -1.0, True))


def test_exr_holds_the_light_unchanged(tmp_path, pixels):
    pixels[0, 0] = (1e6, -2.0, np.inf)
    path = write.save(tmp_path / "a.exr", pixels, exposure=3.0)
    np.testing.assert_array_equal(read_exr(path), pixels)


@pytest.mark.parametrize("name", ["a.png", "a.exr", "b.PNG", "b.EXR"])
def test_settings_come_back(tmp_path, pixels, name):
    path = write.save(tmp_path / name, pixels, SETTINGS)
    assert write.read_metadata(path) == {**SETTINGS, "version": nephrite.__version__}


def test_exr_needs_no_variant(tmp_path):
    code = (
        "import numpy as np, nephrite; from nephrite.image import write\n"
        f"path = write.save({str(tmp_path / 'a.exr')!r}, np.ones((2, 3, 3), np.float32), dict(a='b'))\n"
        "import mitsuba as mi; print(write.read_metadata(path)['a'], mi.variant())"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["b", "None"]


def test_a_figure_is_written_as_it_is_and_only_as_png(tmp_path):
    figure = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    with Image.open(write.save(tmp_path / "f.png", figure, exposure=2.0)) as image:
        assert np.array_equal(np.asarray(image), figure)
    with pytest.raises(ParameterError, match="PNG"):
        write.save(tmp_path / "f.exr", figure)


@pytest.mark.parametrize("suffix", [".png", ".exr"])
@pytest.mark.parametrize("step", ["open", "fsync", "replace"])
def test_a_failure_midway_leaves_the_good_file_and_nothing_else(tmp_path, pixels, suffix, step, monkeypatch):
    path = write.save(tmp_path / f"good{suffix}", pixels)
    before = path.read_bytes()

    def fail(*args, **kwargs):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    class FullDisk:
        """A file that takes half of what is written."""

        def __init__(self, path, mode):
            self.file = Path(path).open(mode)  # noqa: SIM115 (closed on exit)

        def __enter__(self):
            return self

        def __exit__(self, *exception):
            self.file.close()

        def write(self, content):
            self.file.write(content[: len(content) // 2])
            fail()

    if step == "open":
        monkeypatch.setattr(write, "open", FullDisk, raising=False)
    else:
        monkeypatch.setattr(write.os, step, fail)
    with pytest.raises(ParameterError, match="No space left"):
        write.save(path, pixels * 2)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_ctrl_c_midway_leaves_the_good_file_and_nothing_else(tmp_path, pixels, monkeypatch):
    path = write.save(tmp_path / "good.png", pixels)
    before = path.read_bytes()

    def interrupt(number):
        raise KeyboardInterrupt

    monkeypatch.setattr(write.os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write.save(path, pixels * 2)
    assert path.read_bytes() == before
    assert len(list(tmp_path.iterdir())) == 1


def test_a_new_file_has_the_usual_permissions_and_an_old_one_keeps_its_own(tmp_path, pixels):
    plain = tmp_path / "plain"
    plain.touch()
    path = write.save(tmp_path / "a.png", pixels)
    assert path.stat().st_mode == plain.stat().st_mode
    path.chmod(0o640)
    write.save(path, pixels)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_link_stays_a_link(tmp_path, pixels):
    target = write.save(tmp_path / "target.png", pixels)
    link = tmp_path / "link.png"
    link.symlink_to(target)
    write.save(link, np.zeros((1, 1, 3)))
    assert link.is_symlink()
    with Image.open(target) as image:
        assert image.size == (1, 1)


def test_check_makes_the_last_folder_and_says_so(tmp_path):
    message = write.check_writable(tmp_path / "out" / "a.png")
    assert message is not None
    assert "out" in message
    assert (tmp_path / "out").is_dir()
    assert write.check_writable(tmp_path / "out" / "a.png") is None
    assert list((tmp_path / "out").iterdir()) == []


def test_check_does_not_touch_a_file_that_is_there(tmp_path, pixels):
    path = write.save(tmp_path / "a.png", pixels)
    before = path.read_bytes(), path.stat().st_mtime_ns
    write.check_writable(path)
    assert (path.read_bytes(), path.stat().st_mtime_ns) == before


def test_refused_paths(tmp_path, pixels):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file").touch()
    read_only = write.save(tmp_path / "kept.png", pixels)
    read_only.chmod(0o444)
    os.mkfifo(tmp_path / "pipe.png")
    for path, reason in {
        tmp_path / "a.jpg": r"\.exr or \.png",
        tmp_path / "a": r"\.exr or \.png",
        tmp_path / "no" / "such" / "a.png": "is not a folder either",
        tmp_path / "folder.png": "is a folder",
        tmp_path / "file" / "a.png": "is a file, not a folder|Not a directory",
        read_only: "read-only",
        tmp_path / "pipe.png": "not an ordinary file",
        tmp_path / ("n" * 300 + ".png"): "too long",
    }.items():
        with pytest.raises(ParameterError, match=reason):
            write.check_writable(path)
        with pytest.raises(ParameterError, match=reason):
            write.save(path, pixels)
    assert not (tmp_path / "no").exists()


def test_a_folder_without_permission_is_refused(tmp_path, monkeypatch):
    # The superuser may write anywhere, so the refusal itself is simulated.
    def refuse(*args, **kwargs):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(write.os, "open", refuse)
    with pytest.raises(ParameterError, match="Permission denied"):
        write.check_writable(tmp_path / "a.png")


@pytest.mark.parametrize("shape", [(4, 5), (4, 5, 4), (0, 5, 3)])
def test_pictures_of_other_shapes_are_refused(tmp_path, shape):
    with pytest.raises(ParameterError, match="shape"):
        write.save(tmp_path / "a.png", np.zeros(shape))


@pytest.mark.parametrize("metadata", [{"": "a"}, {"é": "a"}, {"k" * 80: "a"}, {"a": 3}, {"a": "b\0c"}])
def test_metadata_that_files_cannot_hold_is_refused(tmp_path, pixels, metadata):
    with pytest.raises(ParameterError, match="metadata"):
        write.save(tmp_path / "a.png", pixels, metadata)
    assert not (tmp_path / "a.png").exists()


def test_files_of_others_have_no_settings_and_broken_ones_are_refused(tmp_path):
    Image.new("RGB", (2, 2)).save(tmp_path / "other.png")
    assert write.read_metadata(tmp_path / "other.png") == {}
    for name in ("broken.png", "broken.exr"):
        (tmp_path / name).write_bytes(b"nothing of the kind")
        with pytest.raises(ParameterError, match="cannot read"):
            write.read_metadata(tmp_path / name)
    with pytest.raises(ParameterError, match="cannot read"):
        write.read_metadata(tmp_path / "missing.exr")
