"""A carved jade pendant of our own, made in code: a lotus in a ring of rope, with a loop to hang it by.

It is thick where the rope is and thin where the petals are, pierced in many places, and closed. Everything
is a function in space, about a distance to the surface (negative inside), in units of a millimetre: the
pendant is 60 wide, 70 high and 14 deep, in the plane z = 0, facing +z.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nephrite.geometry.topology import components, pair_half_edges, weld
from nephrite.scene import cache
from nephrite.scene.isosurface import polygonise
from nephrite.scene.meshes import from_arrays
from nephrite.scene.triangles import TriangleMesh

Values = NDArray[np.floating[Any]]
SPACING = 0.41
_LAYOUT = 1  # raise it when the piece changes


def make() -> TriangleMesh:
    """Return the pendant; it takes some seconds the first time, and comes from the cache after that."""
    key = f"pendant-{_LAYOUT}"
    kept = cache.recall(key, "pendant")
    if kept is not None:
        return kept
    mesh = carve()
    cache.store(mesh, key)
    return mesh


def carve(spacing: float = SPACING) -> TriangleMesh:
    """Polygonise the pendant anew, in cells of `spacing` mm."""
    low, high = np.array([-31.5, -31.5, -6.0]), np.array([31.5, 42.0, 14.0])
    vertices, faces = polygonise(pendant, low, high, spacing)
    # Where petals cross, the grid may leave a bubble or a crumb: only the piece itself is kept.
    source, faces = weld(faces, pair_half_edges(vertices, faces))
    _, part = components(faces)
    mesh = from_arrays(vertices[source], faces[part == np.argmax(np.bincount(part))], "pendant")
    return replace(mesh, report=replace(mesh.report, findings=()))


@dataclass(frozen=True)
class Petals:
    """A whorl of petals around the z axis; lengths in mm, angles in turns of a petal."""

    number: int
    turn: float  # where the first one points, in petals
    inner: float  # radius where they begin
    outer: float  # radius of their tips
    width: float  # half the width at the widest
    foot: float  # z at the inner end
    rise: float  # how much higher the tips are
    cup: float  # how much higher the sides are than the middle
    thick: float  # half the thickness along the midrib


WHORLS = (
    Petals(8, 0.5, 4.0, 24.6, 3.0, -1.4, 0.4, 0.8, 0.85),
    Petals(8, 0.0, 3.0, 24.6, 7.0, -0.6, 3.0, 3.6, 0.65),
    Petals(8, 0.5, 2.0, 19.0, 5.8, 0.6, 6.8, 3.6, 0.62),
    Petals(8, 0.0, 1.5, 12.5, 3.7, 1.8, 8.4, 3.0, 0.58),
)


def pendant(x: Values, y: Values, z: Values) -> Values:
    """Signed field of the whole piece."""
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    solid = rope(radius, angle, z)
    solid = blend(solid, beads(radius, angle, z), 0.5)
    for whorl in WHORLS:
        solid = blend(solid, petals(whorl, radius, angle, z), 0.5)
    solid = blend(solid, pod(x, y, z, radius), 0.6)
    return blend(solid, loop(x, y, z), 1.2)


def rope(radius: Values, angle: Values, z: Values) -> Values:
    """The rim: three strands twisted around a circle."""
    across = radius - 27.0
    strand = np.arctan2(z, across)
    bulge = np.abs(np.cos(1.5 * strand + 15 * angle))
    return 0.85 * (np.hypot(across, z) - 2.2 - 0.75 * bulge)


def beads(radius: Values, angle: Values, z: Values) -> Values:
    """A thin ring inside the rim, set with 48 beads."""
    sector = 2 * np.pi / 48
    off = (angle + sector / 2) % sector - sector / 2
    along, across = radius * np.sin(off), radius * np.cos(off) - 23.4
    ring = np.hypot(radius - 23.4, z) - 0.7
    return blend(ring, np.sqrt(along**2 + across**2 + z**2) - 1.15, 0.3)


def petals(whorl: Petals, radius: Values, angle: Values, z: Values) -> Values:
    """One whorl: the two petals nearest in angle decide."""
    sector = 2 * np.pi / whorl.number
    turned = angle - whorl.turn * sector
    nearest = (turned + sector / 2) % sector - sector / 2
    beside = nearest - np.copysign(np.float32(sector), nearest)
    return blend(petal(whorl, radius, nearest, z), petal(whorl, radius, beside, z), 0.4)


def petal(whorl: Petals, radius: Values, angle: Values, z: Values) -> Values:
    """A leaf along angle 0: pointed, cupped, thin, with a midrib and veins."""
    along, across = radius * np.cos(angle), radius * np.sin(angle)
    t = np.clip((along - whorl.inner) / (whorl.outer - whorl.inner), 0.0, 1.0)
    half = whorl.width / 0.342 * t**0.8 * (1 - t) ** 0.75 + 0.05
    side = across / half
    bowl = np.minimum(side**2, 1.5) * np.sqrt(t * (1 - t) * 4)
    height = whorl.foot + whorl.rise * t**1.5 + whorl.cup * bowl * 0.6
    rib = 0.22 * np.exp(-((across / 0.45) ** 2)) * (1 - t)
    veins = 0.05 * np.cos(2 * np.pi * 5 * side / (1 + 0.5 * np.abs(side))) * np.sqrt(t)
    slope = np.sqrt(
        1
        + (1.5 * whorl.rise / (whorl.outer - whorl.inner)) ** 2 * t
        + (1.2 * whorl.cup / half * side) ** 2 * 0.3
    )
    sheet = np.abs(z - height) / slope - whorl.thick * (1 - 0.3 * np.minimum(side**2, 1)) - rib - veins
    outline = np.maximum((np.abs(across) - half) * 0.8, np.maximum(along - whorl.outer, whorl.inner - along))
    return cut(sheet, outline, 0.9)


def pod(x: Values, y: Values, z: Values, radius: Values) -> Values:
    """The seed pod in the middle: a dome with seven seeds in hollows."""
    dome = cut(np.hypot(radius, 0.9 * (z - 2.0)) - 4.6, z - 5.0, 0.8)
    for k in range(7):
        turn = np.pi / 3 * k
        cx, cy = (0.0, 0.0) if k == 6 else (2.75 * np.cos(turn), 2.75 * np.sin(turn))
        far = np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - 5.1) ** 2)
        dome = blend(cut(dome, 1.05 - far, 0.3), far + 0.25 - 0.95, 0.1)
    return dome


def loop(x: Values, y: Values, z: Values) -> Values:
    """The loop at the top, with a hole for the cord, between two leaves of cloud."""
    ring = np.hypot(np.hypot(x, (y - 34.2) * 0.9) - 3.6, z) - 1.7
    for side in (-1.0, 1.0):
        curl = np.hypot(np.hypot(x - side * 6.2, y - 31.2) - 2.1, z) - 1.25
        ring = blend(ring, curl, 0.8)
    return ring


def blend(a: Values, b: Values, width: float) -> Values:
    """Union with a fillet of some `width`."""
    h = np.maximum(width - np.abs(a - b), 0)
    return np.minimum(a, b) - h * h / (4 * width)


def cut(a: Values, b: Values, width: float) -> Values:
    """Intersection with an edge rounded over some `width`."""
    return -blend(-a, -b, width)
