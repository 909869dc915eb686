"""Integrate a profile over the plane and draw radii from it, given nothing but its values.

All sums run over ln(r), evenly: 2 pi r^2 R(r) is smooth there and vanishes at both ends, so that the trapezoidal rule
converges faster than any power of the step. Profiles that are piecewise or wild should bring closed forms.
With Dr.Jit arrays the sums are loops of the kernel, differentiable in both modes; no table is stored, so that the
functions work inside other loops too, though there without derivatives (Dr.Jit 1.5 aborts on loops in loops with them).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from nephrite.physics._arrays import namespace

__all__ = ["Part", "invert", "total", "within"]

_STEP = 0.14
_FIRST = (
    -15.0
)  # ln(r / reach) of the first node: r^2 R is 3e-7 of its peak at most, if R grows no faster than 1/r
_COUNT = (
    178  # up to ln(r / reach) = 9.8, beyond which a tail of r^-3 holds 6e-5 of what it holds beyond the reach
)
_BISECTIONS = 26
_BLOCK = 2**20  # numbers that NumPy is given at once


Part = Callable[[Any, Any], Any]
"""Term k of a profile at r: a profile is the sum of some such terms."""


def total(part: Part, parts: int, reach: Any) -> Any:
    """Return the integral of 2 pi r R(r) over all r; `reach`: a length that sets the scale.

    R(r) is the sum of `part(r, k)` for k = 0 ... parts - 1; both sums are one, for a loop in a loop has no derivative.
    """
    mass = _mass(part, reach)
    return _sum(parts, lambda x, k: _STEP * mass(x, k), mass(0.0, 0.0))


def within(part: Part, parts: int, reach: Any, r: Any) -> Any:
    """Return the share of `total` within r.

    The integral of the cubic interpolant (Keys 1981) of 2 pi r^2 R over ln(r): each node adds its value times a
    smoothed step around it.
    """
    mass, reach = _mass(part, reach), _detached(reach)
    xp = namespace(r, reach)
    x = xp.log(xp.maximum(r, 1e-30) / reach)
    blank = mass(0.0, 0.0)
    inside = _sum(
        parts, lambda node, k: _STEP * mass(node, k) * _smooth_step((x - node) / _STEP), blank + 0.0 * x
    )
    whole = _sum(parts, lambda node, k: _STEP * mass(node, k), blank)
    xp = namespace(inside, whole)
    return xp.minimum(xp.maximum(inside / xp.maximum(whole, 1e-30), 0.0), 1.0)


def invert(part: Part, parts: int, reach: Any, share: Any) -> Any:
    """Return the radius within which `share` of `total` lies; has no derivative.

    One walk over the nodes finds the cell where the integral passes the share, bisection of the interpolant the
    place in it.
    """
    xp = namespace(share, reach)
    if hasattr(xp, "suspend_grad"):
        with xp.suspend_grad():
            return _inverted(part, parts, reach, share)
    return _inverted(part, parts, reach, share)


def _inverted(part: Part, parts: int, reach: Any, share: Any) -> Any:
    target = share * total(part, parts, reach)
    mass = _tabulated(_mass(part, reach), parts, target)
    xp = namespace(target)
    blank = 0.0 * target

    def walk(node: Any, below: Any, *state: Any) -> tuple[Any, ...]:
        # the window holds the masses at the cell's two ends and one node beyond each
        window, found = (*state[1:4], mass(node + 2.0) + blank), state[4:]
        cell = _cell(window, 1.0)
        here = (target >= below) & (cell > 0.0)
        candidate = (node + blank, target - below, *window)
        found = tuple(xp.select(here, new, old) for new, old in zip(candidate, found, strict=True))
        return (node + 1.0, below + cell, *window, *found)

    state = _repeat(_COUNT, walk, (_counter(blank),) + (blank,) * 11)
    node, rest, window = state[6], state[7], state[8:]
    low, high = blank, blank + 1.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        less = _cell(window, middle) < rest
        low, high = xp.select(less, middle, low), xp.select(less, high, middle)
    return reach * xp.exp(_FIRST + _STEP * (node + 0.5 * (low + high)))


def _tabulated(mass: Part, parts: int, like: Any) -> Callable[[Any], Any]:
    """Return the mass at a node, all parts: by a loop in the kernel, with NumPy from a table that is made at once."""
    if not hasattr(namespace(like), "while_loop"):
        nodes = np.arange(_COUNT + 2.0).reshape(-1, *[1] * np.ndim(mass(0.0, 0.0)))
        table: Any = sum(mass(_FIRST + _STEP * nodes, k) for k in range(parts))
        return lambda node: table[int(node)]
    if parts == 1:
        return lambda node: mass(_FIRST + _STEP * node, 0.0)

    def at(node: Any) -> Any:
        start = (_counter(like), 0.0 * like)
        return _repeat(parts, lambda k, result: (k + 1.0, result + mass(_FIRST + _STEP * node, k)), start)[1]

    return at


def _mass(part: Part, reach: Any) -> Part:
    """Return a term of 2 pi r^2 R as a function of ln(r / reach): the mass per unit of it."""
    reach = _detached(reach)

    def mass(x: Any, k: Any) -> Any:
        r = reach * namespace(x, reach).exp(x)
        return 2.0 * math.pi * r * r * part(r, k)

    return mass


def _smooth_step(t: Any) -> Any:
    """Integral of Keys's interpolating cubic (a = -1/2) from -2 to t: from 0 to 1, 1/2 at 0."""
    xp = namespace(t)
    s = xp.minimum(xp.abs(t), 2.0)
    near = s * (1.0 + s * s * (0.375 * s - 5.0 / 6.0))
    far = s * (2.0 + s * (-2.0 + s * (5.0 / 6.0 - 0.125 * s))) - 1.0 / 6.0
    half = xp.select(s < 1.0, near, far)
    return 0.5 + xp.select(t < 0.0, -half, half)


def _cell(window: tuple[Any, ...], t: Any) -> Any:
    """Integral of the cubic interpolant over the part [0, t] of a cell, t in [0, 1]."""
    before, a, b, after = window
    linear = 0.5 * (b - before)
    square = before - 2.5 * a + 2.0 * b - 0.5 * after
    cubic = 0.5 * (after - before) + 1.5 * (a - b)
    return _STEP * t * (a + t * (linear / 2.0 + t * (square / 3.0 + t * cubic / 4.0)))


def _sum(parts: int, term: Callable[[Any, Any], Any], blank: Any) -> Any:
    """Sum `term(x, k)` over the nodes x and k = 0 ... parts - 1; `blank` has the type and size of a term."""
    xp = namespace(blank)
    if not hasattr(xp, "while_loop"):
        nodes = (_FIRST + _STEP * np.arange(_COUNT)).reshape(-1, *[1] * np.ndim(blank))
        blocks = np.array_split(nodes, min(_COUNT, 1 + _COUNT * np.size(blank) // _BLOCK))
        return sum(np.sum(term(block, k), axis=0) for block in blocks for k in range(parts))
    result, _, _ = _repeat(
        _COUNT * parts,
        lambda result, node, k: (
            result + term(_FIRST + _STEP * node, k),
            node + xp.select(k == parts - 1, 1.0, 0.0),
            xp.select(k == parts - 1, 0.0, k + 1.0),
        ),
        (xp.zeros(type(blank), xp.width(blank)), _counter(blank), _counter(blank)),
    )
    return result


def _repeat(count: int, body: Callable[..., tuple[Any, ...]], state: tuple[Any, ...]) -> tuple[Any, ...]:
    """Apply `state = body(*state)` count times: as a loop of the kernel if the state is of Dr.Jit arrays."""
    xp = namespace(*state)
    if not hasattr(xp, "while_loop"):
        for _ in range(count):
            state = body(*state)
        return state
    _, *rest = xp.while_loop(
        (_counter(state[0]), *state),
        lambda n, *_: n < count,
        lambda n, *inner: (n + 1.0, *body(*inner)),
        max_iterations=-1,
    )
    return tuple(rest)


def _counter(like: Any) -> Any:
    """Zero to count from: a number, or a Dr.Jit array of one dimension."""
    xp = namespace(like)
    return xp.detached_t(xp.leaf_t(type(like)))(0) if hasattr(xp, "leaf_t") else 0.0


def _detached(value: Any) -> Any:
    xp = namespace(value)
    return xp.detach(value) if hasattr(xp, "detach") else value
