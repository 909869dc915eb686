"""One translucent material of a scene: its surface, and what is inside."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.physics import fresnel
from nephrite.physics.color import ColorMap, color_map
from nephrite.physics.single import single_scattering_share
from nephrite.plugins.shapes import surface_points

_POINTS = 256


@dataclass
class Entry:
    """One translucent material: its surface, constants, and where its coefficients come from.

    `surface`: the Mitsuba BSDF of a rough (or tinted) interface, None for a smooth clear one.
    """

    name: str
    g: float
    eta: float
    surface: Any | None
    bsdf: Any | None = None
    medium: Any | None = None
    owner: Any | None = None  # keeps a smooth dielectric alive, by whose identity the entry is found again
    shapes: list[Any] = field(default_factory=list)
    least_reach: float = 0.0

    def coefficients(self, si: Any, active: Any) -> tuple[Any, Any]:
        """Return sigma_a and sigma_s per scene unit."""
        if self.bsdf is not None:
            return self.bsdf.coefficients(si, active)
        mei = dr.zeros(mi.MediumInteraction3f, dr.width(si.p))
        mei.p, mei.wavelengths = si.p, si.wavelengths
        medium: Any = self.medium
        sigma_s, _, sigma_t = medium.get_scattering_coefficients(mei, active)
        return dr.maximum(sigma_t - sigma_s, 0.0), sigma_s

    def sampled_coefficients(self) -> tuple[np.ndarray, np.ndarray]:
        """Return sigma_a and sigma_s, per scene unit, at random points of the first shape: (points or 1, channels)."""
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(0, _POINTS)
        si = surface_points(self.shapes[0], sampler.next_2d(), sampler.next_1d())
        absorbed, scattered = self.coefficients(si, mi.Bool(True))
        return np.array(absorbed).T, np.array(scattered).T

    def mean_coefficients(self) -> tuple[np.ndarray, np.ndarray]:
        """Return sigma_a and sigma_s, per scene unit, per channel, averaged over the first shape."""
        absorbed, scattered = self.sampled_coefficients()
        return absorbed.mean(axis=0, dtype=np.float64), scattered.mean(axis=0, dtype=np.float64)

    def emitted(self, si: Any, active: Any) -> Any:
        """Return the volumetric emission per scene unit."""
        return self.bsdf.emitted(si, active) if self.bsdf is not None else mi.Spectrum(0.0)

    @property
    def unit(self) -> float:
        """Length of a scene unit in millimetres; 1 for Mitsuba's own media, which know of none."""
        return self.bsdf.unit if self.bsdf is not None else 1.0

    @property
    def boundary(self) -> float:
        """The dipole's A."""
        return fresnel.boundary_factor(self.eta)

    @property
    def colors(self) -> ColorMap:
        """What a thick flat piece sends out."""
        return self.bsdf.colors if self.bsdf is not None else color_map(self.eta, self.g)

    @property
    def single_share(self) -> float:
        """Share of light that leaves after one event, per albedo."""
        return single_scattering_share(self.g, self.eta)

    def reach(self) -> float:
        """Longest diagonal of the bounding boxes of its shapes."""
        return max(self.least_reach, *(float(dr.norm(shape.bbox().extents())) for shape in self.shapes))

    @property
    def varies(self) -> bool:
        """Whether the coefficients differ from point to point."""
        return self.bsdf is not None and self.bsdf.varies

    @property
    def emits(self) -> bool:
        """Whether the medium emits light."""
        return self.bsdf is not None and self.bsdf.emission is not None
