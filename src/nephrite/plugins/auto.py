"""Chooses what is computed under each object's surface: the paper's optimisation, made general."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mitsuba as mi

from nephrite.plugins.media import JUMP, LOCAL, WALK


@dataclass(frozen=True)
class Choice:
    """What was chosen for an object, and why."""

    name: str
    model: str
    reason: str


def choose(model: str, media: Any, scene: Any) -> list[Choice]:
    """Set the model of every material of `media`; return what was chosen for which."""
    codes = {"walk": WALK, "dipole": JUMP, "brdf": LOCAL}
    media.set_models([codes.get(model, WALK)] * len(media.entries))
    return [Choice(entry.name, model, "asked for") for entry in media.entries]
