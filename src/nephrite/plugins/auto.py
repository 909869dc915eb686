"""Chooses what is computed under each object's surface: the paper's optimisation, made general.

The paper skips multiple scattering where a medium is nearly clear. In the same spirit `auto` looks at each material's
optical thickness: the mean chord of its shape, 4 V / S (Cauchy), times its coefficients.

- Nearly clear: fewer than one path in two thousand scatters twice. Walks end at their second event.
- Dense and thick, of high albedo: hundreds of reduced mean free paths across, where diffusion holds to a few per cent
  and each walk is long. The tabulated profile takes over.
- Everything between: the walk.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.plugins.media import JUMP, LOCAL, LOW, WALK, surface_points

CLEAR = 0.03
"""Scattering optical thickness below which a medium counts as clear: its square bounds what is left out."""

DENSE = 400.0
"""Reduced optical thickness above which a medium counts as dense."""

LIGHT = 0.95
"""Reduced albedo, in the darkest channel, from which walks are long enough to be worth replacing."""

DIFFUSION = "tabulated"
"""The model that takes over there."""

_NAMES = {WALK: "walk", JUMP: DIFFUSION, LOCAL: "brdf", LOW: "walk, up to single scattering"}
_POINTS = 256


@dataclass(frozen=True)
class Choice:
    """What was chosen for a material, and why."""

    name: str
    model: str
    reason: str


def choose(model: str, media: Any, scene: Any) -> list[Choice]:
    """Set the model of every material of `media`; return what was chosen for which."""
    if model != "auto":
        fixed = {"walk": WALK, "brdf": LOCAL}.get(model, JUMP)
        media.set_models([fixed] * len(media.entries), model)
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


def _choose(entry: Any) -> tuple[int, str]:
    sigma_a, sigma_s = _mean_coefficients(entry)
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


def _mean_coefficients(entry: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return sigma_a and sigma_s, per scene unit, per channel, averaged over the first shape."""
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, _POINTS)
    si = surface_points(entry.shapes[0], sampler.next_2d(), sampler.next_1d())
    absorbed, scattered = entry.coefficients(si, mi.Bool(True))
    return _channel_means(absorbed), _channel_means(scattered)


def _channel_means(values: Any) -> np.ndarray:
    return np.array([float(dr.mean(channel)[0]) for channel in values])


def mean_chord(shape: Any) -> float:
    """Mean length of the straight lines through a shape: 4 V / S (Cauchy); scene units.

    A mesh's volume is the sum of its signed tetrahedra; for other shapes that of the ellipsoid in the bounding box.
    """
    area = max(float(dr.max(shape.surface_area())[0]), 1e-30)
    extents = np.array(shape.bbox().extents(), dtype=np.float64).ravel()
    volume = float(np.prod(extents)) * np.pi / 6.0
    if shape.is_mesh():
        values = mi.traverse(shape)
        name = "vertex_positions" if "vertex_positions" in values else "positions"
        vertices = np.array(values[name], dtype=np.float64).reshape(-1, 3)
        corners = vertices[np.array(values["faces"]).reshape(-1, 3)] - vertices.mean(axis=0)
        volume = (
            abs(float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()))
            / 6.0
        )
    return 4.0 * volume / area
