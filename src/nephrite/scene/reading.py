"""Mesh files in: PLY, OBJ, STL, OFF, GLB and glTF, also gzipped, as plain arrays; nothing is repaired."""

from __future__ import annotations

import gzip
import io
import re
import warnings
import zlib
from pathlib import Path

import numpy as np

from nephrite.errors import MeshError
from nephrite.geometry.topology import Floats, Ints

FORMATS = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf")
LARGEST = 1e90  # volumes are products of three lengths, and must stay finite in double precision


def read(path: Path | str) -> tuple[Floats, Ints]:
    """Read all triangles of a file, in the units and axes of the file; scenes are put together into one mesh.

    Returns:
        `(N, 3)` vertices and `(M, 3)` faces, M > 0, every vertex number valid. Vertices may be repeated or
        not finite.

    Raises:
        MeshError: missing, empty, truncated, of unknown format or without triangles.
    """
    path = Path(path)
    data, suffix = _content(path)
    try:
        vertices, faces = _parse(data, suffix, path)
    except MeshError:
        raise
    except ModuleNotFoundError as error:
        # trimesh reaches for optional modules to guess the encoding of what is not text.
        raise _broken(path, f"it is no {suffix[1:].upper()} file, or a truncated one ({error})") from error
    except MemoryError as error:
        raise _broken(path, "its header announces more than fits into memory") from error
    except Exception as error:  # a parser fed with garbage raises anything
        raise _broken(path, f"{type(error).__name__}: {error}") from error
    if not len(faces):
        raise MeshError(f"{path} has no faces ({len(vertices)} points). Export it as a triangle mesh.")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise _broken(path, f"faces name vertex {int(faces.max())} of {len(vertices)}")
    promised = _promised_faces(data, suffix)
    if promised > len(faces):
        raise _broken(path, f"it ends after {len(faces)} of {promised} faces")
    far = float(np.abs(vertices[np.isfinite(vertices)]).max(initial=0.0))
    if far > LARGEST:
        raise MeshError(f"{path} has coordinates up to {far:.3g}. Scale it down; {LARGEST:.0e} is the limit.")
    return vertices, faces


def _content(path: Path) -> tuple[bytes, str]:
    suffixes = [suffix.lower() for suffix in path.suffixes]
    zipped = suffixes[-1:] == [".gz"]
    suffix = next(iter(suffixes[-2:-1] if zipped else suffixes[-1:]), "")
    if not path.exists():
        raise MeshError(f"there is no mesh {path}. Check the path, relative to {Path.cwd()}.")
    if not path.is_file():
        raise MeshError(f"{path} is not a file. Name a mesh in it.")
    if suffix not in FORMATS:
        raise MeshError(
            f"{path} has the unknown mesh format {suffix!r}. Convert it to one of {', '.join(FORMATS)}."
        )
    try:
        data = gzip.decompress(path.read_bytes()) if zipped else path.read_bytes()
    except (OSError, EOFError, zlib.error) as error:
        raise _broken(path, str(error)) from error
    if not data.strip():
        raise MeshError(f"{path} is empty. Export or download it again.")
    return data, suffix


def _parse(data: bytes, suffix: str, path: Path) -> tuple[Floats, Ints]:
    import trimesh
    from trimesh.resolvers import FilePathResolver

    # A glTF keeps its numbers in files beside it; all other formats need nothing but their own bytes.
    resolver = FilePathResolver(str(path)) if suffix == ".gltf" else None
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        scene = trimesh.load_scene(
            io.BytesIO(data), file_type=suffix[1:], resolver=resolver, process=False, skip_materials=True
        )
        meshes = [part for part in scene.geometry.values() if isinstance(part, trimesh.Trimesh)]
        if not meshes:
            points = sum(len(getattr(part, "vertices", ())) for part in scene.geometry.values())
            return np.zeros((points, 3)), np.zeros((0, 3), dtype=np.int64)
        whole = scene.to_mesh()
        return np.array(whole.vertices, dtype=np.float64), np.array(whole.faces, dtype=np.int64)


def _promised_faces(data: bytes, suffix: str) -> int:
    """How many faces a text format's header announces; parsers don't all notice that some are missing."""
    if suffix == ".ply":
        match = re.search(rb"element\s+face\s+(\d+)", data[:65536])
        return int(match[1]) if match else 0
    if suffix == ".off":
        match = re.match(rb"\s*OFF\s+(?:#.*\s+)*\d+\s+(\d+)", data)
        return int(match[1]) if match else 0
    return 0


def _broken(path: Path, why: str) -> MeshError:
    return MeshError(f"{path} cannot be read: {why}. The file may be truncated; export or download it again.")
