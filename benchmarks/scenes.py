"""The benchmark's scenes, as plain numbers that any renderer can be given.

Lengths are millimetres, radiances linear; y is up, and the object stands on y = 0. The medium is given twice: by its
coefficients, and by the two things that artists' renderers take: the colour that a thick piece of it shows
(`nephrite.physics.color`) and its reduced mean free path, `1 / sigma_t'`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nephrite import materials
from nephrite.physics import Medium
from nephrite.physics.color import color_map
from nephrite.scene import camera, meshes, named

FLOOR_HALF_SIDE = 6.0  # of the object's size


@dataclass(frozen=True)
class Light:
    """A square that shines from one side: middle and target in units of the object's size, half its side too."""

    position: tuple[float, float, float]
    half_side: float
    radiance: float


@dataclass(frozen=True)
class Scene:
    """An object of `named.find` and a material, `size` mm long; `floor`: its grey, None without one.

    `eye`, `target`: of the camera, in units of the size. `ambient`: radiance of the sky; `lobes`: see
    `peers.sky.radiance`. `reference`: the share of a reference's longest time that this scene's may have.
    """

    name: str
    title: str
    object: str
    size: float
    material: str
    floor: float | None
    lights: tuple[Light, ...]
    ambient: tuple[float, float, float]
    lobes: tuple[dict[str, Any], ...] = ()
    eye: tuple[float, float, float] = (0.25, 0.75, 1.75)
    target: tuple[float, float, float] = (0.0, 0.33, 0.0)
    reference: float = 1 / 3


SCENES = (
    Scene(
        "b1", "B1: skim-milk dragon", "dragon", 100.0, "skim-milk", 0.3,
        (Light((-0.9, 1.6, -0.9), 0.35, 25.0),), (0.15, 0.15, 0.17),
        reference=1.0,  # its worst block is asked for
    ),
    Scene(
        "jade", "Jade dragon, light from behind", "dragon", 60.0, "jade", 0.11,
        (Light((0.3, 1.7, -1.6), 0.6, 40.0),), (0.03, 0.03, 0.03),
    ),
    Scene(
        "marble", "Marble pendant under a sky", "pendant", 60.0, "marble", None, (), (0.1, 0.13, 0.18),
        (
            {"direction": (-0.7, 0.8, 0.3), "sharpness": 30.0, "radiance": (20.0, 17.0, 13.0)},
            {"direction": (0.3, 1.0, -0.2), "sharpness": 1.5, "radiance": (0.6, 0.8, 1.1)},
            {"direction": (0.5, 0.3, -1.0), "sharpness": 12.0, "radiance": (2.0, 1.7, 1.4)},
        ),
        eye=(0.35, 0.8, 2.3), target=(0.0, 0.5, 0.0),
    ),
    Scene(
        "skin", "Skin slab of 2 mm, light from behind", "slab", 40.0, "skin-pale", 0.3,
        (Light((0.6, 1.9, -1.1), 0.35, 60.0),), (0.15, 0.15, 0.17),
        eye=(0.35, 0.8, 2.3), target=(0.0, 0.48, 0.0),
    ),
)  # fmt: skip


class LeftOutError(Exception):
    """A scene that can't be made here."""


def medium(scene: Scene) -> Medium:
    """Return what the object is made of."""
    return materials.find(scene.material).medium


def described(scene: Scene, resolution: tuple[int, int], folder: Path) -> dict[str, Any]:
    """Return the scene as JSON can hold it; its mesh is written into `folder`.

    Raises `LeftOutError` if the mesh is a substitute for one that can't be fetched.
    """
    mesh = named.find(scene.object)
    if mesh.note:
        raise LeftOutError(mesh.note)
    file = meshes.write_ply(meshes.placed(mesh, scene.size), folder / f"{scene.object}-{scene.size:g}.ply")
    inside = medium(scene)
    of_surface = color_map(inside.eta, inside.g)
    aim = np.array((0.0, 0.3, 0.0)) * scene.size
    return {
        "name": scene.name,
        "mesh": str(file.resolve()),
        "triangles": len(mesh.faces),
        "resolution": list(resolution),
        "eye": [scene.size * x for x in scene.eye],
        "target": [scene.size * x for x in scene.target],
        "field_of_view": camera.FIELD_OF_VIEW,
        "sigma_a": list(inside.sigma_a),
        "sigma_s": list(inside.sigma_s),
        "g": inside.g,
        "eta": inside.eta,
        "color": [
            float(of_surface.of_coefficients(*c)) for c in zip(inside.sigma_a, inside.sigma_s, strict=True)
        ],
        "radius": [1.0 / t for t in inside.sigma_t_prime],
        "floor": scene.floor,
        "floor_half_side": FLOOR_HALF_SIDE * scene.size,
        "lights": [
            {
                "position": [scene.size * x for x in light.position],
                "target": aim.tolist(),
                "half_side": scene.size * light.half_side,
                "radiance": light.radiance,
            }
            for light in scene.lights
        ],
        "sky": {"ambient": list(scene.ambient), "lobes": [dict(lobe) for lobe in scene.lobes]},
    }
