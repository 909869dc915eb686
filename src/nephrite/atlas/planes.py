"""Half-spaces and slabs: what the models say of them beside the truth, cell by cell of a grid.

Totals of half-spaces are compared with the exact solution, rings of their profiles and slabs with simulated
searchlights. A model of multiple scattering is given the single scattering of the truth, for renders add that to it.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nephrite.atlas.plan import INCIDENCES, Plan
from nephrite.atlas.store import Cell, Store
from nephrite.physics import halfspace, searchlight
from nephrite.profiles import accuracy, multipole
from nephrite.profiles.base import Model, RadialProfile
from nephrite.profiles.models import MODELS

__all__ = ["HalfSpace", "Slab", "half_spaces", "slabs"]

_RADII = (1e-3, 1e5, 80)  # mean free paths: first and last edge of the rings, ten a decade
_SEED = 20


@dataclass(frozen=True)
class HalfSpace:
    """A model in one cell; errors are relative to all the scattered light that leaves.

    `total` is exact; `profile` is the L1 distance of 2 pi r R(r), and `noise` what that would be of a perfect model.
    """

    model: str
    incidence: str
    albedo: float
    eta: float
    g: float
    total: float
    profile: float
    noise: float


@dataclass(frozen=True)
class Slab:
    """A model of an isotropic slab: shares of the light that has entered which scatter and leave.

    `reflected`, `transmitted`: the model's (NaN where a model knows no far side); `true_...` the truth with its
    standard error `..._error`. `thickness` in mean free paths.
    """

    model: str
    incidence: str
    albedo: float
    eta: float
    thickness: float
    reflected: float
    true_reflected: float
    reflected_error: float
    transmitted: float
    true_transmitted: float
    transmitted_error: float


def half_spaces(plan: Plan, store: Store, models: tuple[str, ...]) -> list[dict[str, Any]]:
    """Return the `HalfSpace` of every model and cell, as dictionaries."""
    rows = []
    for eta, g, incidence in product(plan.etas, plan.gs, INCIDENCES):
        truth = _simulated(plan, store, eta, g, incidence)
        rows += [
            _compared(MODELS[name], incidence, albedo, eta, g, truth, i)
            for (i, albedo), name in product(enumerate(plan.albedos), models)
        ]
    return [asdict(row) for row in rows]


def _single_albedo(albedo_prime: Any, g: float) -> Any:
    return albedo_prime / (albedo_prime + (1.0 - albedo_prime) * (1.0 - g))


def _profile(model: Model, albedo_prime: float, eta: float, g: float) -> RadialProfile:
    """Build the profile in mean free paths 1/sigma_t, the unit of the simulations."""
    albedo = _single_albedo(albedo_prime, g)
    return model.make(1.0 - albedo, albedo * (1.0 - g), eta, g)


def _simulated(plan: Plan, store: Store, eta: float, g: float, incidence: str) -> Cell:
    photons = max(1 << 12, int(plan.photons * (1.0 - g) ** 0.6))  # walks grow with 1 / (1 - g)
    asked = {
        "eta": eta, "g": g, "incidence": incidence, "photons": photons, "albedos": plan.albedos,
        "radii": _RADII, "seed": _SEED,
    }  # fmt: skip

    def compute() -> Cell:
        light = searchlight.simulate(
            eta, g, incidence=incidence, paths=photons, seed=_SEED, radii=_RADII, directions=1
        )
        albedo = _single_albedo(np.array(plan.albedos), g)
        every, once = light.profile(albedo, first=1), light.profile(albedo, first=1, last=1)
        return {"edges": every.edges, "light": every.value, "error": every.error, "single": once.value}

    return store.cell(f"half-space η {eta:g}, g {g:g}, {incidence}", asked, compute)


def _compared(
    model: Model, incidence: str, albedo_prime: float, eta: float, g: float, truth: Cell, i: int
) -> HalfSpace:
    profile = _profile(model, albedo_prime, eta, g)
    albedo = _single_albedo(albedo_prime, g)
    light = accuracy.rings(profile, truth["edges"])
    leaves = halfspace.total_reflectance(albedo, eta, g, incidence)
    total = float(profile.albedo())
    if model.terms == "multiple":
        total += leaves - halfspace.total_reflectance(albedo, eta, g, incidence, multiple=True)
        light = light + truth["single"][i]
    simulated = truth["light"][i]
    return HalfSpace(
        model.name, incidence, albedo_prime, eta, g,
        total=total / leaves - 1.0,
        profile=float(np.abs(light - simulated).sum() / simulated.sum()),
        noise=float(truth["error"][i].sum() * math.sqrt(2.0 / math.pi) / simulated.sum()),
    )  # fmt: skip


def slabs(plan: Plan, store: Store, models: tuple[str, ...]) -> list[dict[str, Any]]:
    """Return the `Slab` of every model and cell, as dictionaries."""
    rows = []
    for eta, incidence, thickness in product(plan.slab_etas, INCIDENCES, plan.thicknesses):
        truth = _simulated_slab(plan, store, eta, thickness, incidence)
        rows += [
            _compared_slab(MODELS[name], incidence, albedo, eta, thickness, truth, i)
            for (i, albedo), name in product(enumerate(plan.slab_albedos), models)
        ]
    return [asdict(row) for row in rows]


def _simulated_slab(plan: Plan, store: Store, eta: float, thickness: float, incidence: str) -> Cell:
    asked = {
        "eta": eta, "thickness": thickness, "incidence": incidence, "photons": plan.slab_photons,
        "albedos": plan.slab_albedos, "seed": _SEED,
    }  # fmt: skip

    def compute() -> Cell:
        light = searchlight.simulate(
            eta, thickness=thickness, incidence=incidence, paths=plan.slab_photons, seed=_SEED,
            radii=(1.0, 2.0, 1), directions=1,
        )  # fmt: skip
        albedo = np.array(plan.slab_albedos)
        sides: list[NDArray[np.float64]] = []
        for transmitted in (False, True):
            every = light.total(albedo, transmitted, first=1)
            sides += [every.value, every.error]
        single = light.total(albedo, first=1, last=1).value
        names = ("reflected", "reflected_error", "transmitted", "transmitted_error", "single")
        return dict(zip(names, (*sides, single), strict=True))

    return store.cell(f"slab η {eta:g}, {thickness:g} mean free paths, {incidence}", asked, compute)


def _compared_slab(
    model: Model, incidence: str, albedo: float, eta: float, thickness: float, truth: Cell, i: int
) -> Slab:
    transmitted = math.nan
    if model.name == "multipole":
        profile = multipole.make(1.0 - albedo, albedo, eta, thickness=thickness)
        transmitted = float(profile.transmitted().albedo())
    else:
        profile = model.make(1.0 - albedo, albedo, eta)
    reflected = float(profile.albedo())
    if model.terms == "multiple":
        reflected += float(truth["single"][i])
    return Slab(
        model.name, incidence, albedo, eta, thickness,
        reflected, float(truth["reflected"][i]), float(truth["reflected_error"][i]),
        transmitted, float(truth["transmitted"][i]), float(truth["transmitted_error"][i]),
    )  # fmt: skip
