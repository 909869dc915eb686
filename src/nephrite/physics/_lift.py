"""Let derivatives pass through what NumPy computes from a number or two: tables, fits, special functions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from nephrite.physics._arrays import namespace

_STEP = 1e-5

Moves = list[tuple[Any, Any, Any]]
"""For each number that has a derivative: its move, 0 but for that, and the results one and two steps above it."""


def checked(check: Callable[[Any], float], number: Any) -> Any:
    """Return `check(number)`; a Dr.Jit array of one entry as it is, once that has been checked."""
    if not hasattr(namespace(number), "detach"):
        return check(number)
    check(_entry(number) if len(number) == 1 else list(number))
    return number


def lift(function: Callable[..., Any], *numbers: Any) -> Any:
    """Return `function(*numbers)`, with derivatives if some are Dr.Jit arrays of one entry.

    `function` takes floats and returns floats, NumPy arrays (N,), or tuples or dataclasses of such. Its slope is a
    difference of second order upwards: tables begin at what is most common, a matched surface and no mean cosine.
    """
    xp = namespace(*numbers)
    if not hasattr(xp, "detach"):
        return function(*numbers)
    entries = [_entry(number) for number in numbers]
    moves: Moves = []
    for i, number in enumerate(numbers):
        if xp.is_array_v(number) and xp.grad_enabled(number):
            above = [[*entries[:i], entries[i] + k * _STEP, *entries[i + 1 :]] for k in (1, 2)]
            move = number - xp.detach(number)
            # Dr.Jit 1.5 stretches a literal 0 in place when it is multiplied by an array
            xp.make_opaque(move)
            moves.append((move, function(*above[0]), function(*above[1])))
    kind = next(type(number) for number in numbers if xp.is_array_v(number))
    return _moved(kind, function(*entries), moves)


def alike(value: Any, *numbers: Any) -> Any:
    """Return `value` as a Dr.Jit array if one of the numbers is: NumPy's numbers do not mix with those."""
    for number in numbers:
        if hasattr(namespace(number), "detach"):
            value = value + 0.0 * namespace(number).detach(number)
    return value


def _entry(number: Any) -> Any:
    """Return the entry of an array that has one; what is no array, as it is."""
    return float(number[0]) if hasattr(namespace(number), "detach") else number


def _moved(kind: type, start: Any, moves: Moves) -> Any:
    """Return `start` as Dr.Jit arrays, linear in the moves."""
    if isinstance(start, tuple):
        return tuple(
            _moved(kind, part, [(move, one[i], two[i]) for move, one, two in moves])
            for i, part in enumerate(start)
        )
    if dataclasses.is_dataclass(start) and not isinstance(start, type):
        names = [field.name for field in dataclasses.fields(start)]
        parts = {
            name: _moved(
                kind,
                getattr(start, name),
                [(move, getattr(one, name), getattr(two, name)) for move, one, two in moves],
            )
            for name in names
        }
        return dataclasses.replace(start, **parts)
    if not isinstance(start, float | np.ndarray):
        return start
    value = kind(start)
    for move, one, two in moves:
        value = value + kind((4.0 * one - two - 3.0 * start) / (2.0 * _STEP)) * move
    return value
