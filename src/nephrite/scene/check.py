"""What is wrong with a mesh: measured, counted and put into words."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nephrite.geometry.topology import Floats, Ints, boundaries, components, edges_of
from nephrite.geometry.winding import face_crosses, face_volumes


@dataclass(frozen=True)
class Finding:
    """One thing that was noticed about a mesh.

    Attributes:
        kind: a fixed word to test for: `non-finite`, `degenerate`, `repeated`, `folded`, `winding`,
            `inside-out`, `one-sided`, `non-manifold`, `open`, `specks`, `parts`, `far-away`,
            `cracks`.
        count: how many faces, edges, ... it concerns.
        found: what was found, for people.
        done: what was done about it, for people; empty if nothing.
        solved: whether it is harmless now.
    """

    kind: str
    count: int
    found: str
    done: str = ""
    solved: bool = True

    def __str__(self) -> str:
        """Return one line."""
        return f"{self.found}: {self.done}" if self.done else self.found


@dataclass(frozen=True)
class MeshReport:
    """The findings about a mesh and the state that it is in now.

    Attributes:
        findings: what was found, in the order in which it was dealt with.
        closed: whether the surface bounds a volume.
        parts: number of pieces that share no vertex.
        volume: enclosed volume (cubed units of the mesh), 0 if it is not closed.
        repaired: whether `repair` has been over it.
    """

    findings: tuple[Finding, ...]
    closed: bool
    parts: int
    volume: float
    repaired: bool = False

    def __contains__(self, kind: str) -> bool:
        """Whether anything of that `kind` was found."""
        return any(finding.kind == kind for finding in self.findings)

    def __getitem__(self, kind: str) -> Finding:
        """Return the first finding of a `kind`; KeyError if there is none."""
        for finding in self.findings:
            if finding.kind == kind:
                return finding
        raise KeyError(kind)

    def __str__(self) -> str:
        """Return one line for each finding, and one for the state."""
        state = "closed" if self.closed else "not closed: right for surfaces only, not for what is inside"
        pieces = f", {self.parts} parts" if self.parts > 1 else ""
        return "\n".join([*map(str, self.findings), state + pieces])

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know because it is still so."""
        return tuple(str(finding) for finding in self.findings if not finding.solved)

    def scaled(self, factor: float) -> MeshReport:
        """Return the report of the same mesh with every length multiplied by `factor`."""
        return replace(self, volume=self.volume * factor**3)


UNSEEN = MeshReport((), False, 0, 0.0)  # of a mesh that nobody has looked at yet


def examine(vertices: Floats, faces: Ints) -> MeshReport:
    """Report on the state of `(N, 3)` vertices and `(M, 3)` faces."""
    edges = edges_of(faces)
    closed = not edges.balance.any()
    found: list[Finding] = []
    if flat := flat_faces(vertices, faces):
        found.append(Finding("degenerate", flat, f"{plural(flat, 'face')} without area", "never hit"))
    if crowded := int(np.sum(edges.faces_at > 2)):
        text = f"{plural(crowded, 'edge')} with more than two faces"
        found.append(
            Finding("non-manifold", crowded, text, "harmless in a closed mesh" if closed else "", closed)
        )
    if not closed:
        rims = int(np.sum(edges.balance != 0))
        text = f"{plural(rims, 'open edge')} in {plural(boundaries(faces)[0], 'boundary')}"
        found.append(Finding("open", rims, text, solved=False))
    volume = signed_volume(vertices, faces) if closed else 0.0
    if volume < 0:
        found.append(Finding("inside-out", len(faces), "the faces point inwards", solved=False))
    return MeshReport(tuple(found), closed, components(faces)[0], volume)


def plural(count: int, noun: str) -> str:
    """Return `3 faces`, `1 boundary`, `2 boundaries`."""
    if count != 1:
        noun = noun[:-1] + "ies" if noun.endswith("y") else noun + "s"
    return f"{count} {noun}"


def flat_faces(vertices: Floats, faces: Ints) -> int:
    """How many faces have no area at all."""
    return int(np.sum(~face_crosses(vertices, faces).any(axis=1)))


def signed_volume(vertices: Floats, faces: Ints) -> float:
    """Volume enclosed by a closed mesh; negative if it is inside out."""
    return float(face_volumes(vertices, faces).sum())
