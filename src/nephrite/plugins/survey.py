"""Finds the translucent materials of a scene, and refuses media that the integrator does not render."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.errors import ParameterError
from nephrite.plugins.entry import Entry

_PHASES = ("isotropic", "hg")


def entries(scene: Any) -> list[Entry]:
    """Return the materials that light can enter; raises `ParameterError` for those that cannot be rendered."""
    found: dict[int, Entry] = {}
    for shape in scene.shapes():
        _survey(shape, found)
    grouped = _grouped(scene)
    for shape in grouped:
        _survey(shape, found)
    if grouped:  # instances may be of any size
        longest = float(dr.norm(scene.bbox().extents()))
        for entry in found.values():
            entry.least_reach = longest
    _refuse_fog(scene)
    return list(found.values())


def _grouped(scene: Any) -> list[Any]:
    """Return the shapes in the scene's shape groups, which are rendered by instances."""
    groups = [child for child in _children(scene) if child.class_name().lower().startswith("shapegroup")]
    return [shape for group in groups for shape in _children(group) if isinstance(shape, mi.Shape)]


def _children(parent: Any) -> list[Any]:
    found: list[Any] = []

    class Collect(mi.TraversalCallback):
        def put(self, name: Any, value: Any, *_: Any) -> None:
            if isinstance(value, mi.Object):
                found.append(value)

    parent.traverse(Collect())
    return found


def _survey(shape: Any, found: dict[int, Entry]) -> None:
    bsdf, medium = shape.bsdf(), shape.interior_medium()
    if bsdf is None:
        return
    if hasattr(bsdf, "diffuse_reflectance") and hasattr(bsdf, "coefficients"):
        key = id(bsdf)
        entry = found.setdefault(key, Entry(bsdf.name, bsdf.g, bsdf.eta, bsdf.interface, bsdf=bsdf))
    elif medium is not None:
        entry = _standard(shape, bsdf, medium, found)
    else:
        return
    entry.shapes.append(shape)


def _refuse_fog(scene: Any) -> None:
    """Raise `ParameterError` for a medium around the objects: one that is the inside of no shape."""
    interiors = [shape.interior_medium() for shape in scene.shapes()]
    for shape in scene.shapes():
        name, medium = shape.id() or "a shape", shape.exterior_medium()
        if medium is not None and not any(
            medium == interior for interior in interiors if interior is not None
        ):
            raise ParameterError(
                f"{name} lies in a medium that fills the space around objects: translucent_path renders media inside "
                "shapes only; use volpathmis for this scene."
            )


def _standard(shape: Any, bsdf: Any, medium: Any, found: dict[int, Entry]) -> Entry:
    name = shape.id() or "without an id"
    if not medium.is_homogeneous():
        raise ParameterError(
            f"shape {name!r} holds a medium that is not homogeneous: translucent_path renders homogeneous ones "
            "only; use volpathmis for this scene."
        )
    kind = bsdf.class_name().lower()
    if "dielectric" not in kind or "thin" in kind:
        raise ParameterError(
            f"shape {name!r} has an interior medium behind a {bsdf.class_name()}: translucent_path needs a "
            "dielectric, roughdielectric or translucent BSDF there."
        )
    key = hash((id(bsdf), id(medium)))
    if key in found:
        return found[key]
    values = {str(name): value for name, value in mi.traverse(bsdf)}
    tinted = any(str(key).startswith("specular_") for key in values)
    smooth = "rough" not in kind and not tinted
    phase = medium.phase_function()
    phase_kind = phase.class_name().lower()
    if not any(known in phase_kind for known in _PHASES):
        raise ParameterError(
            f"the medium of shape {name!r} has the phase function {phase.class_name()}: translucent_path knows "
            "isotropic and hg."
        )
    phase_values = {str(name): value for name, value in mi.traverse(phase)}
    g = float(np.ravel(phase_values["g"])[0]) if "g" in phase_values else 0.0
    eta = float(np.ravel(values["eta"])[0])
    entry = Entry(name, g, eta, None if smooth else bsdf, medium=medium, owner=bsdf)
    found[key] = entry
    return entry
