"""The options that `render` and `compare` share: names, help texts and how their values are read.

An option that wasn't given is None, so that a command can tell; `job.Settings` has what it then stands for.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from nephrite.cli import quantities
from nephrite.errors import NephriteError


def reading(parse: Callable[[str], Any], what: str) -> Callable[[Any], Any]:
    """Return a reader of text for Typer's `parser=`; what `parse` refuses is a usage error."""

    def read(value: Any) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return parse(value)
        except NephriteError as error:
            raise typer.BadParameter(str(error)) from None

    read.__name__ = what
    return read


def choice(what: str, known: Callable[[], tuple[str, ...]]) -> Callable[[Any], Any]:
    """Return a reader for one of the names that `known` lists; the error suggests the nearest."""

    def parse(text: str) -> str:
        from nephrite.errors import unknown_name

        if text not in known():
            raise unknown_name(what, text, known())
        return text

    return reading(parse, what.upper())


def _lights() -> tuple[str, ...]:
    from nephrite.scene import lights

    return lights.names()


def _models() -> tuple[str, ...]:
    from nephrite.scene import build

    return build.MODELS


def _exits() -> tuple[str, ...]:
    from nephrite.scene import build

    return build.EXITS


def _terms(text: str) -> str:
    from nephrite.scene import build

    return build.check_terms(text)


_SOURCE = (
    "A mesh (PLY, OBJ, STL, GLB), a Mitsuba scene (XML), or a name: dragon, pendant, sphere, cube, slab."
)
_SIZE = (
    "The longest side of the object, with its unit; how deep light gets depends on it; 100mm if not given."
)
_TERMS = "all (if not given), or a sum of reduced, single and multiple, like reduced+single."
_DENOISE = "Clean pictures with Open Image Denoise. By default PNG is cleaned, EXR (data) is not."

Source = Annotated[str, typer.Argument(metavar="[MESH | SCENE.xml | NAME]", help=_SOURCE)]
Material = Annotated[
    str | None,
    typer.Option(
        "--material", "-m", help="A name from `nephrite materials`; jade if not given.", metavar="NAME"
    ),
]
MaterialFile = Annotated[
    Path | None, typer.Option(help="A TOML file with materials of your own.", metavar="FILE")
]
Size = Annotated[
    float | None,
    typer.Option(help=_SIZE, metavar="LENGTH", parser=reading(quantities.length, "LENGTH")),
]
Up = Annotated[
    str | None,
    typer.Option(
        help="The mesh's axis that points up: y (if not given), z, -x ...",
        metavar="AXIS",
        parser=choice("up axis", lambda: ("y", "z", "x", "-y", "-z", "-x")),
    ),
]
Alpha = Annotated[
    float | None,
    typer.Option(
        min=0.0, max=1.0, help="Roughness of the surface, 0 (smooth, if not given) to 1.", metavar="A"
    ),
]
Model = Annotated[
    str | None,
    typer.Option(
        help="walk (if not given), auto, brdf, measured, or a model such as dipole, photon_beam or tabulated.",
        metavar="MODEL",
        parser=choice("model", _models),
    ),
]
Profile = Annotated[
    Path | None,
    typer.Option(help="A measured profile: a CSV file of r (mm) and R (1/mm^2).", metavar="FILE"),
]
Thickness = Annotated[
    float | None,
    typer.Option(
        help="For the model multipole: thickness of the plate or sheet, such as 5mm; without end if not given.",
        metavar="LENGTH",
        parser=reading(quantities.length, "LENGTH"),
    ),
]
Terms = Annotated[
    str | None,
    typer.Option(help=_TERMS, metavar="TERMS", parser=reading(_terms, "TERMS")),
]
Exit = Annotated[
    str | None,
    typer.Option(
        help="How light leaves: lobe (if not given), or exact (unbiased, slow).",
        metavar="EXIT",
        parser=choice("exit", _exits),
    ),
]
Light = Annotated[
    str | None,
    typer.Option(
        help="studio (if not given), back, side, environment or benchmark.",
        metavar="RIG",
        parser=choice("light", _lights),
    ),
]
Spp = Annotated[
    int | None,
    typer.Option(min=1, help="Samples per pixel, at most; 64 if no limit is given.", metavar="N"),
]
Time = Annotated[
    float | None,
    typer.Option(
        help="Stop after this time, like 30s or 2m.",
        metavar="TIME",
        parser=reading(quantities.duration, "TIME"),
    ),
]
Noise = Annotated[
    float | None,
    typer.Option(
        help="Stop when the noise is down to this, like 1%.",
        metavar="PERCENT",
        parser=reading(quantities.percentage, "PERCENT"),
    ),
]
Resolution = Annotated[
    Any,
    typer.Option(
        help="Size of the picture; 800x600 if not given.",
        metavar="WIDTHxHEIGHT",
        parser=reading(quantities.resolution, "WIDTHxHEIGHT"),
    ),
]
Exposure = Annotated[
    float, typer.Option(help="Stops, for PNG: 1 shows twice the light.", min=-20.0, max=20.0, metavar="STOPS")
]
Reference = Annotated[
    str,
    typer.Option(
        help="The picture that the others are compared with: first or last.",
        metavar="WHICH",
        parser=choice("reference", lambda: ("first", "last")),
    ),
]
Denoise = Annotated[bool | None, typer.Option("--denoise/--no-denoise", help=_DENOISE, show_default=False)]
Seed = Annotated[int, typer.Option(min=0, max=2**31, help="Another seed gives other noise.", metavar="N")]
Variant = Annotated[
    str | None,
    typer.Option(help="Mitsuba's variant; the fastest that works if not given.", metavar="NAME"),
]

Outputs = Annotated[
    list[Path] | None,
    typer.Option(
        "--output",
        "-o",
        help="A PNG or EXR file; give -o twice for both. NAME-MATERIAL.png if not given.",
        metavar="FILE",
    ),
]
Figure = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="A PNG file; NAME-comparison.png if not given.", metavar="FILE"),
]
Models = Annotated[str | None, typer.Option(help="Such as brdf,dipole,walk.", metavar="LIST")]
TermsList = Annotated[str | None, typer.Option(help="Such as reduced,single,multiple,all.", metavar="LIST")]
Materials = Annotated[str | None, typer.Option(help="Such as jade,marble,milk.", metavar="LIST")]
