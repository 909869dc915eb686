"""The package's exceptions. Each message says what is wrong, where, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class NephriteError(Exception):
    """Base of every error that Nephrite raises on purpose."""


class ParameterError(NephriteError, ValueError):
    """A parameter has a value that it cannot have; names the parameter, its value and the remedy."""


class MeshError(NephriteError, ValueError):
    """A mesh file cannot be read, or holds no surface that could be rendered."""


class MissingDependencyError(NephriteError, RuntimeError):
    """Something that this machine lacks (LLVM, npm, a device); says how to get it."""


class VariantError(NephriteError, RuntimeError):
    """The Mitsuba variant in use cannot run this."""


def unknown_name(what: str, name: str, known: Iterable[str]) -> ParameterError:
    """Build the error for an unknown `name` of a `what`, suggesting the nearest of the `known` names."""
    choices = sorted(known)
    by_fold = {choice.casefold(): choice for choice in choices}
    near = get_close_matches(name.casefold(), by_fold, n=1, cutoff=0.5)
    hint = f" Did you mean {by_fold[near[0]]!r}?" if near else ""
    return ParameterError(f"unknown {what} {name!r}.{hint} Known: {', '.join(choices)}.")
