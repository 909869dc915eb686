"""Whole scenes: from a mesh, a material and a light rig, or from a Mitsuba scene file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from nephrite.errors import ParameterError, unknown_name
from nephrite.plugins.settings import MODELS, check_details
from nephrite.profiles import measured
from nephrite.scene import camera, lights
from nephrite.scene.files import mesh_plugin
from nephrite.scene.translucent import translucent_shapes

if TYPE_CHECKING:
    import mitsuba as mi

    from nephrite.materials import Material
    from nephrite.scene.triangles import TriangleMesh

EXITS = ("lobe", "exact")
TERMS = ("reduced", "single", "multiple")
# Mitsuba's merging puts lights in an order that differs each time, and so does the noise; loading side by side gives
# objects numbers that differ, and so do the kernels, which are compiled anew.
LOADING = {"optimize": False, "parallel": False}
OBJECT = "object"  # the name of the mesh in the scenes built here


def scene_dict(
    mesh: TriangleMesh | str | Path,
    material: Material | str | dict[str, Any] = "jade",
    size_mm: float = 100.0,
    *,
    light: str = "studio",
    resolution: tuple[int, int] = (800, 600),
    alpha: float = 0.0,
    up: str = "y",
    **integrator: Any,
) -> dict[str, Any]:
    """Return a Mitsuba scene, for `mi.load_dict`, of one object; one scene unit is one millimetre.

    Parameters: `mesh`, a mesh or the file of one, is scaled until its longest side is `size_mm`, stands on
    y = 0 and is seen from +z; its `up` axis is turned to y. `material` is a library name, a Material, or any
    BSDF dictionary. `light` is one of `lights.names()`; `alpha` the roughness of the surface; `integrator`
    the parameters of `integrator_dict`. A variant must be set.
    Raises MeshError for a mesh that can't be rendered, ParameterError for a value that can't be.
    """
    from nephrite.scene import meshes
    from nephrite.scene.triangles import TriangleMesh

    if not isinstance(mesh, TriangleMesh):
        mesh = meshes.load(mesh)
    placed = meshes.placed(mesh, size_mm, up=up)
    benchmark = light == "benchmark"
    return {
        "type": "scene",
        "integrator": integrator_dict(**integrator),
        "sensor": camera.benchmark(size_mm, resolution)
        if benchmark
        else camera.framing(placed.vertices, resolution),
        **lights.rig(light, size_mm),
        OBJECT: {**mesh_plugin(placed), "bsdf": bsdf_dict(material, alpha)},
    }


def integrator_dict(
    model: str = "walk",
    terms: str = "all",
    exit: str = "lobe",
    max_depth: int | None = None,
    rr_depth: int | None = None,
    profile: str | Path | None = None,
    thickness: float | None = None,
) -> dict[str, Any]:
    """Return a `translucent_path` integrator; `profile`: a CSV file, for `measured`; `thickness`: mm, for `multipole`.

    Raises ParameterError for an unknown model, term or exit, and for a profile or thickness that can't be.
    """
    if model not in MODELS:
        raise unknown_name("model", model, MODELS)
    if exit not in EXITS:
        raise unknown_name("exit", exit, EXITS)
    check_details(model, profile, thickness)
    if profile is not None:
        measured.read(profile)
        profile = str(profile)
    given = {"max_depth": max_depth, "rr_depth": rr_depth, "profile": profile, "thickness": thickness}
    return {
        "type": "translucent_path",
        "model": model,
        "terms": check_terms(terms),
        "exit": exit,
        **{name: value for name, value in given.items() if value is not None},
    }


def check_terms(terms: str) -> str:
    """Return `terms` without spaces; ParameterError unless it is `all` or a sum like `reduced+single`."""
    parts = terms.replace(" ", "").split("+")
    if parts != ["all"]:
        for part in parts:
            if part not in TERMS:
                raise unknown_name("term", part, ("all", *TERMS))
        if len(set(parts)) < len(parts):
            raise ParameterError(f"terms {terms!r} names a term twice; write each once, like reduced+single")
    return "+".join(parts)


def bsdf_dict(material: Material | str | dict[str, Any], alpha: float = 0.0) -> dict[str, Any]:
    """Return the BSDF of `material` with surface roughness `alpha` (0 smooth, to 1), in millimetres."""
    if isinstance(material, dict):
        return material
    if not 0 <= alpha <= 1:
        raise ParameterError(f"alpha is {alpha}: the roughness of the surface must be from 0 (smooth) to 1")
    plugin: dict[str, Any] = {"type": "translucent", "unit": 1.0, "alpha": float(alpha)}
    if isinstance(material, str):
        return {**plugin, "material": material}
    medium = material.medium
    plugin |= {
        "sigma_a": {"type": "rgb", "value": list(medium.sigma_a)},
        "sigma_s": {"type": "rgb", "value": list(medium.sigma_s)},
        "g": medium.g,
        "int_ior": medium.eta,
    }
    if any(material.emission):
        plugin["emission"] = {"type": "rgb", "value": list(material.emission)}
    return plugin


def load_xml(path: str | Path, resolution: tuple[int, int] | None = None) -> mi.Scene:
    """Load a Mitsuba scene file, and set its (first) film's `resolution` where one is given.

    Raises ParameterError if the file can't be read, or holds nothing translucent.
    """
    import mitsuba as mi

    path = Path(path)
    if not path.is_file():
        raise ParameterError(f"there is no scene file {str(path)!r}")
    try:
        scene = mi.load_file(str(path), **LOADING)
    except (RuntimeError, ValueError, TypeError) as error:
        raise ParameterError(f"Mitsuba cannot load the scene {str(path)!r}: {error}") from error
    if not isinstance(scene, mi.Scene):
        raise ParameterError(f"{str(path)!r} holds a {type(scene).__name__}, not a whole <scene>")
    if not scene.sensors():
        raise ParameterError(f"the scene {str(path)!r} has no sensor: add a <sensor> to it")
    if not translucent_shapes(scene):
        raise ParameterError(
            f"the scene {str(path)!r} has no translucent object: give a shape the BSDF `translucent`, or a "
            "`dielectric` BSDF and a `homogeneous` interior medium"
        )
    if resolution is not None:
        film = mi.traverse(scene.sensors()[0])
        film["film.size"] = list(resolution)
        film.update()
    return scene
