"""Make a mesh fit for rendering volumes: closed, facing outwards, without changing its shape.

First what is exact - no vertex moves, no volume changes: vertices at one place are merged, faces turned over
until neighbours agree, folded pairs of faces cancelled, and bodies that only touch along an edge taken apart.
That alone closes many scans (the Stanford dragon among them). Only the holes that are left are filled.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nephrite.errors import MeshError
from nephrite.geometry.topology import (
    Floats,
    Ints,
    components,
    edges_of,
    merge_equal,
    net_faces,
    pair_half_edges,
    weld,
)
from nephrite.geometry.winding import face_crosses, face_volumes, inside_out, turned_over, wound_apart
from nephrite.scene.check import Finding, examine, flat_faces, plural
from nephrite.scene.holes import close_holes
from nephrite.scene.triangles import TriangleMesh

SPECK = 1e-9  # of the volume: closed parts smaller than this are dust
FAR = 1e5  # distances from the origin, in lengths of the mesh, at which single precision shows


def repair(mesh: TriangleMesh) -> TriangleMesh:
    """Return the mesh closed where possible, wound outwards, with a report of what was found and done.

    A mesh that is well already comes back with the same triangles. One that can't be closed (a single sheet,
    a soup of triangles) comes back as the surface that it is, and its report says so.

    Raises:
        MeshError: nothing is left that has an area.
    """
    if mesh.report.repaired:
        return mesh
    vertices, faces = mesh.vertices, mesh.faces
    findings: list[Finding] = []
    vertices, faces = _without_bad_faces(vertices, faces, findings, mesh.name)
    _warn_if_far(vertices, findings)
    faces = _without_folds(faces, findings)
    apart, two_sided = wound_apart(faces)
    if turned := int(apart.sum()):
        findings.append(
            Finding("winding", turned, f"{plural(turned, 'face')} wound the other way", "turned over")
        )
    faces = turned_over(faces, apart)
    if not two_sided:
        findings.append(Finding("one-sided", 1, "a one-sided surface (Möbius strip)", solved=False))
    faces = _outwards(
        vertices, faces, findings
    )  # what touches at an edge is told apart by where the solid is
    vertices, faces = _manifold(vertices, faces, findings)
    if two_sided and edges_of(faces).balance.any():
        vertices, faces, done = close_holes(vertices, faces)
        findings += done
    faces = _outwards(vertices, faces, findings)
    faces = _without_specks(vertices, faces, findings)
    used, compact = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[used], compact.reshape(-1, 3).astype(np.int64)
    now = examine(vertices, faces)
    known = {finding.kind for finding in findings}
    still = [finding for finding in now.findings if not (finding.solved and finding.kind in known)]
    report = replace(now, findings=(*findings, *still), repaired=True)
    return replace(mesh, vertices=vertices, faces=faces, report=report)


def _without_bad_faces(
    vertices: Floats, faces: Ints, findings: list[Finding], name: str
) -> tuple[Floats, Ints]:
    finite = np.all(np.isfinite(vertices), axis=1)
    good = np.all(finite[faces], axis=1)
    if bad := int(np.sum(~good)):
        text = f"{plural(bad, 'face')} with coordinates that are not numbers"
        findings.append(Finding("non-finite", bad, text, "left out"))
    if not good.any():
        raise MeshError(f"{name} has no face with finite coordinates. Export it again.")
    vertices, faces = merge_equal(vertices, faces[good])
    point = (faces == np.roll(faces, -1, axis=1)).any(axis=1)
    if bad := int(point.sum()):
        findings.append(
            Finding("degenerate", bad, f"{plural(bad, 'face')} shrunk to an edge or a point", "left out")
        )
    faces = faces[~point]
    if not len(faces) or flat_faces(vertices, faces) == len(faces):
        raise MeshError(f"{name} has no area: all of its faces are points or lines. Export it again.")
    return vertices, faces


def _warn_if_far(vertices: Floats, findings: list[Finding]) -> None:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    ratio = float(np.abs((low + high) / 2).max() / max((high - low).max(), np.finfo(float).tiny))
    if ratio > FAR:
        text = f"the mesh lies {ratio:.2g} times its own size away from the origin"
        advice = "its file may have lost digits; centre it before exporting"
        findings.append(Finding("far-away", 1, text, advice, solved=False))


def _without_folds(faces: Ints, findings: list[Finding]) -> Ints:
    left, folded, repeated = net_faces(faces)
    if repeated and np.sum(edges_of(left).balance != 0) > np.sum(edges_of(faces).balance != 0):
        left, folded, repeated = net_faces(faces, keep_repeats=True)
    if not len(left):
        return faces  # a sheet modelled with both of its sides, and nothing else: nothing to gain
    if repeated:
        findings.append(
            Finding("repeated", repeated, f"{plural(repeated, 'face')} that are there twice", "left out")
        )
    if folded:
        text = f"{plural(folded, 'face')} folded onto each other, without volume between them"
        findings.append(Finding("folded", folded, text, "left out"))
    return left


def _manifold(vertices: Floats, faces: Ints, findings: list[Finding]) -> tuple[Floats, Ints]:
    crowded = int(np.sum(edges_of(faces).faces_at > 2))
    source, welded = weld(faces, pair_half_edges(vertices, faces))
    if crowded:
        text = f"{plural(crowded, 'edge')} with more than two faces"
        findings.append(Finding("non-manifold", crowded, text, "taken apart where bodies only touch"))
    return vertices[source], welded


def _outwards(vertices: Floats, faces: Ints, findings: list[Finding]) -> Ints:
    turned, parts, number = inside_out(vertices, faces)
    if not turned.any():
        return faces
    text = f"{parts} of {number} parts inside out" if number > 1 else "the mesh is inside out"
    findings.append(Finding("inside-out", int(turned.sum()), text, "turned over"))
    return turned_over(faces, turned)


def _without_specks(vertices: Floats, faces: Ints, findings: list[Finding]) -> Ints:
    """Leave out closed parts of next to no volume, if there is a real body beside them."""
    number, part = components(faces)
    if number == 1:
        return faces
    volume = np.abs(np.bincount(part, weights=face_volumes(vertices, faces), minlength=number))
    is_open = np.zeros(number, dtype=bool)
    is_open[part[edges_of(faces).open_half_edges // 3]] = True
    area = (
        np.bincount(part, weights=np.linalg.norm(face_crosses(vertices, faces), axis=1), minlength=number) / 2
    )
    speck = ~is_open & (volume <= SPECK * volume.max()) & (area <= 1e-3 * area.max())
    if not speck.any() or volume.max() == 0:
        return faces
    gone = speck[part]
    text = f"{plural(int(speck.sum()), 'speck')} of {plural(int(gone.sum()), 'face')}, without volume"
    findings.append(Finding("specks", int(speck.sum()), text, "left out"))
    return faces[~gone]
