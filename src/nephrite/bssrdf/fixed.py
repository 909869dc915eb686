"""Kernels that more than the reduced albedo decides: a table with rows of their own for each medium, or for all.

- A measured profile hangs on no coefficient at all. Its lengths are parts of its reach, so that the table ends with it.
- A slab's profiles hang on its thickness too: rows for the face where the light came in, and for the other one.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from nephrite.bssrdf.kernel import EDGES, EMPTY, FIRST, ROWS, STEP, Table, albedos, table
from nephrite.physics.single import single_scattering_share, slab_shares
from nephrite.profiles import multipole
from nephrite.profiles.measured import MeasuredProfile

__all__ = ["AN_OCTAVE", "PER_REACH", "measured", "slabs", "thicknesses", "totals"]

AN_OCTAVE = 4.0
"""Thicknesses of slabs in a table, for each time that they double."""

_THINNEST, _THICKEST = 2.0**-10, 2.0**10  # reduced mean free paths: beyond, a slab's profiles change no more

PER_REACH = 32.0
"""Lengths in the reach of a measured profile: a power of 2, so that an edge of the table lies there."""


@lru_cache(maxsize=16)
def measured(profiles: tuple[MeasuredProfile, ...]) -> Table:
    """Return one row for each profile, of all scattered light, with its own total; lengths in `reach / PER_REACH`."""
    lengths = np.array([[profile.reach() / PER_REACH] for profile in profiles])

    def kernel(r: np.ndarray) -> np.ndarray:
        x = r * lengths * (1.0 - 1e-9)  # to the left of the end, where a profile drops to 0
        return np.stack([profile.eval(x[i]) for i, profile in enumerate(profiles)]) * lengths**2

    rows = table(kernel, len(profiles))
    return _scaled(rows, np.array([profile.albedo() for profile in profiles]))


def _scaled(rows: Table, wanted: np.ndarray) -> Table:
    """Return the table with the totals wanted: interpolation has changed them by some thousandths."""
    ratio = np.where(wanted > 0.0, wanted, 1.0) / np.where(wanted > 0.0, totals(rows), 1.0)
    return replace(rows, log_kernel=np.maximum(rows.log_kernel + np.log2(ratio)[:, None], EMPTY))


def totals(rows: Table) -> np.ndarray:
    """Return the integral of 2 pi r kernel of each row: between edges kernel and r^2 are powers of each other."""
    mass = np.exp2(rows.log_kernel + 2.0 * (FIRST + STEP * np.arange(EDGES)))
    before, after = mass[:, :-1], mass[:, 1:]
    growth = np.log(after / before)
    even = np.abs(growth) < 1e-9
    mean = np.where(even, before, (after - before) / np.where(even, 1.0, growth))
    return math.pi * mass[:, 0] + 2.0 * math.pi * STEP * math.log(2.0) * mean.sum(axis=1)


def thicknesses(least: float, most: float) -> tuple[float, ...]:
    """Return `AN_OCTAVE` thicknesses an octave, two at least, from the least to the most and beyond."""
    first = min(max(least, _THINNEST), _THICKEST)
    octaves = math.log2(max(min(most, _THICKEST) / first, 1.0))
    return tuple(first * 2.0 ** (i / AN_OCTAVE) for i in range(2 + math.ceil(octaves * AN_OCTAVE - 1e-3)))


@lru_cache(maxsize=16)
def slabs(thicknesses: tuple[float, ...], eta: float, g: float) -> Table:
    """Return `ROWS` rows, by reduced albedo, for the face of entry of each thickness, and as many for the other face.

    Lengths, `thicknesses` too, in reduced mean free paths. The multipole's reflectance and transmittance, less what
    leaves either face after one event, over the light that scatters a second time. As in a half-space, a jump takes
    that to be `a^2 (1 - h)`, which is put back. The two faces share their poles.
    """
    tables = [_slab(thickness, eta, g) for thickness in thicknesses]
    return Table(*(np.concatenate([getattr(one, key) for one in tables]) for key in ("log_kernel", "poles")))


def _slab(thickness: float, eta: float, g: float) -> Table:
    albedo_prime = albedos()
    near = multipole.make(1.0 - albedo_prime[:, None], albedo_prime[:, None], eta, g, thickness)
    far = near.transmitted()
    extinction = 1.0 - albedo_prime + albedo_prime / (1.0 - g)
    albedo = albedo_prime / (1.0 - g) / extinction
    shares = _shares(thickness * extinction, eta, g)
    scattered = -math.expm1(-thickness)
    # in a thin sheet without an interface all leaves after one event: what little is left must not count for much
    again = (1.0 - single_scattering_share(g, eta)) / np.maximum(1.0 - shares.sum(axis=0), 0.01)
    given = np.stack([face.albedo()[:, 0] for face in (near, far)])
    wanted = (np.maximum(given / scattered - albedo * shares, 0.0) * again).ravel()
    scales = wanted / np.maximum(given.ravel(), 1e-30)

    def faces(r: np.ndarray) -> np.ndarray:
        return np.concatenate([near.eval(r), far.eval(r)]) * scales[:, None]

    both = table(lambda r: faces(r).reshape(2, ROWS, -1).sum(axis=0), ROWS)
    rows = _scaled(table(faces, 2 * ROWS), wanted)
    return replace(rows, poles=np.concatenate([both.poles] * 2))


def _shares(thickness: np.ndarray, eta: float, g: float) -> np.ndarray:
    """Return `slab_shares` of each thickness, in mean free paths: (2, N); exact if they are all the same."""
    if np.ptp(thickness) == 0.0:
        return np.repeat(np.array(slab_shares(g, eta, float(thickness[0])))[:, None], thickness.size, axis=1)
    octaves = np.log2(thickness.max() / thickness.min())
    known = np.geomspace(thickness.min(), thickness.max(), 2 + int(8 * octaves))
    values = np.array([slab_shares(g, eta, float(t)) for t in known])
    return np.stack([np.interp(thickness, known, column) for column in values.T])
