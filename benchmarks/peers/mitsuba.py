"""Mitsuba's own volume integrators and Nephrite's models, on Mitsuba's dielectric with a homogeneous medium."""

from __future__ import annotations

from typing import Any

import nephrite  # noqa: F401 (before Mitsuba)

import mitsuba as mi  # isort: skip
import numpy as np

from benchmarks.peers import measure, sky
from nephrite.scene import camera

_SKY = (256, 128)


def prepare(scene: dict[str, Any], method: dict[str, Any]) -> measure.Renderer:
    """Load the scene; `method` has `integrator`, a plugin dictionary, and `variant`."""
    mi.set_variant(method["variant"])
    loaded = load(scene)

    def call(spp: int, seed: int) -> Any:
        # a new integrator each time: what it prepares for a picture is a part of the picture's time
        integrator: Any = mi.load_dict(method["integrator"])
        return mi.render(loaded, integrator=integrator, spp=spp, seed=seed).numpy()[..., :3]  # type: ignore[arg-type]

    return measure.Renderer(call, f"Mitsuba {mi.__version__}, {mi.variant()}")


def load(scene: dict[str, Any]) -> Any:
    """Return the Mitsuba scene; a variant must be set."""
    described: dict[str, Any] = {
        "type": "scene",
        "sensor": camera.sensor(scene["eye"], scene["target"], tuple(scene["resolution"])),
        "object": {
            "type": "ply",
            "filename": scene["mesh"],
            "bsdf": {"type": "dielectric", "int_ior": scene["eta"], "ext_ior": 1.0},
            "interior": _medium(scene),
        },
        "sky": _sky(scene["sky"]),
    }
    for i, light in enumerate(scene["lights"]):
        described[f"light{i}"] = {
            "type": "rectangle",
            "to_world": _facing(light["position"], light["target"], light["half_side"]),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": light["radiance"]}},
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        }
    if scene["floor"] is not None:
        described["floor"] = {
            "type": "rectangle",
            "to_world": _facing([0, 0, 0], [0, 1, 0], scene["floor_half_side"]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": scene["floor"]}},
        }
    return mi.load_dict(described, optimize=False)


def _medium(scene: dict[str, Any]) -> dict[str, Any]:
    total = np.array(scene["sigma_a"]) + np.array(scene["sigma_s"])
    scale = float(total.max())
    phase = {"type": "hg", "g": scene["g"]} if scene["g"] else {"type": "isotropic"}
    return {
        "type": "homogeneous",
        "scale": scale,
        "sigma_t": {"type": "rgb", "value": (total / scale).tolist()},
        "albedo": {"type": "rgb", "value": (np.array(scene["sigma_s"]) / total).tolist()},
        "phase": phase,
    }


def _sky(given: dict[str, Any]) -> dict[str, Any]:
    if not given["lobes"]:
        return {"type": "constant", "radiance": {"type": "rgb", "value": given["ambient"]}}
    width, height = _SKY
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    turn, polar = 2 * np.pi * u, np.pi * v
    directions = np.stack(
        [np.sin(turn) * np.sin(polar), np.cos(polar), -np.cos(turn) * np.sin(polar)], axis=-1
    )
    return {"type": "envmap", "bitmap": mi.Bitmap(sky.radiance(given, directions)), "scale": 1.0}


def _facing(origin: list[float], target: list[float], half_side: float) -> Any:
    """Move Mitsuba's rectangle ([-1, 1]^2, facing +z) to `origin`, facing `target`."""
    turn = mi.ScalarTransform4f()
    upright = abs(target[0] - origin[0]) + abs(target[2] - origin[2]) < 1e-6
    up = [0, 0, -1] if upright else [0, 1, 0]
    return turn.look_at(origin=origin, target=target, up=up) @ turn.scale(half_side)


if __name__ == "__main__":
    measure.main(prepare)
