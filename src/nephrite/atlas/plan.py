"""What the atlas looks at: the whole of it, and the small part that continuous integration does."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

__all__ = ["FULL", "INCIDENCES", "OWN_INCIDENCE", "QUICK", "Plan", "View"]

INCIDENCES = ("normal", "diffuse")

OWN_INCIDENCE = {"normalized": "diffuse", "tabulated": "diffuse"}
"""The incidence that a model, as `nephrite.profiles.models` makes it, is meant for: "normal" unless it is in here."""


@dataclass(frozen=True)
class View:
    """A picture's scene: an object of `nephrite.scene.named`, its longest side in mm, a material and a light rig."""

    object: str
    size: float
    material: str
    light: str

    def __str__(self) -> str:
        """Name it in a few words."""
        return f"{self.object} of {self.size:g} mm, {self.material.replace('-', ' ')}, {self.light} light"


@dataclass(frozen=True)
class Plan:
    """Grids of the atlas.

    Half-spaces: every reduced albedo of `albedos` with every `etas` and `gs`, `photons` each (fewer where g is high).
    Slabs: isotropic, `thicknesses` in mean free paths, `slab_albedos`, `slab_etas`. Pictures: `views` of `resolution`,
    with at least `truth_spp` and `spp` samples per pixel for the exact walk and for each model; `shown` have a figure.
    `finer`: how many times more samples, step by step, the pictures of `contest` get where noise leaves an order open.
    `timed`: there are enough pictures, and enough samples in each, to speak of speed and to choose a model by.
    """

    albedos: tuple[float, ...]
    etas: tuple[float, ...]
    gs: tuple[float, ...]
    photons: int
    thicknesses: tuple[float, ...]
    slab_albedos: tuple[float, ...]
    slab_etas: tuple[float, ...]
    slab_photons: int
    views: tuple[View, ...]
    shown: tuple[View, ...]
    resolution: tuple[int, int]
    truth_spp: int
    spp: int
    finer: tuple[int, ...]
    timed: bool


_MATERIALS = ("skim-milk", "marble", "ketchup", "skin-1", "jade")
_LIGHTS = ("side", "back")
_PLACES = (
    ("dragon", 30.0),
    ("dragon", 10.0),
    ("dragon", 100.0),
    ("dragon", 1000.0),
    ("slab", 30.0),
    ("sphere", 30.0),
    ("cube", 30.0),
)

FULL = Plan(
    albedos=(0.3, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999, 0.9999),
    etas=(1.0, 1.1, 1.3, 1.6),
    gs=(0.0, 0.5, 0.8, 0.95),
    photons=2**19,
    thicknesses=(0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0),
    slab_albedos=(0.5, 0.9, 0.99, 0.999),
    slab_etas=(1.0, 1.4),
    slab_photons=2**18,
    views=tuple(
        View(name, size, material, light)
        for light, (name, size), material in product(_LIGHTS, _PLACES, _MATERIALS)
    ),
    shown=(
        *(View("dragon", 30.0, material, "side") for material in _MATERIALS),
        View("slab", 30.0, "marble", "back"),
        View("sphere", 30.0, "skin-1", "side"),
        View("cube", 30.0, "skim-milk", "back"),
    ),
    resolution=(96, 72),
    truth_spp=128,
    spp=32,
    finer=(8, 64, 256),
    timed=True,
)

QUICK = Plan(
    albedos=(0.5, 0.9, 0.99, 0.999),
    etas=(1.3,),
    gs=(0.0,),
    photons=2**17,
    thicknesses=(1.0, 5.0, 20.0),
    slab_albedos=(0.5, 0.99),
    slab_etas=(1.3,),
    slab_photons=2**16,
    views=(View("sphere", 30.0, "skim-milk", "side"), View("slab", 30.0, "marble", "back")),
    shown=(View("sphere", 30.0, "skim-milk", "side"),),
    resolution=(48, 48),
    truth_spp=64,
    spp=16,
    finer=(),
    timed=False,
)
