"""Close what is left open: cracks between vertices that nearly touch, then holes, by MeshFix."""

from __future__ import annotations

import numpy as np

from nephrite.geometry.topology import (
    Floats,
    Ints,
    boundaries,
    components,
    edges_of,
    groups,
    merge_equal,
    pair_half_edges,
    weld,
)
from nephrite.geometry.winding import face_crosses, turned_over, wound_apart
from nephrite.scene.check import Finding, plural, signed_volume

CRACKS = (1e-7, 1e-6, 1e-5, 1e-4)  # widths to try, in diagonals of the mesh
MOST_LOOPS = 2000  # more boundaries than this are no holes: the mesh is a soup
LONGEST = 2000  # edges around a hole that MeshFix fills in seconds; it takes the square of that
THINNEST = 1e-4  # of area**1.5: less volume than this is a sheet with a lid on it, not a body


def close_holes(vertices: Floats, faces: Ints) -> tuple[Floats, Ints, list[Finding]]:
    """Close an open mesh as far as that makes sense; parts that are single sheets stay open.

    Returns:
        Vertices, faces, and the findings: `cracks` and `open`.
    """
    findings: list[Finding] = []
    rims = int(np.sum(edges_of(faces).balance != 0))
    vertices, faces = _snapped(vertices, faces)
    left = int(np.sum(edges_of(faces).balance != 0))
    if left < rims:
        text = f"{plural(rims - left, 'open edge')} along cracks between vertices that nearly touch"
        findings.append(Finding("cracks", rims - left, text, "sewn up"))
    if not left:
        return vertices, faces, findings
    loops = boundaries(faces)[0]
    if loops > MOST_LOOPS:
        return vertices, faces, findings
    vertices, faces, filled, share = _filled(vertices, faces)
    if filled:
        still = boundaries(faces)[0]
        text = f"{plural(left, 'open edge')} in {plural(loops, 'boundary')}"
        done = f"{loops - still} closed by {plural(filled, 'new face')}, {share:.2g} of the surface"
        findings.append(Finding("open", left, text, done, solved=share < 0.02))
    return vertices, faces, findings


def _snapped(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Merge vertices on boundaries that nearly touch, at the least distance that closes the most.

    Only if that closes half of what is open: otherwise they are near each other for other reasons.
    """
    from scipy.spatial import KDTree

    best = np.sum(edges_of(faces).balance != 0) // 2
    result = vertices, faces
    vertices, faces = merge_equal(vertices, faces)
    edges = edges_of(faces)
    at = edges.open_half_edges
    rim = np.unique(np.concatenate([edges.tail[at], edges.head[at]]))
    low = vertices.min(axis=0)
    diagonal = float(np.linalg.norm(vertices.max(axis=0) - low))
    tree = KDTree((vertices[rim] - low) / diagonal)
    for width in CRACKS:
        if tree.count_neighbors(tree, width) > 50 * len(rim):
            break  # a cloud of vertices closer than that: merging it would change the shape
        near = tree.query_pairs(width, output_type="ndarray")
        if not len(near):
            continue
        _, place = groups(rim[near[:, 0]], rim[near[:, 1]], len(vertices))
        _, first = np.unique(place, return_index=True)
        merged, joined = merge_equal(vertices[first][place], faces)
        joined = joined[~(joined == np.roll(joined, -1, axis=1)).any(axis=1)]
        apart, two_sided = wound_apart(joined)
        joined = turned_over(joined, apart)
        if not len(joined) or not two_sided:
            continue
        source, welded = weld(joined, pair_half_edges(merged, joined))
        if (rims := np.sum(edges_of(welded).balance != 0)) < best:
            best, result = rims, (merged[source], welded)
        if not best:
            break
    return result


def _filled(vertices: Floats, faces: Ints) -> tuple[Floats, Ints, int, float]:
    """Fill the holes of each open part: vertices, faces, number of new faces, their share of the area."""
    number, part = components(faces)
    is_open = np.zeros(number, dtype=bool)
    is_open[part[edges_of(faces).open_half_edges // 3]] = True
    bodies, shells, offset, new, lid = [vertices], [faces[~is_open[part]]], len(vertices), 0, 0.0
    for p in np.flatnonzero(is_open):
        before = faces[part == p]
        after = before
        if len(before) > 1:
            used, compact = np.unique(before, return_inverse=True)
            points, triangles = _meshfixed(*_fanned(vertices[used], compact.reshape(-1, 3)))
            if _is_better(points, triangles, vertices, before):
                bodies.append(points)
                after = triangles + offset
                offset += len(points)
                new += len(triangles) - len(before)
                lid += _area(points, triangles) - _area(vertices, before)
        shells.append(after)
    places, joined = np.concatenate(bodies), np.concatenate(shells)
    return places, joined, new, lid / _area(places, joined)


def _fanned(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Close the longest holes by triangles to the middle of each."""
    number, at, hole = boundaries(faces)
    edges = edges_of(faces)
    tail, head = edges.tail[at], edges.head[at]
    length = np.bincount(hole, minlength=number)
    middle = (
        np.stack([np.bincount(hole, vertices[tail, k], number) for k in range(3)], axis=1) / length[:, None]
    )
    lid = np.stack([head, tail, len(vertices) + hole], axis=1)[length[hole] > LONGEST]
    return np.concatenate([vertices, middle]), np.concatenate([faces, lid])


def _meshfixed(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Let MeshFix close what is open."""
    if not edges_of(faces).balance.any():
        return vertices, faces
    import pymeshfix

    low = vertices.min(axis=0)
    size = float((vertices.max(axis=0) - low).max())
    fixer = pymeshfix.PyTMesh()
    fixer.set_quiet(True)
    fixer.load_array((vertices - low) / size, faces.astype(np.int32))
    fixer.fill_small_boundaries(0, True)
    points, triangles = fixer.return_arrays()
    return points * size + low, triangles.astype(np.int64)


def _is_better(points: Floats, triangles: Ints, vertices: Floats, before: Ints) -> bool:
    """Whether a filled part is closed, a body rather than a lid on a sheet, and has lost nothing."""
    if len(triangles) <= len(before) or edges_of(triangles).balance.any():
        return False
    area = _area(points, triangles)
    if area < _area(vertices, before) * (1 - 1e-6):
        return False
    return abs(signed_volume(points, triangles)) > THINNEST * area**1.5


def _area(vertices: Floats, faces: Ints) -> float:
    return float(np.linalg.norm(face_crosses(vertices, faces), axis=1).sum() / 2)
