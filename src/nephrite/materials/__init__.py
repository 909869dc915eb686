"""Named materials: measured ones with their source, artistic ones that say so, and the users' own.

    from nephrite import materials
    materials.find("skim milk").medium.diffuse_reflectance

Users add theirs by `register(Material(...))` or from a TOML file by `load_toml`.
"""

from __future__ import annotations

from nephrite.materials.material import Material
from nephrite.materials.registry import all_materials, find, names, register, unregister
from nephrite.materials.toml import load_toml

__all__ = ["Material", "all_materials", "find", "load_toml", "names", "register", "unregister"]
