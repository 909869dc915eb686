"""Reads the parameters of the `translucent` BSDF, checks them, and turns them into textures.

The BSDF takes its medium from exactly one of three sources: a named `material`; the coefficients `sigma_a` and
`sigma_s`; or `albedo` and `radius`. Colours become Mitsuba textures at once, so that from here on a number, a
colour and a bitmap are the same thing in every variant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mitsuba as mi

from nephrite import materials
from nephrite.errors import ParameterError
from nephrite.physics.phase import check_g

SOURCES: tuple[tuple[str, ...], ...] = (("material",), ("sigma_a", "sigma_s"), ("albedo", "radius"))
NAMED_INDICES = {"vacuum": 1.0, "air": 1.000277, "water": 1.333, "bk7": 1.5046, "diamond": 2.419}


@dataclass
class Parameters:
    """What a `translucent` BSDF is made of; lengths in mm.

    `first`, `second`: textures of (sigma_a, sigma_s) or, if `by_color`, of (albedo, radius).
    """

    first: Scaled
    second: Scaled
    by_color: bool
    g: float
    eta: float
    alpha: float
    unit: float
    emission: Scaled | None
    name: str


def read(props: Any) -> Parameters:
    """Return the checked parameters; raises `ParameterError` for what can't be, naming it and the remedy."""
    where = f"translucent BSDF {props.id()!r}" if props.id() else "translucent BSDF"
    given = [source for source in SOURCES if any(key in props for key in source)]
    if len(given) != 1 or not all(key in props for key in given[0]):
        named = sorted({key for source in given for key in source if key in props})
        raise ParameterError(
            f"{where}: got {', '.join(named) or 'no medium'}; give either material, or sigma_a and sigma_s, or "
            "albedo and radius."
        )
    source = given[0]
    medium = materials.find(str(props["material"])) if source == SOURCES[0] else None
    default_eta = medium.medium.eta if medium else 1.3
    int_ior = _index(props, "int_ior", default_eta, where)
    ext_ior = _index(props, "ext_ior", 1.0, where)
    g = check_g(props.get("g", medium.medium.g if medium else 0.0))
    alpha = _number(props, "alpha", 0.0, where, "0 (smooth) to 1", lambda value: 0 <= value <= 1)
    unit = _number(props, "unit", 1.0, where, "the length of one scene unit in mm, above 0", lambda v: v > 0)
    emission = None
    if medium is not None:
        # a measured medium fixes the reduced scattering: a g of the user's keeps it
        sigma_s = [s * (1 - medium.medium.g) / (1 - g) for s in medium.medium.sigma_s]
        first, second = color_texture(medium.medium.sigma_a), color_texture(sigma_s)
        if any(medium.emission):
            emission = color_texture(medium.emission)
    else:
        first = _texture(props, source[0], where, largest=1.0 if source[0] == "albedo" else math.inf)
        second = _texture(props, source[1], where)
    if "emission" in props:
        emission = _texture(props, "emission", where)
    name = medium.name if medium else props.id() or "translucent"
    return Parameters(first, second, source == SOURCES[2], g, int_ior / ext_ior, alpha, unit, emission, name)


class Scaled:
    """A texture times a number: Mitsuba's spectra of colours, in the spectral variants, end at 1."""

    def __init__(self, texture: Any, scale: float = 1.0) -> None:
        """Hold both."""
        self.texture, self.scale = texture, scale

    @property
    def varies(self) -> bool:
        """Whether it differs from point to point."""
        return self.texture.is_spatially_varying()

    def eval(self, si: Any, active: Any) -> Any:
        """Evaluate at a surface interaction."""
        return self.texture.eval(si, active) * self.scale


def color_texture(color: Any) -> Scaled:
    """Return a constant, unbounded texture of three numbers."""
    channels = [float(channel) for channel in color]
    scale = max(*channels, 1.0) if mi.is_spectral else 1.0
    holder = mi.Properties()
    holder["value"] = mi.ScalarColor3d(*(channel / scale for channel in channels))
    return Scaled(holder.get_unbounded_texture("value"), scale)


def _texture(props: Any, key: str, where: str, largest: float = math.inf) -> Any:
    value = props[key]
    if isinstance(value, bool | str):
        raise ParameterError(f"{where}: {key} is {value!r}: give a number, an rgb colour or a texture.")
    if isinstance(value, mi.Object):
        return Scaled(props.get_unbounded_texture(key))
    channels = [float(value)] if isinstance(value, int | float) else [float(channel) for channel in value]
    for channel in channels:
        if not (math.isfinite(channel) and 0.0 <= channel <= largest):
            limit = f"in [0, {largest:g}]" if math.isfinite(largest) else "finite and not negative"
            raise ParameterError(f"{where}: {key} is {channels}: every channel must be {limit}.")
    return color_texture(channels * 3 if len(channels) == 1 else channels)


def _number(props: Any, key: str, default: float, where: str, allowed: str, check: Any) -> float:
    try:
        value = float(props.get(key, default))
    except (TypeError, ValueError, RuntimeError):
        value = math.nan
    if not (math.isfinite(value) and check(value)):
        raise ParameterError(f"{where}: {key} is {props.get(key, default)!r}; it must be {allowed}.")
    return value


def _index(props: Any, key: str, default: float, where: str) -> float:
    value = props.get(key, default)
    if isinstance(value, str):
        if value not in NAMED_INDICES:
            known = ", ".join(NAMED_INDICES)
            raise ParameterError(f"{where}: {key} is {value!r}; give a number above 0, or one of {known}.")
        return NAMED_INDICES[value]
    return _number(props, key, default, where, "an index of refraction above 0", lambda v: v > 0)
