"""How many samples each pass takes, and with which seed."""

from __future__ import annotations

import math

import numpy as np

MAX_SAMPLES = 2**23
"""Most samples (pixels x spp) of one pass: they are all in memory at once."""

PREFERRED_SAMPLES = {"llvm": 2**20, "cuda": 2**23}
"""Samples of a pass in a fixed schedule, by backend: some seconds of work on a small machine, or less."""

MIN_PASSES = 8
"""Passes that a schedule aims at even where fewer would do, because the variance comes from them."""

PASS_SECONDS = 1.0
"""Time that a pass aims at when time decides."""


def floor_power(number: float) -> int:
    """Return the largest power of two up to `number`, at least 1.

    Mitsuba's own integrators have one kernel for all powers of two, and another one for each other number.
    """
    return 1 << (max(1, int(number)).bit_length() - 1)


def largest_pass(pixels: int, samples: int) -> int:
    """Return the samples per pixel, a power of two, that keep `pixels` x spp within `samples`; at least 1."""
    return floor_power(samples / max(1, pixels))


def ceil_power(number: float) -> int:
    """Return the smallest power of two that is at least `number`, at least 1."""
    return 1 << max(0, math.ceil(number) - 1).bit_length()


def chunk(total: int, pixels: int, samples: int) -> int:
    """Return the spp that most passes of a fixed schedule have.

    Args:
        total: Samples per pixel in all.
        pixels: Pixels of the picture.
        samples: Samples (pixels x spp) that a pass should have at most.
    """
    return min(largest_pass(pixels, samples), floor_power(total / MIN_PASSES))


def fixed(done: int, total: int, chunk: int) -> int:
    """Return the spp of the next pass when time does not decide: 1, 1, 2, 4 ... up to `chunk`, a rest last.

    Depends on its arguments alone, so that the same settings give the same picture on any machine.
    """
    return min(chunk, floor_power(done), floor_power(total - done))


def timed(seconds_per_spp: float, remaining_s: float, previous: int, largest: int) -> int:
    """Return the spp of the next pass when time decides: about one second of work, and within what remains.

    Args:
        seconds_per_spp: Measured on the passes so far.
        remaining_s: Time left.
        previous: Samples per pixel of the last pass; no pass has more than four times as many.
        largest: Most samples per pixel of a pass.

    Returns:
        A power of two, or 0 if not even one sample per pixel fits into the time.
    """
    fitting = min(PASS_SECONDS, remaining_s) / max(seconds_per_spp, 1e-9)
    if fitting < 1:
        return 1 if remaining_s >= seconds_per_spp else 0
    return min(floor_power(fitting), 4 * previous, largest)


def first_seed(seed: int) -> int:
    """Return the 32 bit seed of the first pass; pass number i has the i-th one after it, modulo 2^32.

    So no two passes of a render share a seed, and renders of different seeds start far from each other.
    """
    return int(np.random.SeedSequence(seed).generate_state(1)[0])
