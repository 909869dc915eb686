"""The `nephrite` command: its sub-commands and its global options."""

from __future__ import annotations

from typing import Annotated

import typer

from nephrite import __version__
from nephrite.cli.atlas import atlas
from nephrite.cli.compare import compare
from nephrite.cli.doctor import doctor
from nephrite.cli.errors import reporting, set_debug
from nephrite.cli.materials import materials_command
from nephrite.cli.profile import profile
from nephrite.cli.render import render

app = typer.Typer(
    help="Render jade, marble, milk, skin and wax: subsurface scattering in Mitsuba 3.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("render")(reporting(render))
app.command("compare")(reporting(compare))
app.command("materials")(reporting(materials_command))
app.command("profile")(reporting(profile))
app.command("atlas")(reporting(atlas))
app.command("doctor")(reporting(doctor))


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"nephrite {__version__}")
        raise typer.Exit


@app.callback()
def _globals(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and stop.", callback=_print_version, is_eager=True),
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="End errors with a traceback.")] = False,
) -> None:
    set_debug(debug)
