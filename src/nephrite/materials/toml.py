"""Materials from TOML: the library's own data files and the users' files have one format.

    [green-tea]                        # the name
    unit = "1/cm"                      # of the coefficients: 1/mm, 1/cm or 1/m; required
    sigma_a = [0.02, 0.01, 0.12]       # one number or red, green, blue
    sigma_s = [0.3, 0.3, 0.3]          # or sigma_s_prime, if the table gives reduced scattering
    g = 0.8                            # mean cosine; 0 if left out
    eta = 1.33                         # index of refraction inside / outside; 1.3 if left out

    [my-jade]
    unit = "mm"                        # of the radius: mm, cm or m; required
    albedo = [0.2, 0.5, 0.3]           # the diffuse colour, linear, in [0, 1]
    radius = 1.2                       # the reduced mean free path

Also `emission` (radiance per length, in the same unit), `source`, `note`, `kind` ("measured" or "artistic").
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from nephrite.errors import ParameterError, unknown_name
from nephrite.materials.material import Material, key
from nephrite.physics.color import from_color_and_radius
from nephrite.physics.medium import Medium, rgb

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["load_toml", "parse_toml"]

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
NUMBERS = ("sigma_a", "sigma_s", "sigma_s_prime", "albedo", "radius", "g", "eta", "emission")
TEXTS = ("unit", "kind", "source", "note")
COEFFICIENTS = frozenset({"sigma_a", "sigma_s", "sigma_s_prime"})
APPEARANCE = frozenset({"albedo", "radius"})


def load_toml(path: str | Path) -> dict[str, Material]:
    """Read the materials of a TOML file; returns them by name, in the file's order, without registering them.

    Raises `ParameterError`, with the file, the material, the key, the value and the remedy, if the file
    cannot be read, is no TOML, holds no material, or a material is incomplete, ambiguous or impossible.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise ParameterError(
            f"{path}: there is no such file; give the path of a TOML file of materials."
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"{path}: cannot be read as UTF-8 text ({error}).") from error
    return parse_toml(text, str(path))


def parse_toml(text: str, where: str) -> dict[str, Material]:
    """Parse the text of such a file; `where` names it in errors and is the default `source`."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ParameterError(f"{where}: this is not TOML: {error}.") from error
    if not tables:
        raise ParameterError(f"{where}: holds no material; write a table such as [my-jade] with its keys.")
    materials: dict[str, Material] = {}
    seen: dict[str, str] = {}
    for name, table in tables.items():
        place = f"{where}: [{name}]"
        if not isinstance(table, dict):
            _refuse(
                f"{where}: {name} = {table!r}",
                "stands outside a material; put it under a line such as [my-jade].",
            )
        if key(name) in seen:
            _refuse(place, f"is the same name as [{seen[key(name)]}]: only letters and digits count.")
        seen[key(name)] = name
        try:
            materials[name] = _material(name, table, where)
        except ParameterError as error:
            raise ParameterError(f"{place} {error}") from None
    return materials


def _material(name: str, table: Mapping[str, Any], where: str) -> Material:
    """Build one material; its errors do not name the place, which the caller knows."""
    for entry, value in table.items():
        if entry not in NUMBERS + TEXTS:
            raise unknown_name("key", entry, NUMBERS + TEXTS)
        if entry in TEXTS and not isinstance(value, str):
            _refuse(f"{entry} = {value!r}", "must be text in quotes.")
    coefficients, appearance = COEFFICIENTS & table.keys(), APPEARANCE & table.keys()
    if coefficients and appearance:
        given = ", ".join(sorted(coefficients | appearance))
        _refuse(f"has {given}", ": give either coefficients (sigma_a and sigma_s) or albedo and radius.")
    if not coefficients and not appearance:
        _refuse("has no optical properties", ": give sigma_a and sigma_s, or albedo and radius.")

    length = _length(table, inverse=bool(coefficients))
    g, eta = table.get("g", 0.0), table.get("eta", 1.3)
    if coefficients:
        medium = _from_coefficients(table, 1.0 / length, g, eta)
    else:
        _require(table, APPEARANCE)
        radius = [length * value for value in rgb(table["radius"], "radius")]
        medium = from_color_and_radius(table["albedo"], radius, g, eta, name="albedo")
    emission = [value / length for value in rgb(table.get("emission", 0.0), "emission")]
    texts = {entry: table[entry] for entry in ("kind", "note") if entry in table}
    source = table.get("source", where)
    return Material(
        name, medium, table["unit"], source, emission=(emission[0], emission[1], emission[2]), **texts
    )


def _from_coefficients(table: Mapping[str, Any], per_mm: float, g: float, eta: float) -> Medium:
    if "sigma_s" in table and "sigma_s_prime" in table:
        _refuse("has both sigma_s and sigma_s_prime", ": give one; sigma_s_prime is sigma_s (1 - g).")
    scattering = "sigma_s_prime" if "sigma_s_prime" in table else "sigma_s"
    _require(table, {"sigma_a", scattering})
    absorbed = [per_mm * value for value in rgb(table["sigma_a"], "sigma_a")]
    scattered = [per_mm * value for value in rgb(table[scattering], scattering)]
    build = Medium.from_reduced if scattering == "sigma_s_prime" else Medium
    return build(absorbed, scattered, g, eta)


def _length(table: Mapping[str, Any], inverse: bool) -> float:
    """Millimetres in the table's unit of length; coefficients have `1/` before it."""
    known = [f"1/{unit}" for unit in MILLIMETRES] if inverse else [*MILLIMETRES]
    subject = "the coefficients" if inverse else "the radius"
    if "unit" not in table:
        _refuse(
            "has no unit", f": say what {subject} are in, for example unit = {known[0]!r}.".replace("'", '"')
        )
    unit = table["unit"].replace(" ", "")
    if unit not in known:
        _refuse(f"unit = {table['unit']!r}", f"is no unit for {subject}; use one of {', '.join(known)}.")
    return MILLIMETRES[unit.removeprefix("1/")]


def _require(table: Mapping[str, Any], entries: set[str] | frozenset[str]) -> None:
    missing = sorted(entries - table.keys())
    if missing:
        present = sorted(entries & table.keys())
        _refuse(f"has {' and '.join(present)} but no {' and '.join(missing)}", ": give both; 0 is allowed.")


def _refuse(what: str, why: str) -> NoReturn:
    raise ParameterError(f"{what}{'' if why.startswith(':') else ' '}{why}")
