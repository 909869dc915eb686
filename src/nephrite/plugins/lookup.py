"""What is asked of the nodes of a scene's surfaces: which are near a point, and how much light counts at an angle."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from nephrite.bssrdf import lobe
from nephrite.physics.single import deep_share, single_scattering_share
from nephrite.plugins.layout import at_nodes
from nephrite.plugins.media import identity
from nephrite.transport.nearby import Nearby
from nephrite.transport.nodes import REACH

_COSINES = (np.arange(64) + 0.5) / 64

Layout = tuple[NDArray, NDArray, float]
"""Nodes of a surface, their outward normals, and their spacing: see `layout.lay`."""


class Lookup:
    """The nodes of all surfaces, one after the other, and the tables of their materials."""

    def __init__(self, members: list[tuple[Any, Any]], layouts: list[Layout]) -> None:
        """Hold the nodes of `members`, pairs of `entry.Entry` and shape; the nodes' order is that of `points`."""
        self.nearby = Nearby([(points, normals, REACH * spacing) for points, normals, spacing in layouts])
        self.points, self.normals = self.nearby.points, self.nearby.normals
        self.at = at_nodes(self.points, self.normals)
        counts = [len(points) for points, _, _ in layouts]
        self.firsts = np.cumsum([0, *counts])
        self.which = mi.UInt32(np.repeat(np.arange(len(counts)), counts))
        self.eta = mi.Float([entry.eta for entry, _ in members])
        self.normalization = mi.Float([lobe.exit_lobe(entry.eta).normalization for entry, _ in members])
        self._deep = mi.Float(
            np.concatenate([deep_share(_COSINES, entry.g, entry.eta) for entry, _ in members])
        )
        self._kept = mi.Float([1.0 - single_scattering_share(entry.g, entry.eta) for entry, _ in members])
        self.attach([shape for _, shape in members])

    def own(self, number: int) -> slice:
        """Return where the nodes of one surface are."""
        return slice(int(self.firsts[number]), int(self.firsts[number + 1]))

    def attach(self, shapes: list[Any]) -> None:
        """Say which shapes the surfaces are: the same ones have other identities in a scene that is loaded again."""
        ids = [identity(shape) for shape in shapes]
        numbers = np.zeros(max(ids) + 1, np.uint32)
        numbers[ids] = np.arange(len(ids)) + 1
        self._number = mi.UInt32(numbers)

    def number(self, shape: Any, active: Any) -> Any:
        """Return which surfaces the shapes of a `ShapePtr` array are."""
        index: Any = dr.reinterpret_array(mi.UInt32, shape)
        return dr.gather(mi.UInt32, self._number, index, active) - 1

    def known(self, shape: Any) -> Any:
        """Return whether the shapes of a `ShapePtr` array are surfaces with nodes."""
        index: Any = dr.reinterpret_array(mi.UInt32, shape)
        return dr.gather(mi.UInt32, self._number, index, index < dr.width(self._number)) > 0

    def sensitivity(self, node: Any, cosine: Any) -> Any:
        """How much light at an angle counts for multiple scattering, as a density over the projected solid angle."""
        which = dr.gather(mi.UInt32, self.which, node)
        fresnel: Any = mi.fresnel
        through = 1.0 - fresnel(cosine, dr.gather(mi.Float, self.eta, which))[0]
        return (
            dr.inv_pi * through / dr.gather(mi.Float, self.normalization, which) * self.depth(which, cosine)
        )

    def depth(self, which: Any, cosine: Any) -> Any:
        """Light at this angle that scatters twice, over its mean: `deep_share`, by its table."""
        spot = dr.clip(cosine * len(_COSINES) - 0.5, 0.0, len(_COSINES) - 1.001)
        first = mi.UInt32(spot)
        a, b = (dr.gather(mi.Float, self._deep, which * len(_COSINES) + first + i) for i in range(2))
        return dr.lerp(a, b, spot - first)

    def kept(self, which: Any, cosine: Any) -> Any:
        """Light at this angle, once it has entered, that a half-space keeps after one event, per albedo."""
        return dr.gather(mi.Float, self._kept, which) * self.depth(which, cosine)
