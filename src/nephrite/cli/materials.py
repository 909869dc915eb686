"""`nephrite materials`: the library as a table with colour swatches, or one material in full."""

from __future__ import annotations

import math
import sys
from enum import Enum
from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console, Group
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from nephrite import materials
from nephrite.errors import ParameterError
from nephrite.materials import Material
from nephrite.materials.preview import seen_through

__all__ = ["materials_command"]

THIN = 5.0  # mm: the slab of the second swatch, about as thick as a fin of a carving
THICKNESSES = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
PLAIN_WIDTH = 160
SHEET_WIDTH = 88
FULL_WIDTH = 92


class KindChoice(str, Enum):
    """What `--kind` accepts."""

    MEASURED = "measured"
    ARTISTIC = "artistic"


def materials_command(
    name: Annotated[
        str | None, typer.Argument(help="Show this material in full.", show_default=False)
    ] = None,
    file: Annotated[
        Path | None,
        typer.Option(
            "--file", "-f", help="List the materials of this TOML file instead.", show_default=False
        ),
    ] = None,
    kind: Annotated[KindChoice | None, typer.Option(help="List only these.", show_default=False)] = None,
) -> None:
    """List the materials, or show one in full: coefficients in 1/mm, lengths in mm, where they come from."""
    # A pipe has no width of its own: lines that are not cut can be searched and sorted.
    console = Console()
    if not sys.stdout.isatty():
        console = Console(width=PLAIN_WIDTH)
    known = materials.all_materials() if file is None else tuple(materials.load_toml(file).values())
    if name is not None:
        console.print(_sheet(_pick(name, known) if file is not None else materials.find(name), console.width))
        return
    chosen = [material for material in known if kind is None or material.kind == kind.value]
    if not chosen:
        raise ParameterError(
            f"{file or 'the library'} has no {kind.value if kind else ''} material; leave out --kind."
        )
    console.print(_list(chosen, console.width))


def _pick(name: str, known: tuple[Material, ...]) -> Material:
    from nephrite.errors import unknown_name
    from nephrite.materials.material import key

    for material in known:
        if key(material.name) == key(name):
            return material
    raise unknown_name("material", name, [material.name for material in known])


def _list(chosen: list[Material], width: int) -> Group:
    """A table for each kind and source; they fit 80 columns."""
    wide = width >= FULL_WIDTH
    longest = max(len(material.name) for material in chosen)
    headings = ["front", f"{THIN:g} mm", "diffuse\nreflectance", "diffuse mean\nfree path (mm)"]
    parts: list[Table | Text] = []
    for (kind, source), group in groupby(chosen, lambda material: (material.kind, material.source)):
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column(Text(f"{kind}:\n{source}"), no_wrap=True, min_width=longest)
        for heading in [*headings, "index"] if wide else headings:
            table.add_column(heading, no_wrap=True, vertical="bottom")
        for material in group:
            medium = material.medium
            cells = [
                Text(material.name),
                _swatch(medium.diffuse_reflectance, 5),
                _swatch(seen_through(medium, THIN), 5),
                " ".join(f"{value:.2f}" for value in medium.diffuse_reflectance),
                " ".join(f"{_number(value):>6}" for value in medium.dmfp),
            ]
            table.add_row(*cells, *([f"{medium.eta:g}"] if wide else []))
        parts += [table, Text()]
    legend = (
        f"front: the colour in light from the front; {THIN:g} mm: the light that passes a slab so thick.\n"
        "'nephrite materials NAME' shows one in full."
    )
    return Group(*parts, Text(legend, style="dim"))


def _sheet(material: Material, width: int) -> Panel:
    medium = material.medium
    facts = Table(box=None, pad_edge=False, show_header=False)
    facts.add_column(style="bold", no_wrap=True)
    facts.add_column(overflow="fold")
    facts.add_row("kind", material.kind)
    facts.add_row("source", Text(material.source))
    facts.add_row("unit there", material.unit)
    facts.add_row("index", f"{medium.eta:g}")
    facts.add_row("mean cosine g", f"{medium.g:g}")
    if material.note:
        facts.add_row("note", Text(" ".join(material.note.split())))

    numbers = Table(box=None, pad_edge=False, header_style="bold")
    numbers.add_column("")
    for channel in ("red", "green", "blue"):
        numbers.add_column(channel, justify="right")
    numbers.add_column("unit")
    rows = [
        ("absorption sigma_a", medium.sigma_a, "1/mm"),
        ("scattering sigma_s", medium.sigma_s, "1/mm"),
        ("reduced scattering sigma_s'", medium.sigma_s_prime, "1/mm"),
        ("reduced albedo", medium.albedo_prime, ""),
        ("mean free path", medium.mfp, "mm"),
        ("diffuse mean free path", medium.dmfp, "mm"),
        ("diffuse reflectance", medium.diffuse_reflectance, ""),
    ]
    if any(material.emission):
        rows.append(("emission", material.emission, "radiance/mm"))
    for label, values, unit in rows:
        numbers.add_row(label, *(_number(value) for value in values), unit)

    looks = Table(box=None, pad_edge=False, show_header=False)
    looks.add_column(style="bold")
    looks.add_column()
    looks.add_column(style="dim")
    shown = [("in light from the front", medium.diffuse_reflectance)]
    shown += [(f"through {thickness:g} mm", seen_through(medium, thickness)) for thickness in THICKNESSES]
    for label, color in shown:
        looks.add_row(label, _swatch(color, 12), _hex(color))
    parts = Group(facts, "", numbers, "", looks)
    return Panel(parts, title=Text(material.name), title_align="left", width=min(width, SHEET_WIDTH))


def _swatch(color: tuple[float, float, float], width: int = 6) -> Text:
    return Text(" " * width, style=f"on {_hex(color)}")


def _hex(color: tuple[float, float, float]) -> str:
    """The sRGB code of a linear colour."""
    return "#" + "".join(f"{round(255 * _encode(value)):02x}" for value in color)


def _encode(value: float) -> float:
    """Linear to sRGB, both in [0, 1]."""
    value = min(max(value, 0.0), 1.0)
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


def _number(value: float) -> str:
    return "inf" if math.isinf(value) else f"{value:.3g}" if value < 1000 else f"{value:.0f}"
