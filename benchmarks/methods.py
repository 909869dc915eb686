"""What is compared: each renderer's methods, and the process that runs each."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from nephrite.plugins.settings import MODELS

BASE = "cycles"
"""The method that ratios are relative to."""

ONCE = ("volpath", "luxcore", "cycles-plain", "brdf", "brdf-gpu")
"""What one round is enough for: it takes minutes, or no ratio to it is asked for."""

REFERENCE = {"type": "translucent_path", "model": "walk", "exit": "exact"}
"""What the truth is rendered with: unbiased, and compared with `volpathmis` by z-tests in tests/plugins."""


@dataclass(frozen=True)
class Method:
    """A way to render: the module in benchmarks/peers, and what that is told.

    `package`: what has to be installed in the peers' environment; empty for what runs in Nephrite's own.
    """

    name: str
    title: str
    peer: str
    package: str = ""
    settings: dict[str, Any] = field(default_factory=dict)


def mitsuba(name: str, title: str, variant: str = "llvm_ad_rgb", **integrator: Any) -> Method:
    """Return a method that is an integrator plugin."""
    return Method(name, title, "mitsuba", settings={"variant": variant, "integrator": integrator})


def nephrite(variant: str = "llvm_ad_rgb") -> list[Method]:
    """Return Nephrite's own methods in a variant, `transport` among them where this version has it."""
    on_gpu = variant.startswith("cuda")
    suffix, after = ("-gpu", ", GPU") if on_gpu else ("", "")
    chosen = [
        ("walk-exact", "walk, exact exit", {"model": "walk", "exit": "exact"}),
        ("walk", "walk, lobe exit", {"model": "walk", "exit": "lobe"}),
        ("transport", "transport", {"model": "transport"}),
        ("tabulated", "tabulated", {"model": "tabulated"}),
        ("dipole", "dipole", {"model": "dipole"}),
        ("brdf", "brdf", {"model": "brdf"}),
    ]
    return [
        mitsuba(name + suffix, f"Nephrite {title}{after}", variant, type="translucent_path", **given)
        for name, title, given in chosen
        if given["model"] in MODELS
    ]


def all_methods(gpu: bool) -> list[Method]:
    """Return every method, in the order in which they are shown."""
    unlimited = {"max_depth": -1, "rr_depth": 1000}
    # Cycles divides the radius by 4 pi to get a mean free path
    scaled, plain = {"radius_scale": 4.0 * math.pi}, {"radius_scale": 1.0}
    return [
        mitsuba("volpath", "Mitsuba volpath", type="volpath", **unlimited),
        mitsuba("volpathmis", "Mitsuba volpathmis", type="volpathmis", **unlimited),
        Method("luxcore", "LuxCore path", "luxcore", "pyluxcore"),
        Method("cycles", "Cycles random walk", "cycles", "bpy", {"subsurface": "RANDOM_WALK", **scaled}),
        Method("cycles-plain", "Cycles random walk, unscaled", "cycles", "bpy", {"subsurface": "RANDOM_WALK", **plain}),
        Method("burley", "Cycles Burley", "cycles", "bpy", {"subsurface": "BURLEY", **scaled}),
        *nephrite(),
        *(nephrite("cuda_ad_rgb") if gpu else []),
    ]  # fmt: skip
