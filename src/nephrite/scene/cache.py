"""Meshes kept in the user's cache folder: verified when read, complete when written."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

from platformdirs import user_cache_path

from nephrite.scene.check import Finding, MeshReport
from nephrite.scene.ply import encode, write_atomically
from nephrite.scene.reading import read
from nephrite.scene.triangles import TriangleMesh

ENVIRONMENT_VARIABLE = "NEPHRITE_CACHE"


def folder() -> Path:
    """Return the cache folder: `$NEPHRITE_CACHE`, or the system's own place; it need not exist yet."""
    chosen = os.environ.get(ENVIRONMENT_VARIABLE)
    return Path(chosen) if chosen else user_cache_path("nephrite", appauthor=False)


def store(mesh: TriangleMesh, key: str) -> None:
    """Keep a repaired mesh under `key`; a cache that cannot be written to is passed over in silence.

    Coordinates are kept in single precision, and the report beside them with the file's checksum.
    """
    data = encode(mesh.vertices, mesh.faces)
    report = mesh.report
    record = {
        "sha256": hashlib.sha256(data).hexdigest(),
        "closed": report.closed,
        "parts": report.parts,
        "volume": report.volume,
        "findings": [vars(finding) for finding in report.findings],
    }
    try:
        write_atomically(folder() / f"{key}.ply", data)
        write_atomically(folder() / f"{key}.json", json.dumps(record, indent=1).encode())
    except OSError:
        return


def recall(key: str, name: str) -> TriangleMesh | None:
    """Return the mesh kept under `key`, or None if there is none or it is damaged."""
    path = folder() / f"{key}.ply"
    try:
        record = json.loads((folder() / f"{key}.json").read_text())
        if hashlib.sha256(path.read_bytes()).hexdigest() != record["sha256"]:
            return None
        findings = tuple(Finding(**finding) for finding in record["findings"])
        report = MeshReport(findings, record["closed"], record["parts"], record["volume"], repaired=True)
        vertices, faces = read(path)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return TriangleMesh(vertices, faces, name, report)
