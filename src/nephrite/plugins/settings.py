"""The parameters of the integrator `translucent_path`, read and checked."""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi

from nephrite.errors import ParameterError, unknown_name
from nephrite.plugins import directional
from nephrite.profiles import measured, models

MODELS = ("walk", "transport", "brdf", "auto", *models.MODELS, *directional.MODELS, "measured")
DETAILS = {"profile": "measured", "thickness": "multipole"}
"""Parameters that belong to one model alone."""
EXITS = ("lobe", "exact")
TERMS = ("reduced", "single", "multiple")
NO_LIMIT = 0xFFFFFFFF


class Settings:
    """What the integrator has been asked for; see its class for the meanings.

    A plain class: Dr.Jit would take a dataclass for a part of the loop's state.
    """

    def __init__(
        self, model: str, exit: str, terms: tuple[str, ...], max_depth: int, rr_depth: int, max_steps: int,
        hide_emitters: bool, profiles: tuple[measured.MeasuredProfile, ...], thickness: float, walks: int | None,
    ) -> None:  # fmt: skip
        """Hold checked values."""
        self.model, self.exit = model, exit
        self.reduced, self.single, self.multiple = (term in terms for term in TERMS)
        self.max_depth, self.rr_depth, self.max_steps = max_depth, rr_depth, max_steps
        self.hide_emitters = hide_emitters
        self.profiles, self.thickness = profiles, thickness
        self.walks = walks

    @property
    def terms(self) -> str:
        """The terms as their parameter would be written."""
        chosen = [term for term in TERMS if getattr(self, term)]
        return "all" if len(chosen) == len(TERMS) else "+".join(chosen)

    def wants(self, order: Any) -> Any:
        """Whether a path with so many events belongs to the terms asked for."""
        return (
            (mi.Bool(self.reduced) & (order == 0))
            | (mi.Bool(self.single) & (order == 1))
            | (mi.Bool(self.multiple) & (order > 1))
        )

    def may_go_on(self, order: Any) -> Any:
        """Whether a path with so many events can still become one of the terms asked for."""
        return mi.Bool(True) if self.multiple else order <= (1 if self.single else 0)


def read(props: Any) -> Settings:
    """Read the plugin's properties; raises `ParameterError` that names what can't be."""
    model, exit_ = str(props.get("model", "walk")), str(props.get("exit", "lobe"))
    if model not in MODELS:
        raise unknown_name("model", model, MODELS)
    if exit_ not in EXITS:
        raise unknown_name("exit", exit_, EXITS)
    terms = _terms(str(props.get("terms", "all")))
    profile, thickness = props.get("profile"), props.get("thickness")
    check_details(model, profile, thickness)
    return Settings(
        model,
        exit_,
        terms,
        max_depth=_count(props, "max_depth", -1, -1, "-1 (no limit), or the longest path's number of edges"),
        rr_depth=_count(props, "rr_depth", 5, 1, "the depth, from 1, at which Russian roulette begins"),
        max_steps=_count(props, "max_steps", 1_000_000, 1, "the longest walk's number of events, from 1"),
        hide_emitters=bool(props.get("hide_emitters", False)),
        profiles=() if profile is None else _profiles(str(profile)),
        thickness=math.inf if thickness is None else float(thickness),
        walks=_count(props, "walks", 1, 1, "the number of walks per object that transport is made of")
        if "walks" in props
        else None,
    )


def check_details(model: str, profile: Any, thickness: Any) -> None:
    """Raise `ParameterError` if a model lacks what it needs, or is given what belongs to another one."""
    for name, value in (("profile", profile), ("thickness", thickness)):
        if value is not None and model != DETAILS[name]:
            raise ParameterError(
                f"{name} is {value!r}, but the model is {model}: {name} belongs to the model {DETAILS[name]}; "
                "leave out one, or change the other."
            )
    if model == "measured" and profile is None:
        raise ParameterError(
            "the model measured needs a profile: name a CSV file of r (mm) and R (1/mm^2) as profile."
        )
    if thickness is not None:
        number = isinstance(thickness, int | float) and not isinstance(thickness, bool)
        if not (number and 0.0 < thickness < math.inf):
            raise ParameterError(
                f"thickness is {thickness!r}; it must be a length in mm, above 0. Without it a slab has no end."
            )


def _profiles(path: str) -> tuple[measured.MeasuredProfile, ...]:
    """Read a CSV file, which Mitsuba looks for beside the scene file too."""
    resolver: Any = mi.file_resolver
    profiles = measured.read(str(resolver().resolve(path)))
    if len(profiles) > 1 and not mi.is_rgb:
        raise ParameterError(
            f"profile is {path!r}, with columns for red, green and blue, but {mi.variant()} has no such channels: "
            "give one column of R, or use an rgb variant."
        )
    return profiles


def _terms(text: str) -> tuple[str, ...]:
    parts = tuple(text.replace(" ", "").split("+"))
    if parts == ("all",):
        return TERMS
    for part in parts:
        if part not in TERMS:
            raise unknown_name("term", part, ("all", *TERMS))
    if len(set(parts)) < len(parts):
        raise ParameterError(f"terms is {text!r}: write each term once, like reduced+single.")
    return parts


def _count(props: Any, key: str, default: int, least: int, meaning: str) -> int:
    value = props.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise ParameterError(f"{key} is {value!r}; it must be {meaning}.")
    return NO_LIMIT if value == -1 else value
