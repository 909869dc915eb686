"""All materials by name: those that the package ships, read once at first use, and those that users add."""

from __future__ import annotations

from functools import lru_cache
from importlib import resources

from nephrite.errors import ParameterError, unknown_name
from nephrite.materials.material import Material, key
from nephrite.materials.toml import parse_toml

__all__ = ["all_materials", "find", "names", "register", "unregister"]

_FILES = ("artistic.toml", "measured.toml")
_added: dict[str, Material] = {}


@lru_cache(maxsize=1)
def _shipped() -> dict[str, Material]:
    """Read the package's data files: materials by key, in the files' order."""
    folder = resources.files("nephrite.materials")
    found: dict[str, Material] = {}
    for file in _FILES:
        text = folder.joinpath(file).read_text(encoding="utf-8")
        found.update((key(name), material) for name, material in parse_toml(text, file).items())
    return found


def all_materials() -> tuple[Material, ...]:
    """Every material: the artistic ones, the measured ones, then those that were registered."""
    return (*_shipped().values(), *_added.values())


def names() -> tuple[str, ...]:
    """The names of all materials, in the order of `all_materials`."""
    return tuple(material.name for material in all_materials())


def find(name: str) -> Material:
    """Return the material of this name; case, spaces, dashes and underscores do not matter.

    Raises `ParameterError` for an unknown name, with the nearest known one.
    """
    if not isinstance(name, str):
        raise ParameterError(f"material is {name!r}: give the name of a material, such as 'jade'.")
    wanted = key(name)
    material = _added.get(wanted) or _shipped().get(wanted)
    if material is None:
        raise unknown_name("material", name, names())
    return material


def register(material: Material) -> Material:
    """Make a material known to `find` under its name; returns it.

    Registering an equal material again changes nothing. Raises `ParameterError` if another material has the
    name: a scene that says `marble` must mean the same everywhere.
    """
    present = _added.get(key(material.name)) or _shipped().get(key(material.name))
    if present is not None and present != material:
        raise ParameterError(
            f"material {material.name!r}: there is already {present.name!r} ({present.source}); "
            "give yours another name, or unregister the one that you added."
        )
    if present is None:
        _added[key(material.name)] = material
    return material


def unregister(name: str) -> None:
    """Forget a material that was registered. Raises `ParameterError` for any other name."""
    if _added.pop(key(name), None) is None:
        raise unknown_name("registered material", name, [material.name for material in _added.values()])
