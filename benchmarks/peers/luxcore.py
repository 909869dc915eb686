"""LuxCore's path tracer through the `pyluxcore` wheel: glass with a homogeneous volume inside.

It samples one distance for all channels, and where their coefficients differ its variance has no bound. So each channel
is rendered alone, with a grey medium: a picture is three renders.
"""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyluxcore

from benchmarks.peers import measure, sky

_SKY = (256, 128)
_DEPTH = 1000  # every event in the volume is a bounce; some paths would never end


def prepare(scene: dict[str, Any], method: dict[str, Any]) -> measure.Renderer:
    """Build the scene; there is nothing to choose in `method`."""
    pyluxcore.Init()
    pyluxcore.SetLogHandler(lambda _: None)
    width, height = scene["resolution"]
    built = _build(scene)

    def render(spp: int, seed: int) -> Any:
        config = pyluxcore.RenderConfig(_properties(_settings(width, height, spp, seed)), built)
        session = pyluxcore.RenderSession(config)
        session.Start()
        while not session.HasDone():
            session.UpdateStats()
            time.sleep(0.005)
        session.Stop()
        pixels = np.zeros((height, width, 3), np.float32)
        session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels, 0, False)
        return pixels[::-1]

    def call(spp: int, seed: int) -> Any:
        channels = []
        for i in range(3):
            built.Parse(_properties(_medium(scene, i)))
            channels.append(render(spp, 3 * seed + i)[..., i])
        return np.stack(channels, axis=-1)

    return measure.Renderer(call, f"LuxCore {pyluxcore.Version()}")


def _settings(width: int, height: int, spp: int, seed: int) -> dict[str, Any]:
    """Choose an unclamped path tracer with a box filter."""
    kinds = ("total", "diffuse", "glossy", "specular")
    return {
        "renderengine.type": "PATHCPU",
        "renderengine.seed": seed + 1,
        "native.threads.count": measure.cores(),
        "sampler.type": "RANDOM",
        "batch.haltspp": spp,
        **{f"path.pathdepth.{kind}": _DEPTH for kind in kinds},
        # its roulette looks at the last event alone, where eta^2 comes and goes: weights grow without end
        "path.russianroulette.depth": _DEPTH,
        "path.clamping.variance.maxvalue": 0.0,
        "film.width": width,
        "film.height": height,
        "film.filter.type": "BOX",
        "film.filter.width": 0.5,
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "picture.exr",
    }


def _build(scene: dict[str, Any]) -> Any:
    built = pyluxcore.Scene()
    properties: dict[str, Any] = {
        "scene.camera.type": "perspective",
        "scene.camera.lookat.orig": scene["eye"],
        "scene.camera.lookat.target": scene["target"],
        "scene.camera.up": [0.0, 1.0, 0.0],
        "scene.camera.fieldofview": scene["field_of_view"],
        **_medium(scene, 0),
        "scene.materials.object.type": "glass",
        "scene.materials.object.kr": [1.0] * 3,
        "scene.materials.object.kt": [1.0] * 3,
        "scene.materials.object.interiorior": scene["eta"],
        "scene.materials.object.exteriorior": 1.0,
        "scene.materials.object.volume.interior": "medium",
        "scene.objects.object.shape": "object",
        "scene.objects.object.material": "object",
        **_sky(built, scene["sky"]),
    }
    built.DefineMeshExt("object", *_triangles(Path(scene["mesh"])))
    if scene["floor"] is not None:
        _square(built, "floor", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], scene["floor_half_side"])
        properties |= _matte("floor", scene["floor"])
    for i, light in enumerate(scene["lights"]):
        name = f"light{i}"
        _square(built, name, light["position"], light["target"], light["half_side"])
        properties |= _matte(name, 0.0)
        properties[f"scene.materials.{name}.emission"] = [light["radiance"]] * 3
    built.Parse(_properties(properties))
    return built


def _triangles(file: Path) -> tuple[Any, Any]:
    """Read the places and the faces of a mesh that benchmarks/scenes.py has written, and leave its normals.

    Where a normal at a hit is not the triangle's, LuxCore takes a ray for entering that leaves, or the other way; in a
    medium the factors eta^2 of the wrong kind multiply without end.
    """
    head, _, body = file.read_bytes().partition(b"end_header\n")
    vertices, faces = (
        int(line.split()[2]) for line in head.decode("ascii").splitlines() if line.startswith("element")
    )
    points = np.frombuffer(body, np.dtype("<f4"), 6 * vertices).reshape(-1, 6)[:, :3]
    row = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    corners = np.frombuffer(body, row, faces, offset=24 * vertices)["corners"]
    return np.ascontiguousarray(points), np.ascontiguousarray(corners, np.uint32)


def _medium(scene: dict[str, Any], channel: int) -> dict[str, Any]:
    """Return a grey medium with the coefficients of one channel."""
    return {
        "scene.volumes.medium.type": "homogeneous",
        "scene.volumes.medium.absorption": [scene["sigma_a"][channel]] * 3,
        "scene.volumes.medium.scattering": [scene["sigma_s"][channel]] * 3,
        "scene.volumes.medium.asymmetry": [scene["g"]] * 3,
        "scene.volumes.medium.multiscattering": True,
    }


def _matte(name: str, grey: float) -> dict[str, Any]:
    return {
        f"scene.materials.{name}.type": "matte",
        f"scene.materials.{name}.kd": [grey] * 3,
        f"scene.objects.{name}.shape": name,
        f"scene.objects.{name}.material": name,
    }


def _square(built: Any, name: str, position: list[float], target: list[float], half_side: float) -> None:
    """Define a square mesh that faces `target`, counter-clockwise from there."""
    middle = np.array(position, float)
    normal = np.array(target, float) - middle
    normal /= np.linalg.norm(normal)
    helper = (0.0, 1.0, 0.0) if abs(normal[1]) < 0.99 else (0.0, 0.0, -1.0)
    right = np.cross(helper, normal)
    right *= half_side / np.linalg.norm(right)
    up = np.cross(normal, right)
    corners = [middle + x * right + y * up for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    points = [tuple(float(c) for c in corner) for corner in corners]
    built.DefineMesh(name, points, [(0, 1, 2), (0, 2, 3)], None, None, None, None)


def _sky(built: Any, given: dict[str, Any]) -> dict[str, Any]:
    if not given["lobes"]:
        return {"scene.lights.sky.type": "constantinfinite", "scene.lights.sky.color": given["ambient"]}
    width, height = _SKY
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    turn, polar = 2 * np.pi * u, np.pi * v  # the picture's pole is z
    directions = np.stack(
        [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=-1
    )
    pixels = np.ascontiguousarray(sky.radiance(given, directions))
    built.DefineImageMap("sky", pixels, 1.0, 3, width, height)
    return {
        "scene.lights.sky.type": "infinite",
        "scene.lights.sky.file": "sky",
        "scene.lights.sky.gamma": 1.0,
    }


def _properties(values: dict[str, Any]) -> Any:
    properties = pyluxcore.Properties()
    for name, value in values.items():
        properties.Set(pyluxcore.Property(name, value))
    return properties


if __name__ == "__main__":
    measure.main(prepare)
    os._exit(0)  # its threads do not survive the interpreter's end
