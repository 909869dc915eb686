"""Which shapes of a scene light can enter, and what is inside.

`Media.of(scene)` numbers the translucent materials 1, 2, ... (0: none): the `translucent` BSDFs, and Mitsuba's own
`dielectric` or `roughdielectric` in front of a `homogeneous` interior medium. In the integrator's loop a lane
knows its material by that number, and looks up here what it needs of it.
"""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.bssrdf import lobe
from nephrite.plugins import directional, survey
from nephrite.plugins.directional import Directional
from nephrite.plugins.entry import Entry
from nephrite.plugins.field import Field
from nephrite.plugins.fixed import Measured, Slabs
from nephrite.plugins.kernels import HalfSpaces
from nephrite.plugins.winding import Winding
from nephrite.profiles.measured import MeasuredProfile

WALK, JUMP, LOCAL, LOW, TRANSPORT = range(5)
"""What is computed under a surface."""


class Media:
    """The translucent materials of a scene, with lookups for whole wavefronts."""

    def __init__(self, entries: list[Entry]) -> None:
        """Build the tables that the lookups gather from; `entries` are numbered from 1."""
        self.entries = entries
        ids = [[identity(shape) for shape in entry.shapes] for entry in entries]
        size = 1 + max((i for row in ids for i in row), default=0)
        table = np.zeros(size, dtype=np.uint32)
        for number, row in enumerate(ids, start=1):
            table[row] = number
        self._size = size
        self._of_shape = mi.UInt32(table)
        lobes = [lobe.exit_lobe(entry.eta) for entry in entries]
        self.g = _column([entry.g for entry in entries], 0.0)
        self.eta = _column([entry.eta for entry in entries], 1.0)
        self.normalization = _column([one.normalization for one in lobes], 1.0)
        self.m2 = _column([one.m2 for one in lobes], 1.0)
        self.m4 = _column([one.m4 for one in lobes], 2.0)
        self.reach = _column([entry.reach() for entry in entries], 0.0)
        self.single_share = _column([e.single_share for e in entries], 0.0)
        self.rough = _column([float(entry.surface is not None) for entry in entries], 0.0)
        self.any_rough = any(entry.surface is not None for entry in entries)
        self.any_varying = any(entry.varies for entry in entries)
        self.any_emission = any(entry.emits for entry in entries)
        dr.eval(self._of_shape)
        self.set_models([WALK] * len(entries))

    def set_models(
        self,
        models: list[int],
        diffusion: str = "dipole",
        profiles: tuple[MeasuredProfile, ...] = (),
        thickness: float = math.inf,
    ) -> None:
        """Set what is computed under each material's surface: `WALK`, `JUMP`, `LOCAL`, `LOW` or `TRANSPORT`.

        `diffusion`: the model whose kernel jumps follow: of `nephrite.profiles.models`, a directional one, or measured.
        `profiles`: of `measured`; `thickness`: of `multipole`, in mm.
        """
        self.models = models
        self._model = mi.UInt32([WALK, *models])
        dr.eval(self._model)
        self.any_jump, self.any_local = JUMP in models, LOCAL in models
        self.any_low = LOW in models or TRANSPORT in models
        self.transport: Any = None
        self.diffusion = diffusion
        by_direction = diffusion in directional.MODELS
        self.directional: Any = Directional(self.entries, diffusion) if by_direction else None
        self.kernels: Any = None
        if self.any_jump and profiles:
            self.kernels = Measured(self.entries, profiles)
        elif self.any_jump and thickness < math.inf:
            self.kernels = Slabs(self.entries, thickness)
        elif self.any_jump:
            self.kernels = HalfSpaces(self.entries, "dipole" if by_direction else diffusion)
        self.balance = Field(len(self.entries))
        jumping = [e for e, model in zip(self.entries, models, strict=True) if model == JUMP]
        self.winding = Winding({identity(shape): shape for entry in jumping for shape in entry.shapes})

    def jumps(self, number: Any) -> Any:
        """Whether a diffusion model takes over from the walk at its second event."""
        return dr.gather(mi.UInt32, self._model, number) == JUMP

    def local(self, number: Any) -> Any:
        """Whether light leaves where it entered."""
        return dr.gather(mi.UInt32, self._model, number) == LOCAL

    def low(self, number: Any) -> Any:
        """Whether walks end at their second event."""
        model = dr.gather(mi.UInt32, self._model, number)
        return (model == LOW) | (model == TRANSPORT)

    def transported(
        self, number: Any, si: Any, normal: Any, direction: Any, u: Any, active: Any
    ) -> tuple[Any, Any]:
        """Return what light brings that enters at `si` and scatters twice, where it is precomputed; 0 elsewhere.

        In the mean over two uniform numbers `u`. And the share that a half-space would keep after one event.
        `normal`: outward; `direction`: where the path came from.
        """
        active = active & (dr.gather(mi.UInt32, self._model, number) == TRANSPORT)
        brought, kept = self.transport.radiance(si, normal, direction, u, active)
        return dr.select(active, brought, 0), kept

    @staticmethod
    def of(scene: Any) -> Media:
        """Survey a scene; raises `ParameterError` for a medium that this integrator does not render."""
        return Media(survey.entries(scene))

    def number(self, shape: Any) -> Any:
        """Number of the material of a `ShapePtr` array, 0 where light can't enter."""
        index: Any = dr.reinterpret_array(mi.UInt32, shape)
        known = index < self._size
        return dr.gather(mi.UInt32, self._of_shape, dr.select(known, index, 0), known)

    def lookup(self, column: Any, number: Any) -> Any:
        """Value of a column, such as `media.eta`, for each lane's material."""
        return dr.gather(mi.Float, column, number)

    def coefficients(self, number: Any, si: Any, active: Any) -> tuple[Any, Any]:
        """Return sigma_a, sigma_s per scene unit of each lane's material, read at `si`."""
        sigma_a, sigma_s = mi.Spectrum(0.0), mi.Spectrum(0.0)
        for i, entry in enumerate(self.entries, start=1):
            mine = active & (number == i)
            a, s = entry.coefficients(si, mine)
            sigma_a, sigma_s = dr.select(mine, a, sigma_a), dr.select(mine, s, sigma_s)
        return sigma_a, sigma_s

    def shown(self, number: Any, sigma_a: Any, sigma_s: Any) -> Any:
        """Return the share of the light that has entered which a thick flat piece sends out, per channel."""
        result = mi.Spectrum(0.0)
        for i, entry in enumerate(self.entries, start=1):
            result = dr.select(number == i, entry.colors.of_coefficients(sigma_a, sigma_s), result)
        return result

    def balanced(self, number: Any, a: Any, b: Any, u: Any) -> Any:
        """Return the logarithm to base 2 of what a jump's kernel is divided by, per channel; see `balance`.

        `u`: a uniform number, whose leading, middle and last digits jitter the lookups.
        """
        digits = mi.Vector3f(u, 256.0 * u, 65536.0 * u)
        jitter = digits - dr.floor(digits) - 0.5
        at_a, at_b = self.balance.logarithm(number, a, jitter), self.balance.logarithm(number, b, jitter)
        return 0.5 * (at_a + at_b) if self.kernels.finite else dr.maximum(at_a, at_b)

    def other_end(self, number: Any, si: Any, active: Any) -> Any:
        """Return where to look for the kernel at `si`, None if no material's coefficients vary."""
        if not self.any_varying:
            return None
        sigma_a, sigma_s = self.coefficients(number, si, active)
        return self.kernels.place(number, sigma_a, sigma_s, self.lookup(self.g, number))

    def emitted(self, number: Any, si: Any, active: Any) -> Any:
        """Return the volumetric emission per scene unit of each lane's material, read at `si`."""
        total = mi.Spectrum(0.0)
        for i, entry in enumerate(self.entries, start=1):
            if entry.emits:
                mine = active & (number == i)
                total = dr.select(mine, entry.emitted(si, mine), total)
        return total

    def sample_surface(self, number: Any, si: Any, u1: Any, u2: Any, active: Any) -> tuple[Any, Any]:
        """Sample the BSDF of each lane's rough interface, without the scaling of radiance by eta^2."""
        context = mi.BSDFContext(mi.TransportMode.Importance, 0xFFFFFFFF, 0xFFFFFFFF)
        result, weight = dr.zeros(mi.BSDFSample3f), mi.Spectrum(0.0)
        for i, entry in enumerate(self.entries, start=1):
            if entry.surface is not None:
                mine = active & (number == i)
                bs, w = entry.surface.sample(context, si, u1, u2, mine)
                result, weight = dr.select(mine, bs, result), dr.select(mine, w, weight)
        return result, weight

    def eval_surface(self, number: Any, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        """Value times cosine, and density, of each lane's rough interface; no scaling by eta^2."""
        context = mi.BSDFContext(mi.TransportMode.Importance, 0xFFFFFFFF, 0xFFFFFFFF)
        value, pdf = mi.Spectrum(0.0), mi.Float(0.0)
        for i, entry in enumerate(self.entries, start=1):
            if entry.surface is not None:
                mine = active & (number == i)
                v, p = entry.surface.eval_pdf(context, si, wo, mine)
                value, pdf = dr.select(mine, v, value), dr.select(mine, p, pdf)
        return value, pdf


def _column(values: list[float], first: float) -> Any:
    column = mi.Float([first, *values])
    dr.eval(column)
    return column


def identity(shape: Any) -> int:
    """Return the number by which Mitsuba knows a shape."""
    index: Any = dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))
    return int(index[0])
