"""How much jumps bring, at each place of an object, and how much they should: found before anything is rendered.

A profile knows planes without end. In a fold, or on both sides of a thin part, more surface lies within its reach than
on a plane, and jumps bring more light than arrives; on a small or convex body they bring less than there is, as light
that a plane would have absorbed far below gets out at a side. Jumps from random points of the object tell how much
they bring. Two rules:

- Models of the literature are left as they are, but make no energy. Where they would, e is by how much, and 1
  elsewhere; a jump between x and y is divided by the greater of e(x) and e(y), so that no point sends out more than
  arrives.
- The tabulated profile belongs to the object: walks from random points tell how much there is (see `walked`). e is
  what jumps bring over what walks do, and a jump is divided by sqrt(e(x) e(y)); a few rounds of that (symmetric
  Sinkhorn balancing) make the object as bright as it is under an even sky, everywhere.

Light between two points stays reciprocal in both.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from nephrite.plugins import jumped, walked
from nephrite.plugins.field import Found, Grid
from nephrite.plugins.media import JUMP, Media
from nephrite.plugins.shapes import mean_chord, start, surface_points

MOST = 0.985  # of the light that arrives: what is left covers the estimate's noise
_KEPT = 0.995  # of what walks bring, likewise

_JUMPS = 1 << 18  # from each shape
_WALKS = 1 << 18
_LEAST_WALKS = 1 << 13
_EVENTS = 6e7  # of all walks, about: what they may cost
_STEPS = (2.0, 1.0, 1.0)  # leave at most 4 % of a difference, however it varies from place to place
_BOUND = 3.0  # of |log2 e|


def fingerprint(media: Media) -> tuple[Any, ...]:
    """Return what jumps and transport depend on, as far as can be told at once: forms, sizes, coefficients, models."""
    found: list[Any] = [mi.variant(), media.diffusion, *media.models]
    for entry in media.entries:
        found += [entry.eta, entry.g]
        for shape in entry.shapes:
            si = surface_points(shape, mi.Point2f(0.3, 0.6), mi.Float(0.5))
            values = [*entry.coefficients(si, True), shape.surface_area(), si.p]
            found += [float(x) for value in values for x in np.ravel(np.array(value))]
            found += [float(x) for corner in (shape.bbox().min, shape.bbox().max) for x in corner]
    return tuple(found)


def balance(media: Media, scene: Any) -> None:
    """Set `media.balance` for the objects whose light jumps."""
    for number, model in enumerate(media.models, start=1):
        entry = media.entries[number - 1]
        if model != JUMP or entry.least_reach > 0:  # instances are one shape in many places
            continue
        bbox = mi.ScalarBoundingBox3f()
        for shape in entry.shapes:
            bbox.expand(shape.bbox())
        grid = Grid(bbox)
        truth = _walked(media, number, scene) if media.kernels.finite else None
        logarithm = np.zeros(())
        for step in _STEPS if truth else (1.0,):
            brought = _brought(media, number, scene)
            if truth:
                apart = grid.logarithm(brought, truth) - math.log2(_KEPT)
                logarithm = np.clip(logarithm + step * apart, -_BOUND, _BOUND)
            else:
                # by both ends, where a mean over them is taken: that is by the greater, or more
                ends = 2.0 if media.kernels.finite else 1.0
                logarithm = ends * np.maximum(grid.logarithm(brought) - math.log2(MOST), 0.0)
            media.balance.put(number, grid, logarithm)


def _brought(media: Media, number: int, scene: Any) -> Found:
    """Return what jumps bring of the light that arrives."""
    parts = []
    for shape in media.entries[number - 1].shapes:
        sampler = _sampler(_JUMPS, 0)
        begun = start(scene, media.winding, shape, sampler)
        brought = jumped.jump_once(media, number, scene, sampler, begun)
        dr.eval(begun.si.p, brought)
        values = np.array(brought).T
        parts.append((np.array(begun.si.p).T, values, np.ones_like(values)))
    return _found(parts)


def _walked(media: Media, number: int, scene: Any) -> Found | None:
    """Return what walks bring of the light that arrives, to the power of -1; None if they are too long."""
    entry, parts = media.entries[number - 1], []
    for shape in entry.shapes:
        count = int(min(_EVENTS / _events(entry, shape), _WALKS))
        if count < _LEAST_WALKS:
            return None
        begun = start(scene, media.winding, shape, _sampler(count, 1))
        ends = walked.walk(scene, 2, entry, begun.si, shape, dr.arange(mi.UInt32, count))
        parts.append(tuple(np.array(part).T for part in (begun.si.p, ends.weight, ends.twice)))
    return replace(_found(parts), power=-1.0)


def _found(parts: list[tuple[np.ndarray, ...]]) -> Found:
    """Put together points, values and weights of the shapes."""
    points, values, weights = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Found(points, values, weights)


def _sampler(count: int, seed: int) -> Any:
    sampler: Any = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    return sampler


def _events(entry: Any, shape: Any) -> float:
    """Return how often a walk scatters, about: without absorption eta^2 4 V / S sigma_t times (Cauchy)."""
    sigma_a, sigma_s = entry.mean_coefficients()
    sigma_t = np.maximum(sigma_a + sigma_s, 1e-30)
    free = mean_chord(shape) * sigma_t * entry.eta**2
    absorbed = 3.0 / np.maximum(sigma_a / sigma_t, 1e-9)
    return float(np.max(np.minimum(free, absorbed))) + 2.0
