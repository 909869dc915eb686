"""Light rigs: emitters and floors for an object that stands on y = 0, centred on the y axis, seen from +z.

Every position is in units of the object's size, so a rig looks the same on a ring and on a statue. Radiances
are in the scene's units (a white wall in radiance 1 shows as 1 on a linear picture) and don't depend on it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from nephrite.errors import ParameterError, unknown_name

Colour = float | Sequence[float]
Plugins = dict[str, dict[str, Any]]


def rig(name: str, size_mm: float) -> Plugins:
    """Return the emitters and the floor of the rig `name` as Mitsuba plugin dictionaries.

    Parameters: `name`, one of `names()`; `size_mm`, the longest side of the object in scene units.
    A variant must be set. Raises ParameterError for an unknown name or a size that isn't positive and finite.
    """
    if name not in _RIGS:
        raise unknown_name("light rig", name, _RIGS)
    if not 0 < size_mm < math.inf:
        raise ParameterError(f"size_mm is {size_mm}: the size of the object must be positive and finite")
    return _RIGS[name](float(size_mm))


def names() -> tuple[str, ...]:
    """Return the names of the rigs, the default first."""
    return tuple(_RIGS)


def describe(name: str) -> str:
    """Return one line about the rig `name`."""
    if name not in _RIGS:
        raise unknown_name("light rig", name, _RIGS)
    return (_RIGS[name].__doc__ or "").strip()


def _studio(size: float) -> Plugins:
    """A strong warm light from behind, a cool rim, a soft key and fill, a dark sweep as backdrop."""
    return {
        "backdrop": _sweep(size, 0.11),
        "back": _softbox(size, (0.9, 2.2, -1.5), 0.6, (36.0, 28.0, 19.0)),
        "rim": _softbox(size, (-2.2, 1.2, -0.9), 0.45, (13.0, 17.0, 22.0)),
        "key": _softbox(size, (-1.3, 2.0, 1.3), 0.7, 4.0),
        "fill": _softbox(size, (2.2, 1.0, 1.8), 0.9, (0.8, 0.85, 0.95)),
        "ambient": _constant((0.02, 0.022, 0.026)),
    }


def _back(size: float) -> Plugins:
    """One light behind the object and above it: what shows through is what the material lets through."""
    return {
        "backdrop": _sweep(size, 0.11),
        "back": _softbox(size, (0.3, 2.2, -1.6), 0.6, 40.0),
        "ambient": _constant(0.03),
    }


def _side(size: float) -> Plugins:
    """One soft light from the left: the shadow's edge shows how far light travels inside."""
    return {
        "backdrop": _sweep(size, 0.11),
        "side": _softbox(size, (-2.2, 1.1, 0.3), 0.45, 32.0),
        "ambient": _constant(0.03),
    }


def _environment(size: float) -> Plugins:
    """A white environment of radiance 1 and no floor: a material that absorbs nothing disappears in it."""
    return {"environment": _constant(1.0)}


def _benchmark(size: float) -> Plugins:
    """The light of benchmark scene B1: one square light behind and above, a dim sky, a flat grey floor."""
    return {
        "floor": {
            "type": "rectangle",
            "to_world": _facing((0, 0, 0), (0, 1, 0), 6 * size),
            "bsdf": _diffuse(0.3),
        },
        "light": _evenly(_softbox(size, (-0.9, 1.6, -0.9), 0.35, 25.0)),
        "sky": _evenly(_constant((0.15, 0.15, 0.17))),
    }


_RIGS: dict[str, Callable[[float], Plugins]] = {
    "studio": _studio,
    "back": _back,
    "side": _side,
    "environment": _environment,
    "benchmark": _benchmark,
}

AIM = (0.0, 0.3, 0.0)  # what every light points at, in units of the size
LEAST_WEIGHT = 0.2  # of a light in sampling: what only it reaches shall not be left noisy


def _softbox(size: float, position: Sequence[float], half_side: float, radiance: Colour) -> dict[str, Any]:
    """A square light that shines from one side, towards the object."""
    irradiance = _mean(radiance) * (2 * half_side) ** 2 / math.dist(position, AIM) ** 2
    return {
        "type": "rectangle",
        "to_world": _facing([size * x for x in position], [size * x for x in AIM], half_side * size),
        "emitter": {"type": "area", "radiance": _rgb(radiance), "sampling_weight": _weight(irradiance)},
        "bsdf": _diffuse(0.0),
    }


def _sweep(size: float, grey: float) -> dict[str, Any]:
    """A photographer's paper sweep: a floor that bends up into a wall behind the object, without an edge."""
    import numpy as np

    from nephrite.scene.check import examine
    from nephrite.scene.files import mesh_plugin
    from nephrite.scene.triangles import TriangleMesh

    front, bend, wall, radius, half_width = 8.0, -3.0, 10.0, 2.5, 14.0
    angles = np.linspace(0, np.pi / 2, 33)
    z = np.concatenate([[front], bend - radius * np.sin(angles), [bend - radius]])
    y = np.concatenate([[0.0], radius * (1 - np.cos(angles)), [wall]])
    left = np.stack([np.full_like(y, -half_width), y, z], axis=1)
    vertices = size * np.concatenate([left, left * (-1, 1, 1)])
    near = np.arange(len(y) - 1)
    far = near + len(y)
    faces = np.concatenate([np.stack([near, far, far + 1], 1), np.stack([near, far + 1, near + 1], 1)])
    mesh = TriangleMesh(vertices, faces, "backdrop", examine(vertices, faces))
    return {**mesh_plugin(mesh), "bsdf": _diffuse(grey)}


def _facing(origin: Sequence[float], target: Sequence[float], half_side: float) -> Any:
    """Move Mitsuba's rectangle ([-1, 1]^2, facing +z) to `origin`, facing `target`."""
    import mitsuba as mi

    turn = mi.ScalarTransform4f()
    upright = abs(target[0] - origin[0]) + abs(target[2] - origin[2]) < 1e-6
    up = [0, 0, -1] if upright else [0, 1, 0]
    return turn.look_at(origin=list(origin), target=list(target), up=up) @ turn.scale(half_side)


def _diffuse(grey: float) -> dict[str, Any]:
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": grey}}


def _constant(radiance: Colour) -> dict[str, Any]:
    weight = _weight(math.pi * _mean(radiance))
    return {"type": "constant", "radiance": _rgb(radiance), "sampling_weight": weight}


def _weight(irradiance: float) -> float:
    """How often a light is sampled: as often as the object gets light from it, and never too seldom."""
    return max(irradiance, LEAST_WEIGHT)


def _evenly(plugin: dict[str, Any]) -> dict[str, Any]:
    """Have a light sampled as often as any other, which is Mitsuba's default."""
    emitter = plugin.get("emitter", plugin)
    del emitter["sampling_weight"]
    return plugin


def _mean(colour: Colour) -> float:
    return sum(colour) / len(colour) if isinstance(colour, Sequence) else colour


def _rgb(value: Colour) -> dict[str, Any]:
    return {"type": "rgb", "value": list(value) if isinstance(value, Sequence) else value}
