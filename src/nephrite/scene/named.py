"""Meshes that everyone has, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from nephrite.errors import MissingDependencyError, unknown_name
from nephrite.scene import dragon, pendant, primitives
from nephrite.scene.triangles import TriangleMesh

_BUILT_IN: dict[str, Callable[[], TriangleMesh]] = {
    "pendant": pendant.make,
    "sphere": primitives.sphere,
    "cube": primitives.cube,
    "slab": primitives.slab,
}


def names() -> tuple[str, ...]:
    """Return all names: the dragon's resolutions first, then the pieces made in code."""
    return (*dragon.RESOLUTIONS, *_BUILT_IN)


def find(name: str) -> TriangleMesh:
    """Return the mesh of that name (any case), in its own units, y up; see `meshes.placed`.

    If the dragon can't be fetched, the pendant is returned instead, and its `note` says why.

    Raises:
        ParameterError: unknown name; suggests the nearest.
    """
    key = name.strip().casefold().replace(" ", "-").replace("_", "-")
    if key in _BUILT_IN:
        return _BUILT_IN[key]()
    if key not in dragon.RESOLUTIONS:
        raise unknown_name("mesh", name, names())
    try:
        return dragon.fetch(key)
    except MissingDependencyError as error:
        note = f"{error} Taking the built-in pendant instead."
        return replace(pendant.make(), note=note)
