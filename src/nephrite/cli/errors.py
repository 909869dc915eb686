"""What a person sees when a command fails: one red paragraph, and the right exit code."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable
from typing import TypeVar

import typer

from nephrite.errors import NephriteError

FAILED = 1
INTERRUPTED = 130
ISSUES = "the project's issue tracker"

T = TypeVar("T")
_DEBUG = "NEPHRITE_DEBUG"


def set_debug(wanted: bool) -> None:
    """Let unexpected errors, and expected ones, end with a traceback."""
    os.environ[_DEBUG] = "1" if wanted else ""


def reporting(command: Callable[..., T]) -> Callable[..., T]:
    """Wrap a `command` so that its errors become a message and an exit code.

    A `NephriteError` says itself what to do; anything else is a fault of ours, and the message says how to
    report it. Typer's own exceptions (usage errors, exits) pass.
    """

    @functools.wraps(command)
    def wrapped(*args: object, **kwargs: object) -> T:
        try:
            return command(*args, **kwargs)
        except NephriteError as error:
            if os.environ.get(_DEBUG):
                raise
            complain(str(error))
            raise typer.Exit(FAILED) from None
        except KeyboardInterrupt:
            complain("Stopped: nothing was written.")
            raise typer.Exit(INTERRUPTED) from None
        except (typer.Exit, typer.Abort, typer.BadParameter):
            raise
        except Exception as error:
            if os.environ.get(_DEBUG):
                raise
            complain(
                f"Nephrite failed in a way that it should not ({type(error).__name__}: {error}). Run the "
                "same command as `nephrite --debug ...` to see where, and please report that, with the "
                f"output of `nephrite doctor`, to {ISSUES}."
            )
            raise typer.Exit(FAILED) from None

    return wrapped


def complain(message: str) -> None:
    """Print `message` to the standard error stream as one red paragraph."""
    _say(message, "red", "Error: ")


def warn(message: str) -> None:
    """Print `message` to the standard error stream as one yellow paragraph."""
    _say(message, "yellow", "Note: ")


def _say(message: str, colour: str, prefix: str) -> None:
    from rich.console import Console
    from rich.text import Text

    Console(file=sys.stderr).print(Text(prefix + message, style=colour))
