"""Small scenes for comparisons: shapes of some 10 mm, measured media, one big light and a grey environment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np

SKIM_MILK = ((0.0014, 0.0025, 0.0142), (0.70, 1.22, 1.90), 1.3)
MEDIA = {
    "skim milk": SKIM_MILK,
    "marble": ((0.0021, 0.0041, 0.0071), (2.19, 2.62, 3.00), 1.5),
    "ketchup": ((0.061, 0.97, 1.45), (0.18, 0.07, 0.03), 1.3),
    "skin": ((0.032, 0.17, 0.48), (0.74, 0.88, 1.01), 1.3),
}
"""sigma_a, sigma_s' in 1/mm (Jensen et al. 2001, table 1; written again here on purpose) and eta."""


@dataclass(frozen=True)
class Trial:
    """A shape of a medium; `name` says which."""

    shape: str
    medium: str
    g: float = 0.0
    alpha: float = 0.0

    @property
    def name(self) -> str:
        rough = f" rough {self.alpha:g}" if self.alpha else ""
        return f"{self.medium} {self.shape}{rough} g={self.g:g}".replace(" ", "-")

    def coefficients(self) -> tuple[list[float], list[float], float]:
        sigma_a, reduced, eta = MEDIA[self.medium]
        return list(sigma_a), [s / (1.0 - self.g) for s in reduced], eta


TRIALS = (
    Trial("sphere", "skim milk"),
    Trial("cube", "marble"),
    Trial("slab", "skim milk"),
    Trial("sphere", "ketchup"),
    Trial("sphere", "skin", g=0.8),
    Trial("cube", "skim milk", alpha=0.3),
    Trial("cube", "ketchup", g=0.8, alpha=0.1),
    Trial("slab", "skin", alpha=0.5),
)
"""Sphere, cube and a thin slab lit from behind; smooth and rough; g of 0 and .8."""


def rgb(value: Any) -> dict[str, Any]:
    numbers = [float(v) for v in np.broadcast_to(value, 3)]
    return {"type": "rgb", "value": numbers}


def standard(
    sigma_a: Any, sigma_s: Any, g: float = 0.0, eta: float = 1.3, alpha: float = 0.0
) -> dict[str, Any]:
    """Return BSDF and interior medium of Mitsuba's own plugins, as entries of a shape's dictionary."""
    sigma_t = np.broadcast_to(np.add(sigma_a, sigma_s), 3)
    albedo = np.divide(sigma_s, sigma_t, out=np.zeros(3), where=sigma_t > 0)
    surface: dict[str, Any] = {"type": "dielectric", "int_ior": eta, "ext_ior": 1.0}
    if alpha:
        surface |= {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha}
    scale = max(float(sigma_t.max()), 1e-30)  # colours above 1 are refused
    medium = {"type": "homogeneous", "sigma_t": rgb(sigma_t / scale), "albedo": rgb(albedo), "scale": scale}
    medium["phase"] = {"type": "hg", "g": g} if g else {"type": "isotropic"}
    return {"bsdf": surface, "interior": medium}


def translucent(
    sigma_a: Any, sigma_s: Any, g: float = 0.0, eta: float = 1.3, alpha: float = 0.0
) -> dict[str, Any]:
    """Return the same as `standard` as a `translucent` BSDF."""
    bsdf = {"type": "translucent", "sigma_a": rgb(sigma_a), "sigma_s": rgb(sigma_s), "g": g, "alpha": alpha}
    return {"bsdf": bsdf | {"int_ior": eta, "ext_ior": 1.0}}


def trial(this: Trial, kind: str = "standard", resolution: int = 16, half: float = 24.0) -> dict[str, Any]:
    """Return the scene of a trial: seen along -z, lit some 65 degrees off, the slab from behind.

    `half`: half the side of the light, whose power stays the same: the smaller, the harder for exit lobes, and the
    noisier where lights are found by chance.
    """
    sigma_a, sigma_s, eta = this.coefficients()
    make = standard if kind == "standard" else translucent
    toward = (0.3, 0.2, -1.0) if this.shape == "slab" else (0.725, 0.544, 0.423)
    scene = camera(resolution)
    scene["object"] = placed(this.shape) | make(sigma_a, sigma_s, this.g, eta, this.alpha)
    scene["light"] = light(toward, half, 20.0 * (16.0 / half) ** 2)
    scene["environment"] = environment(0.3)
    return scene


def placed(shape: str) -> dict[str, Any]:
    """Return a shape of some 10 scene units around the origin."""
    t = mi.ScalarTransform4f
    to_world = {
        "sphere": t().scale(10),
        "cube": t().rotate([0, 1, 0], 30).rotate([1, 0, 0], 20).scale(7),
        "slab": t().scale([12, 12, 1]),
    }[shape]
    return {"type": "sphere" if shape == "sphere" else "cube", "to_world": to_world}


def camera(resolution: int = 16, rfilter: str = "box", fov: float = 24.0, **film: Any) -> dict[str, Any]:
    """Return a scene with nothing but the sensor, 55 units in front of the origin."""
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 0, 55], target=[0, 0, 0], up=[0, 1, 0])
    picture = {"type": "hdrfilm", "width": resolution, "height": resolution, "rfilter": {"type": rfilter}}
    sensor = {"type": "perspective", "fov": fov, "to_world": to_world}
    return {"type": "scene", "sensor": sensor | {"film": picture | {"pixel_format": "rgb"} | film}}


def light(toward: Sequence[float], half: float = 16.0, radiance: float = 20.0) -> dict[str, Any]:
    """Return a square area light, 40 units from the origin in the direction `toward`."""
    origin = [40.0 * float(x) / math.hypot(*toward) for x in toward]
    to_world = mi.ScalarTransform4f().look_at(origin=origin, target=[0, 0, 0], up=[0, 1, 0]).scale(half)
    return {
        "type": "rectangle",
        "to_world": to_world,
        "emitter": {"type": "area", "radiance": rgb(radiance)},
    }


def environment(radiance: Any = 1.0) -> dict[str, Any]:
    """Return a constant environment."""
    return {"type": "constant", "radiance": rgb(radiance)}


def ours(**parameters: Any) -> dict[str, Any]:
    """Return the integrator `translucent_path`."""
    return {"type": "translucent_path", **parameters}


TRUTH = {"type": "volpathmis", "max_depth": -1, "rr_depth": 100_000}
"""The reference integrator."""
