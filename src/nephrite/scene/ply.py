"""Binary PLY out: complete or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np

from nephrite.errors import MeshError
from nephrite.geometry.topology import Floats, Ints
from nephrite.scene.normals import with_normals
from nephrite.scene.triangles import TriangleMesh


def write_ply(mesh: TriangleMesh, path: Path | str) -> Path:
    """Write a mesh with vertex normals (see `normals.with_normals`) as Mitsuba's `ply` shape reads it.

    Positions become single precision. The file appears under its name only when it is complete.

    Raises:
        MeshError: the place cannot be written.
    """
    path = Path(path)
    try:
        write_atomically(path, encode(*with_normals(mesh.vertices, mesh.faces)))
    except OSError as error:
        raise MeshError(f"cannot write the mesh {path}: {error.strerror}. Choose another folder.") from error
    return path


def encode(vertices: Floats, faces: Ints, normals: Floats | None = None) -> bytes:
    """Return the bytes of a little-endian PLY of `(N, 3)` vertices, `(M, 3)` faces and `(N, 3)` normals."""
    names = ("x", "y", "z") if normals is None else ("x", "y", "z", "nx", "ny", "nz")
    header = "\n".join(
        [
            "ply",
            "format binary_little_endian 1.0",
            f"element vertex {len(vertices)}",
            *(f"property float {name}" for name in names),
            f"element face {len(faces)}",
            "property list uchar int vertex_indices",
            "end_header\n",
        ]
    )
    rows = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    columns = vertices if normals is None else np.concatenate([vertices, normals], axis=1)
    return header.encode() + columns.astype("<f4").tobytes() + rows.tobytes()


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file so that its name never shows a part of it, even to another process."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
