"""The command as a whole: version, help, speed of starting, and how errors are shown."""

from __future__ import annotations

import subprocess
import sys

import pytest
import typer
from typer.testing import CliRunner

from nephrite import __version__
from nephrite.cli import errors
from nephrite.cli.app import app
from nephrite.errors import MeshError, ParameterError

# Mitsuba itself is loaded with the package, which makes its plugins known to it.
SLOW = ("trimesh", "scipy", "PIL", "pyoidn", "pymeshfix", "matplotlib")


def test_the_version_is_printed() -> None:
    result = CliRunner().invoke(app, ["--version"])
    assert (result.exit_code, result.output.strip()) == (0, f"nephrite {__version__}")


@pytest.mark.parametrize("command", ["render", "compare", "materials", "profile", "atlas", "doctor"])
def test_every_command_has_help(command: str) -> None:
    result = CliRunner().invoke(app, [command, "--help"])
    assert result.exit_code == 0
    assert "Usage: " in result.output


def test_help_loads_nothing_slow() -> None:
    program = f"import nephrite.cli.app, sys; print([m for m in {SLOW!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_starting_sets_no_variant() -> None:
    program = "import nephrite.cli.app, mitsuba as mi; print(mi.variant())"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "None"


def failing(error: BaseException):
    """A command that raises `error`."""
    small = typer.Typer(pretty_exceptions_enable=False)

    @small.command()
    def command() -> None:
        raise error

    wrapped = typer.Typer(pretty_exceptions_enable=False)
    wrapped.command()(errors.reporting(small.registered_commands[0].callback))
    return CliRunner().invoke(wrapped, [])


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (ParameterError("sigma_a is negative"), 1, "Error: sigma_a is negative"),
        (MeshError("no faces"), 1, "Error: no faces"),
        (RuntimeError("bang"), 1, "RuntimeError: bang"),
        (KeyError("bang"), 1, "nephrite doctor"),
        (KeyboardInterrupt(), 130, "Stopped"),
        (typer.Exit(7), 7, ""),
        (typer.BadParameter("wrong"), 2, "wrong"),
    ],
)
def test_errors_become_a_message_and_an_exit_code(error: BaseException, code: int, says: str) -> None:
    result = failing(error)
    assert result.exit_code == code
    assert says in result.output
    assert "Traceback" not in result.output


def test_debug_shows_where(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NEPHRITE_DEBUG", "1")
    assert isinstance(failing(ParameterError("bang")).exception, ParameterError)
    assert isinstance(failing(RuntimeError("bang")).exception, RuntimeError)
