"""Meshes as files that Mitsuba reads: a folder of PLY files that lives as long as the process."""

from __future__ import annotations

import atexit
import functools
import hashlib
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nephrite.scene.triangles import TriangleMesh


def mesh_plugin(mesh: TriangleMesh) -> dict[str, Any]:
    """Return the Mitsuba plugin dictionary of `mesh`, written to a file that is removed when Python ends.

    The same vertices and faces give the same file, which is written once.
    """
    from nephrite.scene.meshes import write_ply

    content = hashlib.sha256(mesh.vertices.tobytes())
    content.update(mesh.faces.tobytes())
    path = _folder() / f"{content.hexdigest()[:24]}.ply"
    if not path.exists():
        write_ply(mesh, path)
    return {"type": "ply", "filename": str(path)}


@functools.cache
def _folder() -> Path:
    folder = tempfile.TemporaryDirectory(prefix="nephrite-")
    atexit.register(folder.cleanup)
    return Path(folder.name)
