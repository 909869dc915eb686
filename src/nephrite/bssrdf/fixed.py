"""Kernels that more than the reduced albedo decides: a table with rows of their own for each medium, or for all.

- A measured profile hangs on no coefficient at all. Its lengths are parts of its reach, so that the table ends with it.
- A slab's profiles hang on its thickness too: one row for the face where the light came in, one for the other.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from nephrite.bssrdf.kernel import EDGES, FIRST, STEP, Table, table
from nephrite.physics.single import single_scattering_share, slab_shares
from nephrite.profiles import multipole
from nephrite.profiles.measured import MeasuredProfile

__all__ = ["PER_REACH", "measured", "slab", "totals"]

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
    return replace(rows, log_kernel=rows.log_kernel + np.log2(ratio)[:, None])


def totals(rows: Table) -> np.ndarray:
    """Return the integral of 2 pi r kernel of each row: between edges kernel and r^2 are powers of each other."""
    mass = np.exp2(rows.log_kernel + 2.0 * (FIRST + STEP * np.arange(EDGES)))
    before, after = mass[:, :-1], mass[:, 1:]
    growth = np.log(after / before)
    even = np.abs(growth) < 1e-9
    mean = np.where(even, before, (after - before) / np.where(even, 1.0, growth))
    return math.pi * mass[:, 0] + 2.0 * math.pi * STEP * math.log(2.0) * mean.sum(axis=1)


@lru_cache(maxsize=256)
def slab(albedo_prime: float, thickness: float, eta: float, g: float) -> Table:
    """Return two rows: what leaves the face of entry, and the other one; lengths in reduced mean free paths.

    The multipole's reflectance and transmittance, less what leaves either face after one event, over the light that
    scatters a second time. As in a half-space, a jump takes that to be `a^2 (1 - h)`, which is put back. The rows share
    their poles.
    """
    near = multipole.make(1.0 - albedo_prime, albedo_prime, eta, g, thickness)
    far = near.transmitted()
    extinction = 1.0 - albedo_prime + albedo_prime / (1.0 - g)
    albedo = albedo_prime / (1.0 - g) / extinction
    shares = slab_shares(g, eta, thickness * extinction)
    scattered = -math.expm1(-thickness)
    # in a thin sheet without an interface all leaves after one event: what little is left must not count for much
    again = (1.0 - single_scattering_share(g, eta)) / max(1.0 - sum(shares), 0.01)
    given = np.array([face.albedo() for face in (near, far)])
    wanted = np.maximum(given / scattered - albedo * np.array(shares), 0.0) * again
    scales = wanted / np.maximum(given, 1e-30)

    def faces(r: np.ndarray) -> np.ndarray:
        return np.concatenate([near.eval(r), far.eval(r)]) * scales[:, None]

    both = table(lambda r: faces(r).sum(axis=0, keepdims=True), 1)
    rows = _scaled(table(faces, 2), wanted)
    return replace(rows, poles=np.repeat(both.poles, 2, axis=0))
