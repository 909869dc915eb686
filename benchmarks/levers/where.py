"""Where the time of a picture goes: compiling, kernels, NumPy and Python; parts of a precomputation; rays by kind."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest import mock

import drjit as dr
import mitsuba as mi

from nephrite.plugins import transport

PARTS = {
    "nodes": (transport, "lay"),
    "what the camera sees": (transport, "seen"),
    "walks": (transport.walked, "walk"),
    "counting": (transport.Pyramid, "of"),
    "light": (transport.Transport, "relight"),
}
"""What `transport` does before its first sample, and the functions that do it."""

RAYS = {
    "steps and segments": "ray_intersect_preliminary",
    "shadow rays": "ray_test",
    "to lamps and surfaces": "ray_intersect",
}
"""Kinds of rays, and the methods of a scene that trace them."""


def where(picture: Callable[[int], Any], samples: int) -> dict[str, Any]:
    """Return seconds of a first and a second `picture` of so many `samples`, and rays a sample.

    `compiling`: in the first; all others in the second: `kernels`, `parts` of a precomputation, which have kernels too,
    and `all`.
    """
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        picture(0)
        compiling = _seconds("codegen_time", "backend_time")
        parts = dict.fromkeys(PARTS, 0.0)
        with _replaced({of: _timed(parts, name, of) for name, of in PARTS.items()}):
            start = time.perf_counter()
            picture(1)
            whole = time.perf_counter() - start
        kernels = _seconds("execution_time")
    found = {"compiling": compiling, "kernels": kernels, "parts": parts, "all": whole}
    return found | {"rays": _rays(picture, samples)}


def _seconds(*kinds: str) -> float:
    history = dr.kernel_history()  # which forgets it
    return sum(one.get(kind, 0.0) for one in history for kind in kinds) / 1e3


def _rays(picture: Callable[[int], Any], samples: int) -> dict[str, float]:
    """Return how many rays of each kind a sample has."""
    counts = {name: dr.zeros(mi.UInt64, 1) for name in RAYS}
    with _replaced({(mi.Scene, method): _counted(counts[name], method) for name, method in RAYS.items()}):
        picture(2)
    return {name: int(count[0]) / samples for name, count in counts.items()}


def _counted(count: Any, method: str) -> Callable[..., Any]:
    original = getattr(mi.Scene, method)

    def traced(scene: Any, ray: Any, *given: Any, **named: Any) -> Any:
        last = given[-1] if given and isinstance(given[-1], mi.Bool) else named.get("active", mi.Bool(True))
        dr.scatter_add(count, mi.UInt64(1), mi.UInt32(0), last)
        return original(scene, ray, *given, **named)

    return traced


def _timed(parts: dict[str, float], name: str, of: tuple[Any, str]) -> Callable[..., Any]:
    original = getattr(*of)

    def timed(*given: Any, **named: Any) -> Any:
        start = time.perf_counter()
        result = original(*given, **named)
        dr.sync_thread()
        parts[name] += time.perf_counter() - start
        return result

    return timed


@contextmanager
def _replaced(new: dict[tuple[Any, str], Any]) -> Iterator[None]:
    """Replace functions of modules and classes for a while."""
    with ExitStack() as stack:
        for (owner, name), function in new.items():
            stack.enter_context(mock.patch.object(owner, name, function))
        yield
