"""Chooses what is computed under each object's surface: the paper's optimisation, made general.

The paper skips multiple scattering where a medium is nearly clear. In the same spirit `auto` looks at each material's
optical thickness: the mean chord of its shape, 4 V / S (Cauchy), times its coefficients.

- Nearly clear: fewer than one path in two thousand scatters twice. Walks end at their second event.
- Dense and thick: tens of reduced mean free paths across, where the accuracy atlas finds the tabulated profile within
  5 % of the truth and faster. The rule for this is read off its pictures (`nephrite.atlas.choice.rule`).
- Everything between: the walk.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np

from nephrite.plugins.layout import free_paths, spacing
from nephrite.plugins.media import JUMP, LOCAL, LOW, TRANSPORT, WALK
from nephrite.plugins.shapes import mean_chord

CLEAR = 0.03
"""Scattering optical thickness below which a medium counts as clear: its square bounds what is left out."""

DENSE = 91.0
"""Reduced optical thickness, in the clearest channel, above which a medium counts as dense: the atlas' rule for 5 %."""

LIGHT = 0.993
"""Reduced albedo, in the darkest channel, above which that rule holds."""

THIN = 4.0
"""Reduced optical thickness, in the clearest channel, below which transport is left to walks: they are short there."""

COARSE = 1.5
"""Spacing of transport's nodes, in the longest mean free path, above which light is too sharp for them."""

DIFFUSION = "tabulated"
"""The model that takes over there."""

_NAMES = {WALK: "walk", JUMP: DIFFUSION, LOCAL: "brdf", LOW: "walk, up to single scattering"}


@dataclass(frozen=True)
class Choice:
    """What was chosen for a material, and why."""

    name: str
    model: str
    reason: str


def choose(model: str, media: Any, scene: Any, **details: Any) -> list[Choice]:
    """Set the model of every material of `media`; return what was chosen for which.

    `details`: what else `Media.set_models` needs to know of a diffusion model.
    """
    if model == "transport":
        chosen = [_precomputable(entry) for entry in media.entries]
        media.set_models([WALK if reason else TRANSPORT for reason in chosen])
        return [
            Choice(entry.name, "walk" if reason else "transport", reason or "as asked for")
            for entry, reason in zip(media.entries, chosen, strict=True)
        ]
    if model != "auto":
        fixed = {"walk": WALK, "brdf": LOCAL}.get(model, JUMP)
        media.set_models([fixed] * len(media.entries), model, **details)
        return [Choice(entry.name, model, "as asked for") for entry in media.entries]
    chosen = [_choose(entry) for entry in media.entries]
    media.set_models([code for code, _ in chosen], DIFFUSION)
    choices = [
        Choice(entry.name, _NAMES[code], reason)
        for entry, (code, reason) in zip(media.entries, chosen, strict=True)
    ]
    log: Any = mi.Log
    for choice in choices:
        log(mi.LogLevel.Info, f"auto: {choice.name}: {choice.model}: {choice.reason}")
    return choices


def _precomputable(entry: Any) -> str:
    """Return why transport can't be precomputed for a material, or nothing."""
    if mi.is_spectral:
        return "wavelengths are no channels"
    if entry.least_reach > 0:
        return "an instance, which is one shape in many places"
    if entry.varies or entry.emits or entry.surface is not None:
        return "textures, emission or a rough surface"
    longest = float(free_paths(entry).max())
    if max(spacing(entry, shape) for shape in entry.shapes) > COARSE * longest:
        return f"a mean free path of {longest:.2g} is too short for its size"
    thickness = min(mean_chord(shape) for shape in entry.shapes) / longest
    if thickness < THIN:
        return f"{thickness:.2g} reduced mean free paths across"
    return ""


def _choose(entry: Any) -> tuple[int, str]:
    sigma_a, sigma_s = entry.mean_coefficients()
    chord = max(mean_chord(shape) for shape in entry.shapes)
    scattering = float(np.max(sigma_s)) * chord
    if scattering < CLEAR:
        return LOW, f"nearly clear: light scatters {scattering:.2g} times on its way across"
    reduced = sigma_s * (1.0 - entry.g)
    extinction = sigma_a + reduced
    thickness = float(np.min(extinction)) * chord
    albedo = float(np.min(reduced / np.maximum(extinction, 1e-30)))
    if thickness > DENSE and albedo > LIGHT:
        return JUMP, f"dense: {thickness:.3g} reduced mean free paths across, albedo at least {albedo:.3g}"
    return WALK, f"{thickness:.3g} reduced mean free paths across, albedo at least {albedo:.3g}"
